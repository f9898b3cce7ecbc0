#include <gtest/gtest.h>
#include "kernels/7_traversability.h"
#include "scene.h"

#include <cmath>
#include <random>
#include "kernels/7_sparsity.h"

using namespace talus;
using namespace talus::test;

namespace
{
double slope_deg(const TestMap& m, double x, double y)
{
  const Parameters p;
  return (1 - m.at(Layer::Slope, x, y)) * p.slope_threshold_rad * 180 / M_PI;
}
}  // namespace

TEST(Stage7Traversability, APlaneTiltedByTenDegreesHasThatSlopeEverywhere)
{
  for (const double azimuth_deg : {0.0, 30.0, 45.0, 90.0, 200.0})
  {
    const double t = std::tan(10 * M_PI / 180), a = azimuth_deg * M_PI / 180;
    Scan s(0, 0, 0);  // at this height the whole plane is inside the height band
    s.add_surface(
        -4, -4, 4, 4, [&](double x, double y) { return t * (std::cos(a) * x + std::sin(a) * y); });
    TestMap m(s, with({{"min_range_m", 0.01}}));
    int cells = 0;
    for (double x = -3.975; x < 4; x += 0.05)
      for (double y = -3.975; y < 4; y += 0.05)
        if (m.state(x, y) == CellState::Measured)
        {
          ASSERT_NEAR(slope_deg(m, x, y), 10.0, 0.1) << x << "," << y;
          cells++;
        }
    EXPECT_EQ(cells, 25600);
  }
}

TEST(Stage7Traversability, FlatGroundIsFreeToTheEdgeOfTheWindow)
{
  TestMap m(Scan().add_surface(-4, -4, 4, 4, flat));
  for (const float v : m.map.layer(Layer::Traversability))
    EXPECT_FALSE(std::abs(v - 1) > 1e-6) << v;
  EXPECT_NEAR(m.traversability(-3.975, 3.975), 1.0, 1e-6);
}

TEST(Stage7Traversability, AWallOneCellThickBlocksAtMostItsOwnCellsAndTheirNeighbours)
{
  TestMap m;
  const Box wall{{1.51, -2, 0}, {1.54, 2, 1.2}};
  for (int i = 0; i < 5; i++)
  {
    Scan s = Scan().add_surface(-3, -3, 3, 3, flat);  // the floor on both sides is known
    m.update(s.cast({wall}));
  }
  for (double y = -1.475; y < 1.5; y += 0.05)
  {
    EXPECT_EQ(m.traversability(1.525, y), 0.0f) << y;
    EXPECT_GT(m.traversability(1.425, y), 0.9f) << y;
    EXPECT_GT(m.traversability(1.625, y), 0.9f) << y;
  }
}

TEST(Stage7Traversability, Equations10To13ByNumbersWorkedOutByHand)
{
  // One cell 0.04 m above 48 flat neighbours. Mean of the 49: 0.04 / 49.
  TestMap m(
      Scan().add_surface(
          1, -1, 3, 1,
          [](double x, double y)
          { return std::abs(x - 2.025) < 0.01 && std::abs(y - 0.025) < 0.01 ? 0.04 : 0.0; }),
      with({{"feature_radius_m", 0.15}}));
  const double mean = 0.04 / 49;
  const double step = 1 - (2 * 0.04 - 0.0 - mean) / (2 * 0.2);
  const double roughness = 1 - (0.04 - mean) / 0.2;
  EXPECT_NEAR(m.at(Layer::Slope, 2.025, 0.025), 1.0, 1e-5);  // the bump is in the middle
  EXPECT_NEAR(m.at(Layer::Step, 2.025, 0.025), step, 2e-3);  // heights are quantised to 0.24 mm
  EXPECT_NEAR(m.at(Layer::Roughness, 2.025, 0.025), roughness, 2e-3);
  EXPECT_NEAR(m.traversability(2.025, 0.025), 0.4 * 1.0 + 0.3 * step + 0.3 * roughness, 2e-3);
}

TEST(Stage7Traversability, AFloorCellBesideAnObstacleIsNeitherRoughNorAStep)
{
  TestMap m(Scan().add_surface(1, -1, 3, 1, flat).add_surface(2.0, -1, 2.05, 1, level(0.45)));
  EXPECT_EQ(m.at(Layer::Step, 1.975, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Roughness, 1.975, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Step, 2.025, 0.025), 0.0f);
}

TEST(Stage7Traversability, TooFewNeighboursLeaveTheSlopeAndWithItTheCellUnknown)
{
  TestMap m(Scan().add(2.025, 0.025, 0).add(2.075, 0.025, 0), with({{"fill_search_m", 0}}));
  EXPECT_EQ(m.state(2.025, 0.025), CellState::Measured);
  EXPECT_TRUE(std::isnan(m.traversability(2.025, 0.025)));
}

TEST(Stage7Traversability, AGapOfOneCellBetweenImpassableCellsIsImpassable)
{
  for (const int gap_cells : {1, 3})
  {
    Scan s = Scan().add_surface(1, -1, 3, 1, flat);
    const double gap_m = 0.05 * gap_cells;
    for (const double x : {2.0 - 0.2, 2.0 + gap_m})
      s.add_surface(x, -0.5, x + 0.2, 0.5, level(0.45));
    TestMap m(s);
    EXPECT_EQ(m.traversability(2.0 + gap_m / 2, 0.025) == 0.0f, gap_cells == 1) << gap_cells;
  }
}

TEST(Stage7Traversability, ASteepFaceIsImpassableUpToItsEdge)
{
  for (const double degrees : {45.0, 25.0})
  {
    Scan s;
    const double rise = std::tan(degrees * M_PI / 180);
    s.add_surface(
        1, -1, 4, 1, [&](double x, double) { return rise * std::clamp(x - 2.0, 0.0, 0.6); });
    TestMap m(s);
    const bool steep = degrees > 40;
    // The cell of the foot itself has risen by 2.5 cm only.
    for (double x = 2.075; x < 2.6; x += 0.05)
      EXPECT_EQ(m.traversability(x, 0.025) == 0.0f, steep) << degrees << " at " << x;
    for (const double x : {1.875, 2.725})
      EXPECT_GT(m.traversability(x, 0.025), 0.0f) << degrees << " at " << x;
  }
}

TEST(Stage7Traversability, AKerbLowerThanAStepIsPassableAHigherOneIsNot)
{
  for (const double height_m : {0.14, 0.3})
  {
    TestMap m(Scan(2, 0, 0.7)
                  .add_surface(0, -1, 2.05, 1, flat)
                  .add_surface(2.05, -1, 4, 1, level(height_m)));
    int blocked = 0;
    for (double x = 1.525; x < 2.6; x += 0.05) blocked += m.traversability(x, 0.025) == 0.0f;
    EXPECT_EQ(blocked > 0, height_m > 0.2) << height_m;
    EXPECT_EQ(m.at(Layer::Slope, 2.025, 0.025), 0.0f) << "its plane is too steep";
  }
}

TEST(Stage7Traversability, AKerbOfWhichTheFaceWasHitBetweenRoughGroundIsPassable)
{
  // The lowest hits of its cells lie anywhere on the face.
  Random random(14);
  std::vector<float> face_m(40);
  for (float& z : face_m) z = static_cast<float>(random.uniform(0.01, 0.12));
  TestMap m(Scan(2, 0, 0.7)
                .add_surface(
                    0, -1, 4, 1,
                    [&](double x, double y)
                    {
                      const auto row = static_cast<std::size_t>((y + 1) / 0.05);
                      const double rough_m = 0.006 * std::sin(9 * x) * std::cos(11 * y);
                      return x < 2.05 ? rough_m : x < 2.1 ? face_m[row] : 0.14 + rough_m;
                    })
                .add_surface(2.05, -1, 2.1, 1, level(0.14)));
  for (double y = -0.775; y < 0.8; y += 0.05)
    for (double x = 1.825; x < 2.4; x += 0.05)
      EXPECT_GT(m.traversability(x, y), 0.0f) << x << "," << y;
}

TEST(Stage7Traversability, AWallBesideAKerbIsNoStepThatTheRobotTakes)
{
  TestMap m(Scan(2, 0, 0.7).add_surface(
      0, -1, 4, 1, [](double x, double) { return x < 2.05  ? 0.0
                                                 : x < 2.2 ? 0.14
                                                           : 0.4; }));
  for (double y = -0.775; y < 0.8; y += 0.05) EXPECT_EQ(m.traversability(2.225, y), 0.0f) << y;
}

TEST(Stage7Traversability, WholeNeighbourhoodsHaveTheSlopeThatAllHave)
{
  // The short way to it gives the same bits as the long one.
  std::mt19937 random(8);
  std::uniform_int_distribution<int> height(-20000, 20000), step(-2000, 2000);
  for (int radius : {1, 2, 3, 15})
    for (int i = 0; i < 200; i++)
    {
      kernels::Config k{};
      k.feature_radius_cells = radius;
      k.inverse_resolution = 20.0f;
      const int base = height(random);
      kernels::Moments m;
      for (int y = -radius; y <= radius; y++)
      {
        kernels::RowSums row;
        for (int x = -radius; x <= radius; x++) row.add({base + step(random), 0}, x);
        m.add(row, y);
      }
      ASSERT_TRUE(kernels::is_whole(m, k));
      ASSERT_EQ(
          kernels::bits_of(kernels::slope_angle<true>(m, k)),
          kernels::bits_of(kernels::slope_angle<false>(m, k)));
    }
}

TEST(Stage7Traversability, NoRobotFitsBetweenTwoPostsAtTheCornersOfACell)
{
  for (const double across_m : {-0.05, 0.05})
    for (const bool two : {true, false})
    {
      Scan s = Scan().add_surface(1, -1, 3, 1, flat).add(1.975, 0.025 - across_m, 0.45);
      if (two) s.add(2.075, 0.025 + across_m, 0.45);
      TestMap m(s);
      EXPECT_EQ(m.traversability(2.025, 0.025) == 0.0f, two) << across_m;
    }
}

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
Parameters short_search() { return with({{"fill_search_m", 0.5}}); }
constexpr double kX = 1.525, kY = 0.025;
/** What a slope half as steep as is allowed explains, over the 21 cells between both sides. */
const double kSlope_m = 0.5 * std::tan(Parameters().slope_threshold_rad) * 1.05;
/** So high that the sensor sees the far side over the edge. */
constexpr double kHigh_m = 0.9;
}  // namespace

TEST(Stage7Sparsity, Equation14ByNumbersWorkedOutByHand)
{
  // h_s = 0.12 m < h_c = 0.2 m: 1 - 0.12 / 0.2.
  TestMap shallow(gap(kSlope_m + 0.12, 1.5, kHigh_m), short_search());
  EXPECT_NEAR(shallow.at(Layer::Sparsity, kX, kY), 0.4, 1e-5);
  // h_s = 0.25 m >= h_c, 1.5 m away with d_c = 2 m: 1 - 0.25 * 2 / (0.2 * 1.5) < 0.
  TestMap deep(gap(kSlope_m + 0.25, 1.5, kHigh_m), short_search());
  EXPECT_EQ(deep.at(Layer::Sparsity, kX, kY), 0.0f);
  EXPECT_EQ(deep.traversability(kX, kY), 0.0f);
  // h_s = 0.3 m >= h_c, 1.5 m away with d_c = 0.6 m: 1 - 0.3 * 0.6 / (0.2 * 1.5) = 0.4.
  Parameters p = short_search();
  p.sparsity_distance_m = 0.6;
  TestMap far(gap(kSlope_m + 0.3, 1.5, kHigh_m), p);
  EXPECT_NEAR(far.at(Layer::Sparsity, kX, kY), 0.4, 1e-4);
}

TEST(Stage7Sparsity, WhatADrivableSlopeExplainsIsNoDitch)
{
  // The crest of a ramp: the floor behind it is 0.3 m lower, a metre away.
  TestMap m(with_rays(gap(0.3)), short_search());
  EXPECT_TRUE(std::isnan(m.at(Layer::Sparsity, kX, kY)));
  EXPECT_GT(m.traversability(kX, kY), 0.0f);
}

TEST(Stage7Sparsity, OneHeightOrNoneLeavesTheCellUnknown)
{
  TestMap m(gap(2), short_search());  // nothing on the far side
  EXPECT_EQ(m.state(kX, kY), CellState::FilledOneSided);
  EXPECT_TRUE(std::isnan(m.at(Layer::Sparsity, kX, kY)));
  EXPECT_TRUE(std::isnan(m.traversability(kX, kY)));
}

TEST(Stage7Sparsity, FarFromTheRobotAGuessIsJudgedByItsGeometry)
{
  Parameters p = short_search();
  p.sparsity_range_m = 1.0;
  TestMap m(with_rays(gap(2)), p);
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
    EXPECT_NEAR(fall_in({length_m, 0, -0.6f, -0.25f, 0.3f}, k).m, hollow_m, 1e-5f) << "by half";
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
    TestMap m(s, short_search());
    EXPECT_EQ(m.traversability(kX, kY) == 0.0f, wall);
  }
}
