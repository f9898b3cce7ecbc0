// The probability that a cell is impassable.
#include <gtest/gtest.h>
#include <talus/risk.h>
#include "kernels/7_risk.h"

#include "scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
float risk_at(const TestMap& m, double x, double y)
{
  const auto i = m.map.window().index_at(x, y);
  return risk(m.map)[*i];
}
/** Ground that rises by so much, with a ripple of some mm. */
TestMap slope_of(double angle_rad, double ripple_m)
{
  TestMap m;
  const double rise = std::tan(angle_rad);
  m.update(Scan().add_surface(
      1.0, -1.0, 3.0, 1.0,
      [=](double x, double y)
      { return rise * (x - 2) + ripple_m * std::sin(30 * x + 3 * y) * std::cos(50 * y); }));
  return m;
}
}  // namespace

TEST(Risk, NormalSharesAreThoseOfTheTables)
{
  EXPECT_NEAR(kernels::normal_below(0), 0.5f, 1e-6f);
  EXPECT_NEAR(kernels::normal_below(1), 0.8413f, 4e-4f);
  EXPECT_NEAR(kernels::normal_below(-2), 0.0228f, 4e-4f);
  EXPECT_NEAR(kernels::normal_below(1e30f), 1.0f, 1e-6f);
  EXPECT_NEAR(kernels::normal_below(-1e30f), 0.0f, 1e-6f);
}

TEST(Risk, OfLevelGroundIsNoneAndOfAWallIsOne)
{
  TestMap m;
  m.update(
      Scan().add_surface(1.0, -1.0, 2.5, 1.0, flat).add_surface(2.5, -1.0, 3.0, 1.0, level(1.0)));
  EXPECT_LT(risk_at(m, 1.525, 0.025), 0.005f);
  EXPECT_EQ(risk_at(m, 2.525, 0.025), 1.0f);
}

TEST(Risk, IsUnknownWhereTheMapDoesNotJudge)
{
  TestMap m;
  EXPECT_TRUE(risk(m.map).empty());
  m.update(Scan().add_surface(1.0, -0.5, 1.5, 0.5, flat));
  EXPECT_TRUE(std::isnan(risk_at(m, -3.5, -3.5)));
}

TEST(Risk, GrowsTowardsTheThresholdAndWithTheScatter)
{
  const Parameters p;
  const float gentle = risk_at(slope_of(0.7 * p.slope_threshold_rad, 0.006), 2.025, 0.025);
  const float steep = risk_at(slope_of(0.95 * p.slope_threshold_rad, 0.006), 2.025, 0.025);
  const float rough = risk_at(slope_of(0.7 * p.slope_threshold_rad, 0.03), 2.025, 0.025);
  EXPECT_LT(gentle, 0.02f);
  EXPECT_GT(steep, 2 * gentle);
  EXPECT_GT(rough, 2 * gentle);
  EXPECT_LT(steep, 1.0f);
}
