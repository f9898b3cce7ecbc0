#include <gtest/gtest.h>
#include "scene.h"
#include "kernels/7_sparsity.h"

#include <cmath>

using namespace talus;
using namespace talus::test;

namespace
{
/** Hits far beyond, so that rays pass low over everything. */
Scan with_rays(Scan s)
{
  for (double y = -2; y < 2; y += 0.01) s.add(4.1, y, -0.2);
  return s;
}

/** Dense ground up to x = 1.5 m, a gap too wide to be filled from its far side, ground `drop_m`
 * lower from 2.5 m on. */
Scan gap(double drop_m, double near_until_m = 1.5, double sensor_m = 0.3)
{
  Scan s(0, 0, sensor_m);
  s.add_surface(0.5, -0.5, near_until_m, 0.5, flat);
  if (drop_m < 1) s.add_surface(2.5, -0.5, 3.5, 0.5, [&](double, double) { return -drop_m; });
  return s;
}
Parameters short_search()
{
  Parameters p;
  p.fill_search_m = 0.5;
  return p;
}
constexpr double kX = 1.525, kY = 0.025;
/** What a slope half as steep as is allowed explains, over the 21 cells between both sides. */
const double kSlope_m = 0.5 * std::tan(Parameters().slope_threshold_rad) * 1.05;
/** So high that the sensor sees the far side over the edge. */
constexpr double kHigh_m = 0.9;
}  // namespace

TEST(Stage7Sparsity, Equation14ByNumbersWorkedOutByHand)
{
  // h_s = 0.12 m < h_c = 0.2 m: 1 - 0.12 / 0.2.
  TestMap shallow(short_search());
  shallow.update(gap(kSlope_m + 0.12, 1.5, kHigh_m));
  EXPECT_NEAR(shallow.at(Layer::Sparsity, kX, kY), 0.4, 1e-5);
  // h_s = 0.25 m >= h_c, 1.5 m away with d_c = 2 m: 1 - 0.25 * 2 / (0.2 * 1.5) < 0.
  TestMap deep(short_search());
  deep.update(gap(kSlope_m + 0.25, 1.5, kHigh_m));
  EXPECT_EQ(deep.at(Layer::Sparsity, kX, kY), 0.0f);
  EXPECT_EQ(deep.traversability(kX, kY), 0.0f);
}

TEST(Stage7Sparsity, FarAwayTheSameHeightDifferenceWeighsLess)
{
  // h_s = 0.3 m >= h_c, 1.5 m away (30 cells) with d_c = 0.6 m: 1 - 0.3 * 0.6 / (0.2 * 1.5) =
  // 0.4.
  Parameters p = short_search();
  p.sparsity_distance_m = 0.6;
  TestMap m(p);
  m.update(gap(kSlope_m + 0.3, 1.5, kHigh_m));
  EXPECT_NEAR(m.at(Layer::Sparsity, kX, kY), 0.4, 1e-4);
}

TEST(Stage7Sparsity, WhatADrivableSlopeExplainsIsNoDitch)
{
  // The crest of a ramp: the floor behind it is 0.3 m lower, a metre away.
  TestMap m(short_search());
  m.update(with_rays(gap(0.3)));
  EXPECT_TRUE(std::isnan(m.at(Layer::Sparsity, kX, kY)));
  EXPECT_GT(m.traversability(kX, kY), 0.0f);
}

TEST(Stage7Sparsity, OneHeightOrNoneLeavesTheCellUnknown)
{
  TestMap m(short_search());
  m.update(gap(2));  // nothing on the far side
  EXPECT_EQ(m.state(kX, kY), CellState::FilledOneSided);
  EXPECT_TRUE(std::isnan(m.at(Layer::Sparsity, kX, kY)));
  EXPECT_TRUE(std::isnan(m.traversability(kX, kY)));
}

TEST(Stage7Sparsity, FarFromTheRobotAGuessIsJudgedByItsGeometry)
{
  Parameters p = short_search();
  p.sparsity_range_m = 1.0;
  TestMap m(p);
  m.update(with_rays(gap(2)));
  EXPECT_TRUE(std::isnan(m.at(Layer::Sparsity, kX, kY)));
  EXPECT_GT(m.traversability(kX, kY), 0.9f);
}

TEST(Stage7Sparsity, AFarWallLeadsBackUpWhereTheGapIsWiderThanADitch)
{
  kernels::Config k{};
  k.max_slope = std::tan(0.5f), k.step_threshold_m = 0.2f;
  const float explained_m = 2.5f * 0.2f;
  for (const float length_m : {2.7f, 2.9f})
  {
    const float hollow_m = 2 * (0.6f - 0.05f * length_m);
    EXPECT_NEAR(fall_in({length_m, 0, -0.6f, 0, 0.3f}, k).m, hollow_m, 1e-5f);
    // A kerb at the foot of a hill is steep, too.
    const float kerb_m = length_m < 2.8f ? hollow_m : 0.6f - explained_m;
    EXPECT_NEAR(fall_in({length_m, 0, -0.6f, -0.4f, 0.1f}, k).m, kerb_m, 1e-5f);
  }
}

TEST(Stage7Sparsity, AFarWallThatIsSeenNearItsTopIsThatOfADitch)
{
  for (const bool wall : {false, true})
  {
    Scan s = gap(2, 1.5, kHigh_m);
    // Each of two cells is hit at its foot, and near its top.
    for (const double x : {2.525, 2.575})
      for (double y = -0.475; y < 0.5; y += 0.01)
        s.add(x, y, -0.2).add(x + 0.01, y, wall ? -0.03 : -0.2);
    s.add_surface(2.6, -0.5, 3.5, 0.5, level(wall ? 0.0 : -0.2));
    TestMap m(short_search());
    m.update(s);
    EXPECT_EQ(m.traversability(kX, kY) == 0.0f, wall);
  }
}
