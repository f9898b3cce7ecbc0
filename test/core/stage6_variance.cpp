// What the map tells of the errors of its heights.
#include <gtest/gtest.h>

#include "scene.h"
#include <talus/risk.h>
#include "kernels/7_risk.h"

using namespace talus;
using namespace talus::test;

namespace
{
constexpr double kX = 2.025, kY = 0.025;

/** Ground 1 m wide around the cell asked, seen so many times; `height(x, y)` in the map frame. */
template <class Height>
TestMap map_of(const Height& height, int scans = 1)
{
  TestMap m;
  for (int i = 0; i < scans; i++) m.update(Scan().add_surface(1.5, -0.5, 2.5, 0.5, height));
  return m;
}
double deviation_m(const TestMap& m, double x, double y)
{
  return std::sqrt(static_cast<double>(m.at(Layer::Variance, x, y)));
}
/** A height of its own for each cell, without any order, between -1 and 1. */
double scattered(double x, double y)
{
  const auto cell = [](double at)
  { return static_cast<std::uint64_t>(std::lround(at / 0.05 + 500)); };
  return Random(cell(x) * 1000 + cell(y)).uniform(-1, 1);
}
}  // namespace

TEST(Stage6Variance, OfALoneHitIsThatOfItsMeasurementAndOfItsBeam)
{
  TestMap m(Scan().add(kX, kY, 0.0), with({{"c_beam_m", 0.02}, {"a_beam", 0}}));
  // The cell lies 2 m from the robot's.
  EXPECT_NEAR(deviation_m(m, kX, kY), std::hypot(0.02, 2 * 0.0035), 1e-4);
}

TEST(Stage6Variance, OfALoneHitKeepsTheErrorOfItsBeamHoweverOftenItIsSeen)
{
  TestMap m(Scan().add(kX, kY, 0.0), {}, 40);
  EXPECT_LT(std::sqrt(m.fused_variance(kX, kY)), 0.002);
  EXPECT_NEAR(deviation_m(m, kX, kY), 2 * 0.0035, 5e-4);
}

TEST(Stage6Variance, IsThreeTimesTheScatterWhereOneAxisAloneShowsIt)
{
  // A ring of beams, three cells wide, and ground as wide as long that is as rough along x.
  const auto rough = [](double x, double) { return 0.02 * scattered(x, 0); };
  TestMap ring(Scan().add_surface(1.5, -0.05, 2.5, 0.1, rough));
  EXPECT_NEAR(deviation_m(ring, kX, kY), 3 * deviation_m(map_of(rough), kX, kY), 1e-4);
}

TEST(Stage6Variance, OfASmoothPlaneIsSmallWhateverItsSlope)
{
  const TestMap level = map_of(flat);
  const TestMap slope = map_of([](double x, double) { return 0.3 * (x - 2); });
  EXPECT_LT(deviation_m(level, kX, kY), 0.0015);
  EXPECT_NEAR(deviation_m(slope, kX, kY), deviation_m(level, kX, kY), 1e-4);
}

TEST(Stage6Variance, FollowsTheScatterOfTheGround)
{
  for (const double amplitude_m : {0.005, 0.02})
  {
    const TestMap m = map_of([=](double x, double y) { return amplitude_m * scattered(x, y); });
    const double scatter_m = amplitude_m / std::sqrt(3.0);  // of a uniform distribution
    double sum_m = 0;
    int cells = 0;
    for (double x = 1.725; x < 2.3; x += 0.05)
      for (double y = -0.275; y < 0.3; y += 0.05, cells++) sum_m += deviation_m(m, x, y);
    EXPECT_NEAR(sum_m / cells, 1.1 * scatter_m, 0.25 * scatter_m) << amplitude_m;
  }
}

TEST(Stage6Variance, ReliefThatGrowsWithTheDistanceCountsMoreThanNoise)
{
  // A ridge as wide as the larger neighbourhood: its middle strays little from 3 x 3 cells.
  const TestMap ridge = map_of([](double x, double) { return -0.5 * std::abs(x - kX); });
  const TestMap noise =
      map_of([](double x, double y) { return 0.014 * scattered(x, y) * std::sqrt(3.0); });
  EXPECT_GT(deviation_m(ridge, kX, kY), 0.02);
  EXPECT_GT(deviation_m(noise, kX, kY), 0.005);
}

TEST(Stage6Variance, OfAFillGrowsWhereItsLinesDisagree)
{
  // Between two strips at the same height, and between strips of which one is 0.1 m higher.
  const auto gap = [](double far_m)
  {
    TestMap m(Scan()
                  .add_surface(1.0, -1.0, 1.5, 1.0, flat)
                  .add_surface(2.0, -1.0, 2.5, 1.0, level(far_m)));
    return deviation_m(m, 1.775, 0.025);
  };
  EXPECT_LT(gap(0.0), 0.02);
  EXPECT_GT(gap(0.1), 1.5 * gap(0.0));
}

TEST(Stage6Variance, OfAFillFromOneSideIsATenthOfItsGapAtLeastWhateverLiesBesideIt)
{
  // Columns have ground on both sides close by, the line from the sensor none behind.
  TestMap m(Scan()
                .add_surface(1.0, -0.15, 1.5, 0.2, flat)
                .add_surface(1.5, 0.15, 2.4, 0.2, flat)
                .add_surface(1.5, -0.15, 2.4, -0.1, flat));
  for (double x = 1.525; x < 2.3; x += 0.05)
  {
    ASSERT_EQ(m.state(x, kY), CellState::FilledOneSided) << x;
    EXPECT_GT(deviation_m(m, x, kY), 0.1 * (x - 1.475)) << x;
    EXPECT_LT(deviation_m(m, x, kY), 0.15 * (x - 1.475) + 0.02) << x;
  }
}

TEST(Stage6Variance, CountsWhatStraysAlongEitherAxis)
{
  double along_m[2] = {};
  for (const bool x_axis : {false, true})
  {
    const TestMap m =
        map_of([=](double x, double y) { return 0.02 * scattered(x_axis ? x - 2 : y, 0); });
    along_m[x_axis] = deviation_m(m, kX, kY);
  }
  EXPECT_GT(along_m[0], 0.005);
  EXPECT_NEAR(along_m[0], along_m[1], 1e-3);
}

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
  TestMap m(
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
