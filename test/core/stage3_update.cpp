#include <gtest/gtest.h>
#include "scene.h"

#include <cstring>

using namespace talus;
using namespace talus::test;

namespace
{
/** All points at one spot, so that range and with it the variance is nearly the same. */
Scan column(const std::vector<double>& heights)
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
  TestMap m(column({0.000, 0.010, 0.004}), p);
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

TEST(Stage3Update, ElevationKeepsTheHighestThatStandsAndGroundTheLowest)
{
  struct Case
  {
    const char* what;
    std::vector<std::vector<double>> frames;
    double ground_m, elevation_m;
  };
  const std::vector<Case> cases{
      {"lowest and highest", {{0.0, 0.3, 0.5}}, 0.0, 0.5},
      {"above the gate of the ground, below that of the top", {{0.0, 0.3, 0.5}, {0.3}}, 0.0, 0.5},
      {"the top of a table in the frame of its floor", {{0.0, 0.72}}, 0.0, 0.0},
      {"no gap above 0.6 m: one standing thing", {{0.0, 0.55, 1.1, 1.65}}, 0.0, 1.65},
      {"above 0.3 m there are 0.65 m of air", {{0.0, 0.3, 0.95, 1.5}}, 0.0, 0.3},
      {"an object without ground", {{0.75, 0.85}}, 0.75, 0.85},
      {"it hangs, from below, once the ground is seen",
       {{0.75, 0.85}, {0.0}, {0.75, 0.85}},
       0.0,
       0.0},
      {"ground less than the clearance below an object", {{0.4, 0.5}, {0.0}}, 0.0, 0.5},
      {"a post of which only the top is seen", {{0.0, 0.3, 0.6, 0.9, 1.2, 1.5}, {1.4}}, 0.0, 1.5}};
  for (const Case& c : cases)
  {
    TestMap m;
    for (const auto& heights : c.frames) m.update(column(heights));
    EXPECT_NEAR(m.ground(kX, kY), c.ground_m, 1e-6) << c.what;
    EXPECT_NEAR(m.elevation(kX, kY), c.elevation_m, 1e-6) << c.what;
  }
}

TEST(Stage3Update, ALowerPointLeavesElevationAndItsVarianceAsTheyAre)
{
  TestMap once, twice;
  once.update(column({0.0, 0.5}));
  twice.update(column({0.0, 0.5}));
  twice.update(column({0.25}));
  const CellRecord before = once.map.read_cells({{40, 0, 1, 1}})[0];
  const CellRecord after = twice.map.read_cells({{40, 0, 1, 1}})[0];
  EXPECT_EQ(before.ground_m, 0);
  EXPECT_EQ(std::memcmp(&before, &after, 4 * sizeof(float)), 0) << "heights and variances";
}

TEST(Stage3Update, TheVarianceHasAFloor)
{
  TestMap m(column({0.0, 0.001, -0.001}), with({{"min_variance_m2", 1e-5}}), 12);
  EXPECT_FLOAT_EQ(m.fused_variance(kX, kY), 1e-5f);
}

TEST(Stage3Update, WhatIsSeenFromAboveStandsOverSeenGroundUntilARayPassesBelowItAsHighAsTheRobot)
{
  // A slab whose underside nobody saw: rays reach the ground below it, but all of them pass low.
  const double sensor_m = 1.5;
  const auto slab = [&](double behind_m)
  {
    Scan s = Scan(0, 0, sensor_m)
                 .add_surface(1.8, -0.4, 2.2, 0.4, level(0.9))
                 .add_surface(1.8, -0.4, behind_m, 0.4, flat);
    return s;
  };
  TestMap m(Scan(0, 0, sensor_m).add_surface(1, -1, 4, 1, flat));
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
  TestMap m(Scan(0, 0, 0.5).add_surface(0.5, -1, 2.0, 1, flat));
  m.update(Scan(0, 0, 0.5).add_surface(2.05, -0.5, 2.1, 0.5, sign));
  EXPECT_EQ(m.state(2.075, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.elevation(2.075, 0.025), 0.9, 1e-5);
  m.update(Scan().add_surface(2.05, -0.5, 2.1, 0.5, sign).add_surface(2.05, -0.5, 2.1, 0.5, flat));
  EXPECT_NEAR(m.elevation(2.075, 0.025), 0.0, 1e-5);
  EXPECT_GT(m.traversability(2.075, 0.025), 0.99f);
}

TEST(Stage3Update, AHitThatStandsAloneOverBareGroundCountsAfterTwoWithinAFewScans)
{
  const auto flat_ground = Scan().add_surface(1.5, -0.5, 2.5, 0.5, flat);
  for (const int between : {0, 2, 4})
  {
    TestMap m(flat_ground);
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
    TestMap m(Scan().add_surface(1.5, -0.5, 2.5, 0.5, flat));
    Scan hits = Scan().add(kX, kY, 0.4);
    for (int i = 0; i < others; i++) hits.add(kX, kY + 0.05, 0.4 - 0.01 * i);
    m.update(hits);
    EXPECT_NEAR(m.elevation(kX, kY), others == 1 ? 0.0 : 0.4, 1e-3) << others;
  }
}
