#include <gtest/gtest.h>
#include "exact_scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
std::uint32_t rejected(const FrameReport& r, Reject why)
{
  return r.rejected[static_cast<std::size_t>(why)];
}
}  // namespace

TEST(Stage1Accept, CountsEveryRejectedPointByItsReason)
{
  const float nan = std::nanf(""), inf = INFINITY;
  Parameters p;
  p.body_boxes_m = {{-0.4, 0.4, -0.3, 0.3, -0.6, 0.1}};
  p.max_range_m = 20;
  Scan s(0, 0, 0.7);
  s.x_ = {1, nan, 1, 0, 30, 1, 1, 0.3f, 10, inf};
  s.y_ = {1, 0, inf, 0, 0, 1, 1, 0, 0, inf};
  s.z_ = {-0.7f, 0, 0, 0, 0, 1.6f, -3.1f, -0.2f, -0.7f, inf};
  TestMap m(p);
  const FrameReport r = m.update(s);
  EXPECT_EQ(r.points_in, 10u);
  EXPECT_EQ(r.points_accepted, 1u);
  EXPECT_EQ(rejected(r, Reject::NotFinite), 3u);
  EXPECT_EQ(rejected(r, Reject::Range), 2u);  // a zero-range return, and one at 30 m
  EXPECT_EQ(rejected(r, Reject::Height), 2u);
  EXPECT_EQ(rejected(r, Reject::Body), 1u);
  EXPECT_EQ(rejected(r, Reject::Outside), 1u);
}

TEST(Stage1Accept, ARayThatEndsAboveTheHeightBandTellsThatItsWayIsFree)
{
  Scan post, beyond;
  for (double z = 0; z < 1.95; z += 0.1) post.add(2.025, 0.025, z);
  TestMap m(post);
  ASSERT_NEAR(m.elevation(2.025, 0.025), 1.9, 1e-3);
  beyond.add(3.525, 0.025, 2.4);  // the ray is 1.7 m high where the post stood
  for (int i = 0; i < 3; i++) EXPECT_EQ(rejected(m.update(beyond), Reject::Height), 1u);
  EXPECT_NEAR(m.elevation(2.025, 0.025), 0.0, 1e-3);
}

TEST(Stage1Accept, TheHeightBandIsClosedAndMeasuredFromTheSensorAlongTheZAxisOfTheMap)
{
  Scan ends(0, 0, 10);
  ends.add(1, 1, 9).add(1.5, 1, 11.5);
  TestMap m(ends);
  EXPECT_EQ(m.update(ends).points_accepted, 2u) << "its ends are in it";
  EXPECT_FLOAT_EQ(m.ground(1, 1), 9.0f);
  // A camera that looks down by half a right angle: far along its axis is deep below it.
  Scan s(0, 0, 5);
  const double tilt = M_PI / 4, c = std::cos(tilt);
  s.pose_.m = {c, 0, c, 0, 0, 1, 0, 0, -c, 0, c, 5};
  s.x_ = {4.2f, 4.3f, 1, 1};
  s.y_ = {0, 0, 0, 0};
  s.z_ = {0, 0, 3.1f, 3.2f};  // 2.97 and 3.04 m below the sensor, 1.48 and 1.56 above
  const FrameReport r = TestMap().update(s);
  EXPECT_EQ(r.points_accepted, 2u);
  EXPECT_EQ(rejected(r, Reject::Height), 2u);
}

TEST(Stage1Accept, BoxesOfTheBodyAreInTheFrameOfTheBaseForEverySensor)
{
  Parameters p;
  p.min_range_m = 0.01;
  p.body_boxes_m = {{-0.5, 0.5, -0.3, 0.3, 0.0, 0.6}, {0.4, 0.6, -0.1, 0.1, 0.6, 0.9}};
  TestMap m(p);
  // One looks ahead from the front, one to the rear from behind, 1 m above the ground.
  Scan front(0.5, 0, 1.0), rear(-0.5, 0, 1.0);
  rear.pose_.m = {-1, 0, 0, -0.5, 0, -1, 0, 0, 0, 0, 1, 1.0};
  front.x_ = {-0.1f, -0.3f, 0.2f, 0.05f, -0.8f};  // of the base: 0.4, 0.2, 0.7, 0.55, -0.3
  front.y_ = {0, 0, 0, 0, 0.31f};
  front.z_ = {-0.5f, -0.3f, -0.5f, -0.2f, -0.9f};  // 0.5, 0.7 above the first box, 0.5, 0.8, 0.1
  rear.x_ = {-0.1f, 0.2f, -0.2f};  // of the base: -0.4, -0.7, -0.3
  rear.y_ = {0.1f, 0, -0.25f};
  rear.z_ = {-0.6f, -0.6f, -0.45f};
  Frame f = front.frame();
  f.T_base_sensor = front.pose_;
  FrameReport r = m.map.update(f);
  EXPECT_EQ(rejected(r, Reject::Body), 2u);
  EXPECT_EQ(r.points_accepted, 3u);
  f = rear.frame();
  f.sensor = 1;
  f.T_base_sensor = rear.pose_;
  r = m.map.update(f);
  EXPECT_EQ(rejected(r, Reject::Body), 2u);
  EXPECT_EQ(r.points_accepted, 1u);
}

TEST(Stage1Accept, PointsFallIntoTheCellBelowThemOnBothSidesOfZero)
{
  TestMap m(Scan().add(0.051, -0.051, 0.01).add(-0.001, -0.001, 0.02).add(0.001, 0.001, 0.03));
  EXPECT_NEAR(m.ground(0.075, -0.075), 0.01f, 1e-6);
  EXPECT_NEAR(m.ground(-0.025, -0.025), 0.02f, 1e-6);
  EXPECT_NEAR(m.ground(0.025, 0.025), 0.03f, 1e-6);
}

TEST(Stage1Accept, PerPointTimesUndoTheMotionDuringTheScan)
{
  // The sensor drives 1 m/s along x and sees the spot (2.01, 0.51, 0) first and 0.1 s later.
  Scan s(0, 0, 0.7);
  s.x_ = {2.01f, 2.01f - 0.1f};
  s.y_ = {0.51f, 0.51f};
  s.z_ = {-0.7f, -0.7f};
  const std::vector<float> times{0.0f, 0.1f};
  Frame f = s.frame();
  f.time_s = times.data();
  f.path = {{0.0, translation(0, 0, 0.7)}, {0.1, translation(0.1, 0, 0.7)}};
  TestMap m;
  m.map.update(f);
  int measured = 0;
  for (float v : m.map.layer(Layer::State)) measured += v == 1.0f;
  EXPECT_EQ(measured, 1);
  EXPECT_EQ(m.state(2.01, 0.51), CellState::Measured);
}

TEST(Stage1Accept, TheVoxelFilterKeepsOnePointAVoxelWhateverTheOrder)
{
  Parameters p;
  p.voxel_m = 0.05;
  Random random(7), order(8);
  Scan scan;
  for (int i = 0; i < 4000; i++)
    scan.add(random.uniform(1.0, 1.5), random.uniform(1.0, 1.5), random.uniform(0.0, 0.1));
  TestMap a(p), b(p);
  const FrameReport report = a.update(scan);
  b.update(shuffled(scan, order));
  // 11 x 11 x 3 voxels of the sensor frame overlap the region at most.
  EXPECT_LE(report.points_accepted, 363u);
  EXPECT_GE(report.points_accepted, 200u);
  EXPECT_EQ(report.points_accepted + rejected(report, Reject::Voxel), 4000u);
  EXPECT_EQ(a.map.save(), b.map.save());
}

TEST(Stage1Accept, AReflectionFromBelowSeenGroundIsCountedAndDropped)
{
  Scan ground = Scan().add_surface(1.0, -1.0, 3.8, 1.0, flat);
  TestMap m(ground);
  Scan mirrored = ground;
  mirrored.add(3.425, 0.025, -0.25).add(3.425, 0.225, -0.25);
  const FrameReport r = m.update(mirrored);
  EXPECT_EQ(rejected(r, Reject::Buried), 2u);
  EXPECT_NEAR(m.ground(3.425, 0.025), 0.0, 1e-4);
}

TEST(Stage1Accept, OneWrongCellBuriesNothingAndTwoThatAgreeDo)
{
  for (const bool two : {false, true})
  {
    Scan wrong = Scan().add(2.025, 0.025, 0.6);
    if (two) wrong.add(2.425, 0.025, 0.6);
    TestMap m(wrong);
    const FrameReport r = m.update(wrong.add(3.425, 0.025, 0.0));
    EXPECT_EQ(rejected(r, Reject::Buried), two ? 1u : 0u);
  }
}

TEST(Stage1Accept, WhatOneFrameSaysOfReflectionsTheNextForgets)
{
  // With the ground before it in the scan a point is buried; without, it is the floor of a ditch.
  Scan ground, both, alone;
  ground.add_surface(1.0, -1.0, 3.0, 1.0, flat);
  TestMap m(ground);
  both.add_surface(1.0, -1.0, 3.0, 1.0, flat).add(3.425, 0.025, -0.6);
  alone.add(3.425, 0.025, -0.6);
  EXPECT_EQ(rejected(m.update(both), Reject::Buried), 1u);
  EXPECT_EQ(rejected(m.update(alone), Reject::Buried), 0u);
  EXPECT_NEAR(m.ground(3.425, 0.025), -0.6, 1e-3);
}

TEST(Stage1Accept, APitThatTheSensorLooksIntoIsNoReflection)
{
  // The near edge of the pit does not stand in the way of the rays to its far wall.
  TestMap m;
  Scan s = Scan().add_surface(1.0, -1.0, 2.0, 1.0, flat);
  for (double y = -0.9; y < 0.9; y += 0.02) s.add(2.775, y, -0.26);
  for (int i = 0; i < 3; i++) EXPECT_EQ(rejected(m.update(s), Reject::Buried), 0u);
  EXPECT_NEAR(m.ground(2.775, 0.025), -0.26, 1e-3);
}

TEST(Stage1Accept, WhatIsSeenFromBelowBuriesNothing)
{
  // The edge of a bridge overhead is all that the map knows there; behind it is floor.
  Scan edge, both;
  const auto bridge = level(1.5);
  edge.add_surface(2.0, -1.0, 2.1, 1.0, bridge);
  TestMap m(edge);
  ASSERT_EQ(m.state(2.025, 0.025), CellState::Measured);
  both.add_surface(2.0, -1.0, 2.1, 1.0, bridge).add(3.425, 0.025, 0.0);
  EXPECT_EQ(rejected(m.update(both), Reject::Buried), 0u);
  EXPECT_EQ(m.ground(3.425, 0.025), 0.0f);
}

TEST(Stage1Accept, AMapThatDriftedAwayDoesNotBlindTheSensor)
{
  // The pose sank by 0.3 m: all of the scan lies below the map, and none of it is a reflection.
  TestMap m(Scan(0, 0, 0.7).add_surface(1.0, -1.0, 3.0, 1.0, flat));
  const FrameReport r = m.update(Scan(0, 0, 0.4).add_surface(1.0, -1.0, 3.0, 1.0, level(-0.3)));
  EXPECT_EQ(rejected(r, Reject::Buried), 0u);
  EXPECT_NEAR(m.ground(2.025, 0.025), -0.3, 1e-3);
}

TEST(Stage1Uncertainty, AStillSensorGivesTheBeamModelOfEquation3)
{
  TestMap m(Scan().add(2.02, 1.01, 0.0), with({{"c_beam_m", 0.01}, {"a_beam", 0.002}}));
  const double l = std::sqrt(2.02 * 2.02 + 1.01 * 1.01 + 0.7 * 0.7);
  const double expected = std::pow(0.01 + 0.002 * l, 2);
  EXPECT_NEAR(m.fused_variance(2.02, 1.01), expected, 1e-5 * expected);
}

TEST(Stage1Uncertainty, ATiltBetweenFramesAddsEquation4)
{
  TestMap m(Scan(), with({{"c_beam_m", 0.01}, {"a_beam", 0.0}, {"lambda_t", 1.5}}));
  const double theta = 0.04;
  Scan tilted(0, 0, 0.7);
  tilted.pose_ = ExactScene::pose(0, 0, 0.7, 0, std::tan(theta / 2));
  tilted.x_ = {2.0f};
  tilted.y_ = {1.0f};
  tilted.z_ = {-0.6f};
  m.update(tilted);
  const double l2 = 2 * 2 + 1 + 0.36;
  const double expected = 1e-4 + std::pow(1.5 * std::sin(theta / 2), 2) * l2;
  const double x = std::cos(theta) * 2 - std::sin(theta) * 0.6;
  EXPECT_NEAR(m.fused_variance(x, 1.001), expected, 1e-4 * expected);
}

TEST(Stage1Uncertainty, AYawBetweenFramesAddsNothing)
{
  TestMap m(Scan(), with({{"c_beam_m", 0.01}, {"a_beam", 0.0}}));
  Scan turned(0, 0, 0.7);
  turned.pose_.m = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.7};
  turned.x_ = {2.01f};
  turned.y_ = {1.01f};
  turned.z_ = {-0.7f};
  m.update(turned);
  EXPECT_NEAR(m.fused_variance(-1.01, 2.01), 1e-4, 1e-9);
}

TEST(Stage1Uncertainty, EachSensorIsComparedWithItsOwnLastFrame)
{
  TestMap m(with({{"c_beam_m", 0.01}, {"a_beam", 0.0}}));
  const double theta = 0.5;
  Scan level(0, 0, 0.7), tilted(0, 0, 0.7);
  tilted.pose_ = ExactScene::pose(0, 0, 0.7, 0, std::tan(theta / 2));
  level.x_ = {2.01f};
  level.y_ = {1.01f};
  level.z_ = {-0.7f};
  for (int i = 0; i < 2; i++)
  {
    m.map.update(level.frame());
    Frame other = tilted.frame();
    other.sensor = 3;
    m.map.update(other);
  }
  EXPECT_LT(m.fused_variance(2.01, 1.01), 1.0001e-4);
}

TEST(Stage1Uncertainty, MoreSensorsThanAMapTellsApartAreRefused)
{
  TestMap m;
  Frame f = Scan().frame();
  for (f.sensor = 100; f.sensor < 164; f.sensor++) m.map.update(f);
  const auto before = m.map.save();
  EXPECT_TRUE(has(message_of([&] { m.map.update(f); }), "more than 64 sensors"));
  EXPECT_EQ(m.map.save(), before);
  f.sensor = 120;
  EXPECT_NO_THROW(m.map.update(f));
}
