#include <gtest/gtest.h>
#include "scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
/** All points at one spot, so that range and with it the variance is nearly the same. */
Scan column(std::initializer_list<double> heights)
{
  Scan s(0, 0, 0.7);
  for (double z : heights) s.add(2.025, 0.025, z);
  return s;
}
double variance_at(double z, const Parameters& p)
{
  const double l = std::sqrt(2.025 * 2.025 + 0.025 * 0.025 + (z - 0.7) * (z - 0.7));
  return std::pow(p.c_beam_m + p.a_beam * l, 2);
}
constexpr double kX = 2.025, kY = 0.025;
}  // namespace

TEST(Stage4Update, PointsInsideTheGateFuseAsTheKalmanClosedForm)
{
  const Parameters p;
  TestMap m(p);
  m.update(column({0.000, 0.010, 0.004}));
  m.update(column({0.006, -0.003}));
  double information = 0, sum = 0;
  for (double z : {0.000, 0.010, 0.004, 0.006, -0.003})
  {
    information += 1 / variance_at(z, p);
    sum += z / variance_at(z, p);
  }
  EXPECT_NEAR(m.ground(kX, kY), sum / information, 2e-6);
  EXPECT_NEAR(m.elevation(kX, kY), sum / information, 2e-6);
  EXPECT_NEAR(m.at(Layer::Variance, kX, kY), 1 / information, 1e-4 / information);
}

TEST(Stage4Update, ElevationKeepsTheHighestAndGroundTheLowest)
{
  TestMap m;
  m.update(column({0.0, 0.3, 0.5}));
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  EXPECT_NEAR(m.elevation(kX, kY), 0.5, 1e-6);
  m.update(
      column({0.3}));  // between the two: above the gate of the ground, below that of the elevation
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  EXPECT_NEAR(m.elevation(kX, kY), 0.5, 1e-6);
}

TEST(Stage4Update, ALowerPointLeavesElevationAndItsVarianceAsTheyAre)
{
  TestMap once, twice;
  once.update(column({0.0, 0.5}));
  twice.update(column({0.0, 0.5}));
  twice.update(column({0.25}));
  const auto heights_and_variances = [](const TestMap& m)
  {
    constexpr std::size_t kBefore = 72 + 32, kBytesPerCell = 4 * sizeof(float);
    std::vector<std::uint8_t> bytes = m.map.save();
    bytes.resize(kBefore + kBytesPerCell * m.map.layer(Layer::State).size());
    bytes.erase(bytes.begin(), bytes.begin() + kBefore);
    return bytes;
  };
  EXPECT_EQ(heights_and_variances(once), heights_and_variances(twice));
}

TEST(Stage4Update, TheVarianceHasAFloor)
{
  Parameters p;
  p.min_variance_m2 = 1e-5;
  TestMap m(p);
  for (int i = 0; i < 100; i++) m.update(column({0.0, 0.001, -0.001}));
  EXPECT_FLOAT_EQ(m.at(Layer::Variance, kX, kY), 1e-5f);
}

TEST(Stage4Update, ATableTopAboveSeenGroundIsPassableAndALowBeamIsNot)
{
  TestMap table, beam;
  Scan ground(0, 0, 0.7);
  ground.add_surface(1, -1, 3, 1, flat);
  table.update(ground);
  beam.update(ground);
  table.update(Scan(ground).add_surface(1.8, -0.4, 2.2, 0.4, level(0.72)));
  beam.update(Scan(ground).add_surface(1.8, -0.4, 2.2, 0.4, level(0.35)));
  for (double y = -0.375; y < 0.4; y += 0.05)
  {
    EXPECT_NEAR(table.elevation(2.025, y), 0.0, 1e-5);
    EXPECT_GT(table.traversability(2.025, y), 0.99);
    EXPECT_NEAR(beam.elevation(2.025, y), 0.35, 1e-5);
    EXPECT_EQ(beam.traversability(2.025, y), 0.0);
  }
}

TEST(Stage4Update, OneFrameWithGroundAndTableTopGivesTheSameAsTwo)
{
  TestMap m;
  m.update(column({0.0, 0.72}));
  EXPECT_NEAR(m.elevation(kX, kY), 0.0, 1e-6);
}

TEST(Stage4Update, TheClimbStopsAtTheFirstGapLargerThanTheClearance)
{
  TestMap joined, hanging;
  joined.update(column({0.0, 0.55, 1.1, 1.65}));  // no gap above 0.6 m: one standing thing
  hanging.update(column({0.0, 0.3, 0.95, 1.5}));  // above 0.3 m there are 0.65 m of air
  EXPECT_NEAR(joined.elevation(kX, kY), 1.65, 1e-6);
  EXPECT_NEAR(hanging.elevation(kX, kY), 0.3, 1e-6);
}

TEST(Stage4Update, AnObjectSeenBeforeTheGroundUnderItHangsOnceTheGroundIsSeen)
{
  TestMap m;
  m.update(column({0.75, 0.85}));
  EXPECT_NEAR(m.elevation(kX, kY), 0.85, 1e-6);
  m.update(column({0.0}));
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  EXPECT_NEAR(m.elevation(kX, kY), 0.0, 1e-6);
}

TEST(Stage4Update, WhatStoodOverAGuessHangsOnceTheFloorBelowItIsHit)
{
  // The floor is known on one side, so that the ground below the sign is a guess from there, and
  // what was hit high above it may be a wall. In the next frame a cell shows floor and sign.
  const auto sign = level(0.9);
  TestMap m;
  m.update(Scan(0, 0, 0.5).add_surface(0.5, -1, 2.0, 1, flat));
  m.update(Scan(0, 0, 0.5).add_surface(2.05, -0.5, 2.1, 0.5, sign));
  EXPECT_EQ(m.state(2.075, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.elevation(2.075, 0.025), 0.9, 1e-5);
  Scan both;
  both.add_surface(2.05, -0.5, 2.1, 0.5, sign).add_surface(2.05, -0.5, 2.1, 0.5, flat);
  m.update(both);
  EXPECT_NEAR(m.elevation(2.075, 0.025), 0.0, 1e-5);
  EXPECT_GT(m.traversability(2.075, 0.025), 0.99f);
}

TEST(Stage4Update, GroundFoundLessThanTheClearanceBelowAnObjectMakesItAnObstacle)
{
  TestMap m;
  m.update(column({0.4, 0.5}));
  m.update(column({0.0}));
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  EXPECT_NEAR(m.elevation(kX, kY), 0.5, 1e-6);
}

TEST(Stage4Update, AStandingPostSeenOnlyAtItsTopStillStands)
{
  TestMap m;
  m.update(column({0.0, 0.3, 0.6, 0.9, 1.2, 1.5}));
  m.update(column({1.4}));
  EXPECT_NEAR(m.elevation(kX, kY), 1.5, 1e-6);
}

namespace
{
double hillside(double x, double y) { return 0.3 * x - 0.2 * y; }
/** Three points on the hillside in one place of the cell at (kX, kY), away from its middle. */
Scan off_middle(double dx, double dy)
{
  Scan s(0, 0, 0.7);
  for (int n = 0; n < 3; n++) s.add(kX + dx, kY + dy, hillside(kX + dx, kY + dy));
  return s;
}
}  // namespace

TEST(Stage4Update, APointOnASlopeCountsInTheMiddleOfItsCell)
{
  TestMap m;
  m.update(Scan().add_surface(1.8, -0.2, 2.3, 0.3, hillside));
  for (int i = 0; i < 20; i++) m.update(off_middle(-0.02, 0.015));
  EXPECT_NEAR(m.ground(kX, kY), hillside(kX, kY), 5e-4);
  EXPECT_NEAR(m.elevation(kX, kY), hillside(kX, kY), 5e-4);
}

TEST(Stage4Update, TheSlopeIsThatOfMeasuredCellsUpToTwoAway)
{
  for (const double gap : {0.05, 0.1})
  {
    TestMap m;
    m.update(Scan()
                 .add_surface(1.7, -0.2, 2.0, 0.3, hillside)
                 .add_surface(2.0 + gap, -0.2, 2.5, 0.3, hillside)
                 .add_surface(2.0, -0.2, 2.05, 0.0, hillside)
                 .add_surface(2.0, gap, 2.05, 0.3, hillside));
    m.update(off_middle(0.02, 0.02));
    EXPECT_NEAR(m.ground(kX, kY), hillside(kX, kY), 5e-4) << gap;
  }
}

TEST(Stage4Update, WithoutGroundOnBothSidesAPointCountsAsItIs)
{
  TestMap m;
  m.update(Scan().add_surface(1.7, 0.0, 2.0, 0.05, hillside));  // and nothing three cells beyond
  m.update(Scan().add_surface(2.15, 0.0, 2.5, 0.05, hillside));
  m.update(off_middle(0.02, 0.0));
  EXPECT_NEAR(m.ground(kX, kY), hillside(kX + 0.02, kY), 1e-4);
}

TEST(Stage4Update, WhatStandsOnASlopeCountsAsItIs)
{
  TestMap m;
  m.update(Scan().add_surface(1.8, -0.2, 2.3, 0.3, hillside));
  Scan top;
  top.add(kX + 0.02, kY, hillside(kX, kY) + 0.3);
  m.update(top);
  EXPECT_NEAR(m.elevation(kX, kY), hillside(kX, kY) + 0.3, 1e-6);
}

TEST(Stage4Update, BesideAFaceAPointCountsAsItIs)
{
  TestMap m;
  const auto step = [](double x, double) { return x < 2.05 ? 0.0 : 0.08; };
  m.update(Scan().add_surface(1.8, -0.2, 2.3, 0.3, step));
  Scan hits;
  for (int n = 0; n < 10; n++) hits.add(2.045, kY, 0.0);
  m.update(hits);
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-4);
}

TEST(Stage4Update, TheOtherSideOfTheWindowIsNotBesideItsBorder)
{
  const Parameters p;
  TestMap m(p);
  const auto valley = [](double x, double) { return 0.3 * std::abs(x); };  // as high on both sides
  const double half = 0.5 * p.window_m, x = half - 0.025, off_m = 0.02;
  m.update(Scan().add_surface(-half, 0.0, half, 0.05, valley));
  Scan hits;
  for (int n = 0; n < 3; n++) hits.add(x + off_m, kY, valley(x + off_m, kY));
  m.update(hits);
  EXPECT_GT(m.ground(x, kY), valley(x + 0.6 * off_m, kY));
}
