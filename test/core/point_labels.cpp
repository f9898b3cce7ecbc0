#include <gtest/gtest.h>
#include "scene.h"

#include <talus/point_labels.h>

#include <stdexcept>

using namespace talus;
using namespace talus::test;

namespace
{
/** The label of one point of the map frame, as a frame from where `seen_from` was. */
PointLabel label_at(const TestMap& m, double x, double y, double z, const Scan& seen_from = Scan())
{
  Scan s = seen_from;
  s.x_.clear(), s.y_.clear(), s.z_.clear();
  s.add(x, y, z);
  return label_points(m.map, s.frame()).at(0);
}

std::size_t count(const std::vector<PointLabel>& labels, PointLabel wanted)
{
  return static_cast<std::size_t>(std::count(labels.begin(), labels.end(), wanted));
}

const Box kBox{{1.5, -0.4, 0}, {2.0, 0.4, 0.8}};
}  // namespace

TEST(PointLabels, TellGroundFromWhatStandsOnIt)
{
  const Scan scan = Scan().cast({kBox});
  TestMap m(scan);
  const std::vector<PointLabel> labels = label_points(m.map, scan.frame());
  ASSERT_EQ(labels.size(), scan.z_.size());
  const Window w = m.map.window();
  std::size_t inside = 0;
  for (std::size_t i = 0; i < labels.size(); i++)
  {
    const double x = scan.x_[i], y = scan.y_[i], z = scan.z_[i] + 0.7;
    if (!w.index_at(x, y))
    {
      EXPECT_EQ(labels[i], PointLabel::Outside) << "point " << i;
      continue;
    }
    inside++;
    // The lowest hit of a face is its ground, some centimetres up; a tenth above that is bare.
    if (z < 0.01 || z > 0.16)
    {
      EXPECT_EQ(labels[i], z < 0.01 ? PointLabel::Ground : PointLabel::Stands)
          << "point " << i << " at " << z;
    }
  }
  EXPECT_GT(inside, 10000u);
  EXPECT_GT(count(labels, PointLabel::Stands), 100u);
}

TEST(PointLabels, WhatIsHighUpHangsAndIsNoPartOfTheObjectBelowIt)
{
  Scan scan = Scan().add_surface(-3, -3, 3, 3, flat).add_surface(1, 1, 1.5, 1.5, level(0.4));
  TestMap m(scan.add_surface(1, -2, 2, 0, level(1.5)));  // above the sensor, and hit from below
  const std::vector<PointLabel> labels = label_points(m.map, scan.frame());
  EXPECT_EQ(count(labels, PointLabel::Ground), 120u * 120u);
  EXPECT_EQ(count(labels, PointLabel::Hangs), 20u * 40u);
  EXPECT_EQ(label_at(m, 1.22, 1.22, 0.38), PointLabel::Stands);
  EXPECT_EQ(label_at(m, 1.22, 1.22, 0.55), PointLabel::Stands);
  EXPECT_EQ(label_at(m, 1.22, 1.22, 0.4 + 0.7), PointLabel::Hangs);
  EXPECT_EQ(label_at(m, 1.22, 1.22, 0.4 + 0.5), PointLabel::MovedAway);
}

TEST(PointLabels, AnObjectOverGroundThatNobodySawStands)
{
  // Only its top was hit, and no line from it finds ground: the cell keeps the top as its lowest.
  Parameters p;
  p.fill_search_m = 0.1;
  Scan scan = Scan().add_surface(-3, -3, 3, -0.5, flat).add_surface(1, -0.3, 1.5, -0.1, level(0.9));
  TestMap m(scan, p);
  ASSERT_EQ(m.state(1.22, -0.18), CellState::Measured);
  const std::vector<PointLabel> labels = label_points(m.map, scan.frame());
  EXPECT_EQ(count(labels, PointLabel::Ground), 120u * 50u);
  EXPECT_EQ(count(labels, PointLabel::Stands), 10u * 4u);
}

TEST(PointLabels, OfAnOlderFrameTellWhatHasLeftSince)
{
  const Scan with = Scan().cast({kBox}), without = Scan().cast({});
  TestMap m(with);
  const std::vector<PointLabel> then = label_points(m.map, with.frame());
  for (int i = 0; i < 4; i++) m.update(without);
  const std::vector<PointLabel> since = label_points(m.map, with.frame());
  std::size_t stood = 0;
  for (std::size_t i = 0; i < then.size(); i++)
    if (then[i] == PointLabel::Stands)
    {
      stood++;
      EXPECT_EQ(since[i], PointLabel::MovedAway) << "point " << i;
    }
  EXPECT_GT(stood, 100u);
}

TEST(PointLabels, APersonWhoLeftHasLeftUpToTheHead)
{
  // Higher than the sensor, who would else hang there; a ceiling hangs as before.
  Scan with, without;
  with.cast({{{1.5, -0.3, 0}, {1.9, 0.3, 1.6}}}, 720, -0.6, 0.5, 80);
  without.cast({}, 720, -0.6, 0.5, 80);
  for (Scan* s : {&with, &without}) s->add_surface(-2, -2, -1, -1, level(1.9));
  TestMap m(with);
  for (int i = 0; i < 15; i++) m.update(without);
  const std::vector<PointLabel> labels = label_points(m.map, with.frame());
  std::size_t head = 0;
  for (std::size_t i = 0; i < labels.size(); i++)
    if (with.x_[i] > 1.4F && with.x_[i] < 2 && std::abs(with.y_[i]) < 0.31F && with.z_[i] > 0.1F)
    {
      head++;
      EXPECT_EQ(labels[i], PointLabel::MovedAway) << "point " << i;
    }
  EXPECT_GT(head, 100u);
  EXPECT_NEAR(static_cast<double>(count(labels, PointLabel::Hangs)), 20 * 20, 5);
}

TEST(PointLabels, WhatIsHighUpWhereSomethingLeftLatelyDoesNotHang)
{
  const Scan without = Scan().cast({});
  TestMap left(Scan().cast({kBox})), never;
  for (int i = 0; i < 2; i++) left.update(without), never.update(without);
  EXPECT_EQ(label_at(left, 1.525, 0.025, 1.4), PointLabel::MovedAway);
  EXPECT_EQ(label_at(never, 1.525, 0.025, 1.4), PointLabel::Hangs);
}

TEST(PointLabels, AReflectionIsBelowTheGroundAlsoThatOfTheFrameItself)
{
  const Scan floor = Scan().cast({});
  const Scan reflected = Scan(floor).add(2, 0.01, -0.5);
  TestMap m(floor);
  m.update(reflected);
  const std::vector<PointLabel> labels = label_points(m.map, reflected.frame());
  EXPECT_EQ(labels.back(), PointLabel::BelowGround);
  EXPECT_EQ(count(labels, PointLabel::BelowGround), 1u);
  EXPECT_EQ(label_at(m, 1.5, 1, -0.5), PointLabel::BelowGround);
  EXPECT_EQ(label_at(m, 1.5, 1, -0.05), PointLabel::Ground);  // noise
}

TEST(PointLabels, SayWhatTheMapDoesNotTake)
{
  Parameters p;
  p.body_boxes_m = {{-0.5, 0.5, -0.3, 0.3, -1, 0.2}};
  p.max_range_m = 3.5;
  TestMap m(Scan().add_surface(-3, -3, 3, 3, flat), p);
  EXPECT_EQ(label_at(m, NAN, 0, 0), PointLabel::NotTaken);
  EXPECT_EQ(label_at(m, 0, INFINITY, 0), PointLabel::NotTaken);
  EXPECT_EQ(label_at(m, 0, 0, 0.7), PointLabel::NotTaken);  // a zero-range return
  EXPECT_EQ(label_at(m, 3.6, 0, 0), PointLabel::NotTaken);
  EXPECT_EQ(label_at(m, 1, 0, 0.7 + 1.6), PointLabel::NotTaken);  // the height band
  EXPECT_EQ(label_at(m, 0.4, 0.1, 0.8), PointLabel::NotTaken);  // the body
  EXPECT_EQ(label_at(m, 0.6, 0.1, 0), PointLabel::Ground);
}

TEST(PointLabels, AreOutsideWhereTheMapKnowsNoGround)
{
  TestMap m;
  EXPECT_EQ(label_at(m, 1, 1, 0), PointLabel::Outside);  // no frame yet
  m.update(Scan().add_surface(-1, -1, 1, 1, flat));
  EXPECT_EQ(label_at(m, 3.9, 3.9, 0), PointLabel::Outside);
  EXPECT_EQ(label_at(m, 4.2, 0, 0), PointLabel::Outside);
  EXPECT_EQ(label_at(m, 1e5, 0, 0, Scan(1e5, 0)), PointLabel::Outside);
}

TEST(PointLabels, FollowTheWindowOnBothSidesOfTheOriginAndPosesThatClimb)
{
  TestMap m;
  for (const double x : {0.0, -5.03, 7.21})
  {
    const Scan scan = Scan(x, -x)
                          .add_surface(x - 3, -x - 3, x + 3, -x + 3, flat)
                          .add_surface(x + 1, -x + 1, x + 1.5, -x + 1.5, level(0.5));
    m.update(scan);
    const std::vector<PointLabel> labels = label_points(m.map, scan.frame());
    EXPECT_EQ(count(labels, PointLabel::Ground), 120u * 120u);
    EXPECT_EQ(count(labels, PointLabel::Stands), 10u * 10u);
  }
  TestMap climbs;
  const Scan level_floor = Scan().add_surface(-3, -3, 3, 3, flat);
  Frame frame = level_floor.frame();
  for (int i = 0; i < 10; i++, frame.T_map_sensor.m[11] += 0.05) climbs.map.update(frame);
  frame.T_map_sensor.m[11] -= 0.05;
  EXPECT_EQ(count(label_points(climbs.map, frame), PointLabel::Ground), 120u * 120u);
  EXPECT_EQ(
      count(label_points(climbs.map, level_floor.frame()), PointLabel::BelowGround), 120u * 120u);
}

TEST(PointLabels, TakeEachPointWhereTheSensorWasAtItsTime)
{
  TestMap m(Scan().add_surface(-3, -3, 3, 3, flat).add_surface(2, 0, 2.5, 0.5, level(0.5)));
  const Scan scan = Scan().add(1.2, 0.2, 0.4).add(1.2, 0.2, 0.4).add(1.2, 0.2, 0);
  const std::vector<float> times{0, 0.1F, 0.1F};
  Frame frame = scan.frame();
  frame.time_s = times.data();
  frame.path = {{0, frame.T_map_sensor}, {0.1, translation(1, 0, 0.7)}};
  EXPECT_EQ(
      label_points(m.map, frame),
      (std::vector<PointLabel>{PointLabel::MovedAway, PointLabel::Stands, PointLabel::Ground}));
}

TEST(PointLabels, ChangeNothingInTheMap)
{
  const Scan scan = Scan().cast({kBox}), other = Scan(0.5, 0.3).cast({kBox});
  TestMap m, same;
  m.update(scan), same.update(scan);
  label_points(m.map, other.frame());
  EXPECT_EQ(m.map.save(), same.map.save());
  m.update(other), same.update(other);
  EXPECT_EQ(m.map.save(), same.map.save());
}

TEST(PointLabels, NeedAFrameAndNoneInFlight)
{
  TestMap m;
  EXPECT_TRUE(label_points(m.map, Frame{}).empty());
  Frame without_points;
  without_points.size = 3;
  EXPECT_THROW(label_points(m.map, without_points), std::invalid_argument);
  const Scan scan = Scan().add(1, 1, 0);
  Frame nowhere = scan.frame();
  nowhere.T_map_sensor.m[3] = NAN;
  EXPECT_THROW(label_points(m.map, nowhere), std::invalid_argument);
  m.map.start(scan.frame());
  EXPECT_THROW(label_points(m.map, scan.frame()), std::logic_error);
  m.map.finish();
  EXPECT_EQ(label_points(m.map, scan.frame()).size(), 1u);
}
