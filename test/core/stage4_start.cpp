// What the map knows where its scanner is blind, in the first frame and where the robot drives.
#include <gtest/gtest.h>
#include "scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
constexpr double kSensor_m = 0.68, kLowest_rad = 15 * M_PI / 180;
constexpr double kFirstRing_m = kSensor_m / 0.268;  // of the lowest of 16 beams, on level floor

/** What 16 beams see from a robot on z = `floor_m` at (x, 0); other ground is at z = 0. */
Scan sixteen_beams(const std::vector<Box>& boxes = {}, double x_m = 0, double floor_m = 0)
{
  return Scan(x_m, 0, floor_m + kSensor_m).cast(boxes, 1800, -kLowest_rad, kLowest_rad, 16);
}

const Pose kOnRobot = translation(0, 0, kSensor_m);

/** A map after the first frame of a robot. */
TestMap started(const Scan& scan, const Parameters& p = {})
{
  TestMap m(p);
  m.update(scan, kOnRobot);
  return m;
}

Parameters with_radius(double radius_m) { return with({{"start_radius_m", radius_m}}); }

const Box kBox{{1.0, -0.25, 0}, {1.5, 0.25, 0.8}};

/** f(x, y) of the middles of all cells within a radius. */
template <class F>
void around(double radius_m, const F& f)
{
  for (int iy = -60; iy < 60; iy++)
    for (int ix = -60; ix < 60; ix++)
      if (const double x = (ix + 0.5) * 0.05, y = (iy + 0.5) * 0.05; std::hypot(x, y) < radius_m)
        f(x, y);
}

long unknown_within(const TestMap& m, double radius_m)
{
  long n = 0;
  around(radius_m, [&](double x, double y) { n += m.state(x, y) == CellState::Unknown; });
  return n;
}
}  // namespace

TEST(Stage4Start, WhatTheScannerLooksOverIsKnownAndFreeAfterTheFirstFrame)
{
  TestMap m = started(sixteen_beams());
  around(
      kFirstRing_m - 0.15,
      [&](double x, double y)
      {
        EXPECT_EQ(m.state(x, y), CellState::Presumed) << x << " " << y;
        EXPECT_NEAR(m.ground(x, y), 0, 1e-5) << x << " " << y;
        EXPECT_TRUE(std::isnan(m.elevation(x, y))) << x << " " << y;
        EXPECT_GT(m.traversability(x, y), 0.99f) << x << " " << y;
      });
  EXPECT_NE(m.state(kFirstRing_m + 0.3, 0.025), CellState::Presumed);
}

TEST(Stage4Start, WhatIsHitThereStandsAndNothingIsPresumedBehindIt)
{
  TestMap m = started(sixteen_beams({kBox}));
  for (const double y : {-0.175, 0.025, 0.175})
  {
    EXPECT_EQ(m.traversability(1.025, y), 0.0f) << y;
    EXPECT_NE(m.state(1.025, y), CellState::Presumed) << y;
    EXPECT_NE(m.state(1.775, y), CellState::Presumed) << y;
    EXPECT_EQ(m.state(0.775, y), CellState::Presumed) << y;
  }
  EXPECT_EQ(m.state(-1.775, 0.025), CellState::Presumed);
}

TEST(Stage4Start, ARadiusThatIsToldIsADiscInEachDirectionAndOfZeroWhatTheRobotStandsOn)
{
  TestMap m = started(sixteen_beams({kBox}), with_radius(1.7));
  for (const double x : {1.625, -1.625}) EXPECT_EQ(m.state(x, 0.025), CellState::Presumed) << x;
  for (const double x : {1.775, -1.775}) EXPECT_NE(m.state(x, 0.025), CellState::Presumed) << x;
  EXPECT_EQ(m.traversability(1.025, 0.025), 0.0f);
  TestMap zero = started(sixteen_beams(), with_radius(0));
  EXPECT_EQ(zero.state(0.175, 0.025), CellState::Presumed);
  EXPECT_EQ(zero.state(0.375, 0.025), CellState::Unknown);
  EXPECT_EQ(zero.state(1.525, 0.025), CellState::FilledOneSided);
}

TEST(Stage4Start, AFrameThatDoesNotTellWhereTheBaseIsPresumesNothing)
{
  TestMap m(sixteen_beams());
  EXPECT_GT(unknown_within(m, 0.4), 100);
  m.update(sixteen_beams(), kOnRobot);  // that is not the first frame
  EXPECT_NE(m.state(1.525, 0.025), CellState::Presumed);
}

TEST(Stage4Start, ThePlaneIsInclinedAsTheBaseIs)
{
  constexpr double pitch = 0.1;
  const double c = std::cos(pitch), s = std::sin(pitch);
  TestMap m(with_radius(1));
  Pose inclined;
  inclined.m = {c, 0, -s, -s * kSensor_m, 0, 1, 0, 0, s, 0, c, c * kSensor_m};
  m.update(sixteen_beams(), inclined);
  for (const double x : {-0.775, 0.775})
  {
    EXPECT_EQ(m.state(x, 0.025), CellState::Presumed) << x;
    EXPECT_NEAR(m.ground(x, 0.025), -x * std::tan(pitch), 1e-5) << x;
  }
}

TEST(Stage4Start, NothingIsPresumedTowardsADropOff)
{
  const Box platform{{-5, -5, 0}, {1, 5, 1}};
  TestMap m = started(sixteen_beams({platform}, 0, 1));
  for (const double x : {1.225, 1.775, 2.325})
    EXPECT_NE(m.state(x, 0.025), CellState::Presumed) << x;
  EXPECT_EQ(m.state(-1.775, 0.025), CellState::Presumed);
  EXPECT_EQ(m.state(0.575, 0.025), CellState::Presumed) << "there it stands, with room to move off";
  const Box behind{{-5, -5, 0}, {1.2, 5, 1}}, left{{1.2, 0.4, 0}, {8, 5, 1}};
  TestMap corner = started(sixteen_beams({behind, left}, 0, 1));
  EXPECT_NE(corner.state(1.525, 0.425), CellState::Presumed)
      << "it goes on beside where it is seen";
  EXPECT_EQ(corner.state(1.525, 1.525), CellState::Presumed);
}

TEST(Stage4Start, NothingIsPresumedWhereGroundIsSeenTooFarAway)
{
  constexpr double height_m = 1.2;  // its lowest beam meets the floor after 4.5 m
  const Scan scan = Scan(0, 0, height_m).cast({}, 1800, -kLowest_rad, kLowest_rad, 16);
  TestMap m;
  m.update(scan, translation(0, 0, height_m));
  EXPECT_NE(m.state(1.525, 0.025), CellState::Presumed);
  EXPECT_EQ(m.state(0.575, 0.025), CellState::Presumed);
}

TEST(Stage4Start, PresumedGroundGivesWayToMeasurementsAndToRaysBelowIt)
{
  TestMap m = started(sixteen_beams());
  m.update(Scan().add(1.525, 0.025, -0.04));
  EXPECT_EQ(m.state(1.525, 0.025), CellState::Measured);
  EXPECT_NEAR(m.ground(1.525, 0.025), -0.04, 1e-5);
  EXPECT_EQ(m.state(1.425, 1.025), CellState::Presumed);
  EXPECT_NEAR(m.ground(1.425, 1.025), 0, 1e-5);
  for (int frame = 0; frame < 2; frame++)
    m.update(Scan().add_surface(-2.2, -0.3, -2.0, 0.3, level(-0.6)));
  EXPECT_NE(m.state(-1.525, 0.025), CellState::Presumed);
}

TEST(Stage4Start, ASavedMapKeepsWhatWasPresumedAndStartsNoOther)
{
  TestMap m, restored;
  m.update(sixteen_beams(), kOnRobot);
  restored.map.restore(m.map.save());
  EXPECT_EQ(restored.state(1.525, 0.025), CellState::Presumed);
  EXPECT_EQ(restored.map.save(), m.map.save());
  TestMap none, restored_none;
  none.update(sixteen_beams());
  restored_none.map.restore(none.map.save());
  restored_none.update(sixteen_beams(), kOnRobot);
  EXPECT_NE(restored_none.state(1.525, 0.025), CellState::Presumed);
}

TEST(Stage4Start, AnotherFloorStartsAnew)
{
  const Box upper{{-20, -20, 2.9}, {20, 20, 3}};
  TestMap m = started(sixteen_beams());
  ASSERT_NEAR(m.ground(1.525, 0.025), 0, 1e-5);
  for (int frame = 0; frame < 2; frame++) m.update(sixteen_beams({upper}, 0, 3), kOnRobot);
  EXPECT_EQ(m.state(1.525, 0.025), CellState::Presumed);
  EXPECT_NEAR(m.ground(1.525, 0.025), 3, 1e-4);
  EXPECT_GT(m.traversability(1.525, 0.025), 0.99f);
}

TEST(Stage4Start, FewHitsFarAboveTheGroundAreNoOtherFloor)
{
  for (const double length_m : {0.5, 0.6})  // 20 and 24 hits are sampled
  {
    TestMap m(Scan(0, 0, 2).add_surface(-2, -2, 2, 2, flat));
    m.update(Scan(0, 0, 2)
                 .add_surface(-1, -1, length_m - 1, -0.1, level(1.5))
                 .add_surface(-1, 0.2, 0, 0.7, flat));
    m.update(Scan(0, 0, 2).add(0.025, 0.025, 0));
    EXPECT_EQ(m.state(1.525, 1.025) == CellState::Measured, length_m < 0.55) << length_m;
  }
}

TEST(Stage4Underfoot, WhatTheRobotDrivesOverIsKnownAlsoWhereNothingMeasuredIt)
{
  TestMap m(with_radius(0));
  for (const double x : {0.0, 0.2, 0.4}) m.update(sixteen_beams({}, x), kOnRobot);
  for (const double x : {-0.175, 0.025, 0.375, 0.575})
  {
    EXPECT_EQ(m.state(x, 0.025), CellState::Presumed) << x;
    EXPECT_GT(m.traversability(x, 0.025), 0.99f) << x;
  }
  m.update(Scan(0.4).add(0.375, 0.025, 0.03));
  m.update(sixteen_beams({}, 0.4), kOnRobot);
  EXPECT_EQ(m.state(0.375, 0.025), CellState::Measured);
}

TEST(Stage4Underfoot, WhatIsAsHighAsWhatTheRobotJustDroveThroughIsDrivenThroughToo)
{
  const auto grass = level(0.3);
  TestMap m(
      Scan(-2, 0, kSensor_m)
          .add_surface(-0.4, -0.4, 0.4, 0.4, grass)
          .add_surface(0.4, -1, 1, 1, flat),
      with_radius(0));
  m.update(sixteen_beams(), kOnRobot);  // through grass
  m.map.restore(m.map.save());
  m.update(sixteen_beams({}, 0.7), kOnRobot);  // beside it
  m.update(Scan(-2, 0, kSensor_m)
               .add_surface(0.6, -0.1, 0.8, 0.1, grass)
               .add_surface(0.6, 0.5, 0.8, 0.7, grass));
  EXPECT_NEAR(m.elevation(0.725, 0.025), 0.0, 1e-3);
  EXPECT_NEAR(m.elevation(0.725, 0.625), 0.3, 1e-3);  // nobody drove there
}

TEST(Stage4Underfoot, WhatStandsBelowAMirrorThatPassesOverItStaysAsItIs)
{
  const Box parked{{1, 0.4, 0}, {1.6, 0.9, 0.4}};
  Parameters mirror;
  mirror.body_boxes_m = {{-0.3, 0.3, 0.35, 1, 0.5, 0.7}};  // passes above what is parked
  TestMap with(mirror), without;
  for (int frame = 0; frame < 14; frame++)
    for (TestMap* m : {&with, &without}) m->update(sixteen_beams({parked}, 0.2 * frame), kOnRobot);
  EXPECT_NEAR(with.elevation(1.325, 0.425), 0.4, 0.1);
  EXPECT_LT(with.traversability(1.325, 0.425), 0.05f);
  EXPECT_EQ(with.map.save(), without.map.save());
}
