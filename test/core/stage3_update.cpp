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

TEST(Stage3Update, PointsInsideTheGateFuseAsTheKalmanClosedForm)
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
  EXPECT_NEAR(m.fused_variance(kX, kY), 1 / information, 1e-4 / information);
}

TEST(Stage3Update, ElevationKeepsTheHighestAndGroundTheLowest)
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

TEST(Stage3Update, ALowerPointLeavesElevationAndItsVarianceAsTheyAre)
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

TEST(Stage3Update, TheVarianceHasAFloor)
{
  Parameters p;
  p.min_variance_m2 = 1e-5;
  TestMap m(p);
  for (int i = 0; i < 100; i++) m.update(column({0.0, 0.001, -0.001}));
  EXPECT_FLOAT_EQ(m.fused_variance(kX, kY), 1e-5f);
}

TEST(Stage3Update, ATableTopAboveSeenGroundIsPassableAndALowBeamIsNot)
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

TEST(Stage3Update, OneFrameWithGroundAndTableTopGivesTheSameAsTwo)
{
  TestMap m;
  m.update(column({0.0, 0.72}));
  EXPECT_NEAR(m.elevation(kX, kY), 0.0, 1e-6);
}

TEST(Stage3Update, TheClimbStopsAtTheFirstGapLargerThanTheClearance)
{
  TestMap joined, hanging;
  joined.update(column({0.0, 0.55, 1.1, 1.65}));  // no gap above 0.6 m: one standing thing
  hanging.update(column({0.0, 0.3, 0.95, 1.5}));  // above 0.3 m there are 0.65 m of air
  EXPECT_NEAR(joined.elevation(kX, kY), 1.65, 1e-6);
  EXPECT_NEAR(hanging.elevation(kX, kY), 0.3, 1e-6);
}

TEST(Stage3Update, AnObjectSeenBeforeTheGroundUnderItHangsOnceTheGroundIsSeen)
{
  TestMap m;
  m.update(column({0.75, 0.85}));
  EXPECT_NEAR(m.elevation(kX, kY), 0.85, 1e-6);
  m.update(column({0.0}));
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  m.update(column({0.75, 0.85}));  // from below
  EXPECT_NEAR(m.elevation(kX, kY), 0.0, 1e-6);
}

TEST(Stage3Update, WhatIsSeenFromAboveStandsOverSeenGroundUntilARayPassesBelowItAsHighAsTheRobot)
{
  // A slab whose underside nobody saw: rays reach the ground below it, but all of them pass low.
  const double sensor_m = 1.5;
  const auto slab = [&](double behind_m)
  {
    Scan s(0, 0, sensor_m);
    s.add_surface(1.8, -0.4, 2.2, 0.4, level(0.9)).add_surface(1.8, -0.4, behind_m, 0.4, flat);
    return s;
  };
  TestMap m;
  m.update(Scan(0, 0, sensor_m).add_surface(1, -1, 4, 1, flat));
  for (int frame = 0; frame < 3; frame++) m.update(slab(2.6));
  EXPECT_NEAR(m.ground(2.025, 0.025), 0.0, 1e-5);
  EXPECT_NEAR(m.elevation(2.025, 0.025), 0.9, 1e-5);
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  // Rays that end farther behind it pass 0.55 m and more above the ground below it.
  m.update(slab(4.0));
  EXPECT_NEAR(m.elevation(2.025, 0.025), 0.0, 1e-5);
  EXPECT_GT(m.traversability(2.025, 0.025), 0.99f);
  m.update(slab(2.6));  // now it is known to hang
  EXPECT_GT(m.traversability(2.025, 0.025), 0.99f);
}

TEST(Stage3Update, WhatStoodOverAGuessHangsOnceTheFloorBelowItIsHit)
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

TEST(Stage3Update, GroundFoundLessThanTheClearanceBelowAnObjectMakesItAnObstacle)
{
  TestMap m;
  m.update(column({0.4, 0.5}));
  m.update(column({0.0}));
  EXPECT_NEAR(m.ground(kX, kY), 0.0, 1e-6);
  EXPECT_NEAR(m.elevation(kX, kY), 0.5, 1e-6);
}

TEST(Stage3Update, AStandingPostSeenOnlyAtItsTopStillStands)
{
  TestMap m;
  m.update(column({0.0, 0.3, 0.6, 0.9, 1.2, 1.5}));
  m.update(column({1.4}));
  EXPECT_NEAR(m.elevation(kX, kY), 1.5, 1e-6);
}

TEST(Stage3Update, AHitThatStandsAloneOverBareGroundCountsAfterTwoWithinAFewScans)
{
  const auto flat_ground = Scan().add_surface(1.5, -0.5, 2.5, 0.5, flat);
  for (const int between : {0, 2, 4})
  {
    TestMap m;
    m.update(flat_ground);
    for (int hit = 0; hit < 2; hit++)
    {
      m.update(Scan().add(kX, kY, 0.4));
      EXPECT_NEAR(m.elevation(kX, kY), 0.0, 1e-3);
      EXPECT_GT(m.traversability(kX, kY), 0.8f);
      for (int i = 0; i < between; i++) m.update(flat_ground);
    }
    m.update(Scan().add(kX, kY, 0.4));
    EXPECT_NEAR(m.elevation(kX, kY), between > 2 ? 0.0 : 0.4, 1e-3) << between;
  }
}

TEST(Stage3Update, AHitIsAloneWithOneOtherBesideItAndNotWithTwo)
{
  for (const int others : {1, 2})
  {
    TestMap m;
    m.update(Scan().add_surface(1.5, -0.5, 2.5, 0.5, flat));
    Scan hits;
    hits.add(kX, kY, 0.4);
    for (int i = 0; i < others; i++) hits.add(kX, kY + 0.05, 0.4 - 0.01 * i);
    m.update(hits);
    EXPECT_NEAR(m.elevation(kX, kY), others == 1 ? 0.0 : 0.4, 1e-3) << others;
  }
}
