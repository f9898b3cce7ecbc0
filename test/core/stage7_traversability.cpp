#include <gtest/gtest.h>
#include "kernels/7_traversability.h"
#include "scene.h"

#include <algorithm>
#include <random>

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
    Parameters p;
    p.min_range_m = 0.01;
    TestMap m(p);
    const double t = std::tan(10 * M_PI / 180), a = azimuth_deg * M_PI / 180;
    Scan s(0, 0, 0);  // at this height the whole plane is inside the height band
    s.add_surface(
        -4, -4, 4, 4, [&](double x, double y) { return t * (std::cos(a) * x + std::sin(a) * y); });
    m.update(s);
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
  TestMap m;
  m.update(Scan().add_surface(-4, -4, 4, 4, flat));
  for (double v : m.map.layer(Layer::Traversability))
  {
    if (v == v)
    {
      EXPECT_NEAR(v, 1.0, 1e-6);
    }
  }
  EXPECT_NEAR(m.traversability(-3.975, 3.975), 1.0, 1e-6);
}

TEST(Stage7Traversability, AWallOneCellThickBlocksAtMostItsOwnCellsAndTheirNeighbours)
{
  TestMap m;
  const Box wall{{1.51, -2, 0}, {1.54, 2, 1.2}};
  for (int i = 0; i < 5; i++)
  {
    Scan s(0, 0, 0.7);
    s.add_surface(-3, -3, 3, 3, flat);  // the floor on both sides is known
    m.update(s.cast({wall}));
  }
  for (double y = -1.475; y < 1.5; y += 0.05)
  {
    EXPECT_EQ(m.traversability(1.525, y), 0.0f) << y;
    EXPECT_GT(m.traversability(1.425, y), 0.9f) << y;
    EXPECT_GT(m.traversability(1.625, y), 0.9f) << y;
  }
}

TEST(Stage7Traversability, ASlopeOfFortyDegreesIsImpassable)
{
  TestMap m;
  const double t = std::tan(40 * M_PI / 180);
  m.update(Scan().add_surface(-1, -1, 1, 1, [&](double x, double) { return t * x; }));
  EXPECT_EQ(m.traversability(0.525, 0.525), 0.0f);
}

TEST(Stage7Traversability, Equations10To13ByNumbersWorkedOutByHand)
{
  // One cell 0.04 m above 48 flat neighbours. Mean of the 49: 0.04 / 49.
  Parameters p;
  p.feature_radius_m = 0.15;
  TestMap m(p);
  Scan s;
  s.add_surface(
      1, -1, 3, 1,
      [](double x, double y)
      { return std::abs(x - 2.025) < 0.01 && std::abs(y - 0.025) < 0.01 ? 0.04 : 0.0; });
  m.update(s);
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
  TestMap m;
  Scan s;
  s.add_surface(1, -1, 3, 1, flat);
  s.add_surface(2.0, -1, 2.05, 1, level(0.45));
  m.update(s);
  EXPECT_EQ(m.at(Layer::Step, 1.975, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Roughness, 1.975, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Step, 2.025, 0.025), 0.0f);
}

TEST(Stage7Traversability, TooFewNeighboursLeaveTheSlopeAndWithItTheCellUnknown)
{
  Parameters p;
  p.fill_search_m = 0;
  TestMap m(p);
  m.update(Scan().add(2.025, 0.025, 0).add(2.075, 0.025, 0));
  EXPECT_EQ(m.state(2.025, 0.025), CellState::Measured);
  EXPECT_TRUE(std::isnan(m.traversability(2.025, 0.025)));
}

TEST(Stage7Traversability, UnknownCellsHaveNoFeatures)
{
  TestMap m;
  m.update(Scan());
  for (int l = static_cast<int>(Layer::Slope); l < kLayerCount; l++)
    for (float v : m.map.layer(static_cast<Layer>(l))) ASSERT_TRUE(std::isnan(v));
}

TEST(Stage7Traversability, BehindABoxThatRaysPassOverNothingIsKnownToBeFree)
{
  TestMap m;
  const Box box{{1.5, -0.5, 0}, {2.3, 0.5, 0.4}};
  for (int i = 0; i < 3; i++) m.update(Scan().cast({box}));
  EXPECT_FALSE(m.traversability(2.425, 0.025) > 0.0f);  // in its shadow
  EXPECT_GT(m.traversability(1.0, 0.025), 0.8f);  // seen
  EXPECT_GT(m.traversability(0.5, 0.025), 0.8f);  // blind zone
}

TEST(Stage7Traversability, AGapOfOneCellBetweenImpassableCellsIsImpassable)
{
  for (const int gap_cells : {1, 3})
  {
    TestMap m;
    Scan s;
    s.add_surface(1, -1, 3, 1, flat);
    const double gap_m = 0.05 * gap_cells;
    for (const double x : {2.0 - 0.2, 2.0 + gap_m})
      s.add_surface(x, -0.5, x + 0.2, 0.5, level(0.45));
    m.update(s);
    EXPECT_EQ(m.traversability(2.0 + gap_m / 2, 0.025) == 0.0f, gap_cells == 1) << gap_cells;
  }
}

TEST(Stage7Traversability, ASteepFaceIsImpassableUpToItsEdge)
{
  for (const double degrees : {45.0, 25.0})
  {
    TestMap m;
    Scan s;
    const double rise = std::tan(degrees * M_PI / 180);
    s.add_surface(
        1, -1, 4, 1, [&](double x, double) { return rise * std::clamp(x - 2.0, 0.0, 0.6); });
    m.update(s);
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
    TestMap m;
    Scan s(2, 0, 0.7);
    s.add_surface(0, -1, 2.05, 1, flat);
    s.add_surface(2.05, -1, 4, 1, [&](double, double) { return height_m; });
    m.update(s);
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
  TestMap m;
  Scan s(2, 0, 0.7);
  s.add_surface(
      0, -1, 4, 1,
      [&](double x, double y)
      {
        const auto row = static_cast<std::size_t>((y + 1) / 0.05);
        const double rough_m = 0.006 * std::sin(9 * x) * std::cos(11 * y);
        return x < 2.05 ? rough_m : x < 2.1 ? face_m[row] : 0.14 + rough_m;
      });
  s.add_surface(2.05, -1, 2.1, 1, level(0.14));
  m.update(s);
  for (double y = -0.775; y < 0.8; y += 0.05)
    for (double x = 1.825; x < 2.4; x += 0.05)
      EXPECT_GT(m.traversability(x, y), 0.0f) << x << "," << y;
}

TEST(Stage7Traversability, AWallBesideAKerbIsNoStepThatTheRobotTakes)
{
  TestMap m;
  Scan s(2, 0, 0.7);
  s.add_surface(
      0, -1, 4, 1, [](double x, double) { return x < 2.05  ? 0.0
                                                 : x < 2.2 ? 0.14
                                                           : 0.4; });
  m.update(s);
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
      TestMap m;
      Scan s;
      s.add_surface(1, -1, 3, 1, flat).add(1.975, 0.025 - across_m, 0.45);
      if (two) s.add(2.075, 0.025 + across_m, 0.45);
      m.update(s);
      EXPECT_EQ(m.traversability(2.025, 0.025) == 0.0f, two) << across_m;
    }
}
