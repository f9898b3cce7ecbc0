// How often heights lie within the deviations that are told of them.
#include <gtest/gtest.h>
#include <talus/baselines/score.h>
#include <talus/baselines/real_log.h>
#include <talus/sim/random.h>

#include <cmath>
#include <limits>

using namespace talus;
using namespace talus::baselines;

namespace
{
constexpr int kMany = 20000;
constexpr double kShare = 0.015;  //!< four deviations of a share of kMany

/** Normal errors of a deviation, told as another. */
EstimateErrors normal_errors(double true_m, double estimated_m)
{
  sim::Random random(7);
  EstimateErrors e;
  for (int i = 0; i < kMany; ++i)
    e.add(
        static_cast<float>(true_m * random.normal()),
        static_cast<float>(estimated_m * estimated_m));
  return e;
}

TEST(EstimateErrors, WithinOneAndTwoTrueDeviationsAre68And95Percent)
{
  const EstimateErrors e = normal_errors(0.01, 0.01);
  EXPECT_NEAR(e.within(1), 0.683, kShare);
  EXPECT_NEAR(e.within(2), 0.954, kShare);
  for (const double p : {0.1, 0.5, 0.9}) EXPECT_NEAR(e.share_within(p), p, kShare);
  EXPECT_NEAR(e.true_m(), 0.01, 3e-4);
}

TEST(EstimateErrors, OfAModestMapAreNearlyAllWithinOne)
{
  EXPECT_GT(normal_errors(0.01, 0.04).within(1), 0.99);
  EXPECT_LT(normal_errors(0.04, 0.01).within(2), 0.45);
}

TEST(EstimateErrors, LeaveOutWhatHasNoVariance)
{
  EstimateErrors e;
  e.add(0.1f, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(e.count(), 0U);
  EXPECT_TRUE(std::isnan(e.within(1)));
}

TEST(HeightBars, AreKeptByKindAndDistance)
{
  Surfaces map(Window{8, 1.0, 0, 0});
  map.variance_m2.assign(64, 0.04f);
  const auto cell = [](int x, int y) { return static_cast<std::size_t>(8 * y + x); };
  map.state[cell(4, 4)] = static_cast<std::uint8_t>(CellState::Measured);
  map.state[cell(7, 4)] = static_cast<std::uint8_t>(CellState::FilledOneSided);
  HeightBars bars;
  EXPECT_TRUE(bars.empty());
  for (const auto k : {cell(4, 4), cell(7, 4), cell(0, 0)}) bars.add(map, k, -0.1f, 0.05f);
  EXPECT_EQ(bars.near(0).count(), 1U);
  EXPECT_EQ(bars.far(2).count(), 1U);
  EXPECT_EQ(
      bars.all(0).count() + bars.all(1).count() + bars.all(2).count() + bars.all(3).count(), 2U);
  EXPECT_FLOAT_EQ(bars.near(0).estimated_m[0], 0.3f);
  EXPECT_FLOAT_EQ(bars.near(0).abs_m[0], 0.1f);
}

/** One scan of a floor in rings, each point with an error of its own. */
Sequence scan_of_a_floor(double error_m)
{
  Sequence s;
  sim::Random random(3);
  ScanFrame f;
  f.T_map_sensor.m[11] = 1.0;
  for (double range_m = 0.6; range_m < 3.5; range_m += 0.02)
  {
    for (int a = 0; a < 720; ++a)
    {
      f.x_m.push_back(static_cast<float>(range_m * std::cos(a * M_PI / 360)));
      f.y_m.push_back(static_cast<float>(range_m * std::sin(a * M_PI / 360)));
      f.z_m.push_back(static_cast<float>(-1 + error_m * random.normal()));
    }
  }
  s.frames.push_back(std::move(f));
  return s;
}

TEST(HoldOut, ComparesTheHeightsOfTwoMapsWithWhatBothTell)
{
  EvaluationOptions small;
  small.parameters.window_m = 4, small.parameters.resolution_m = 0.1;
  for (const double error_m : {0.002, 0.01})
  {
    const HoldOut out = hold_out(scan_of_a_floor(error_m), small, nullptr);
    const EstimateErrors measured = out.bars.all(0);
    ASSERT_GT(measured.count(), 100U);
    EXPECT_LT(measured.true_m(), 2 * error_m);
    EXPECT_GT(measured.within(2), 0.85) << error_m;
    EXPECT_LT(measured.median_estimated_m(), 3 * error_m);
  }
}

/** Floor at z = 0, and labels that say so; `put` moves points of a scan of it, in the map frame. */
template <class Put>
HoldOut held_out_of_floor(const Put& put)
{
  EvaluationOptions small;
  small.parameters.window_m = 6, small.parameters.resolution_m = 0.1;
  Sequence scan = scan_of_a_floor(0.002);
  ScanFrame& f = scan.frames[0];
  for (std::size_t i = 0; i < f.x_m.size(); ++i)
    if (std::abs(f.y_m[i]) < 1.5F) put(f.x_m[i], f.z_m[i]);
  LabelMap labels;
  labels.stack = {60, 60, 0.1, -3, -3, {"ground", "label"}, {}};
  labels.stack.layers = {std::vector<float>(3600, 0), std::vector<float>(3600, LabelMap::kGround)};
  return hold_out(scan, small, &labels);
}

TEST(HoldOut, PredictsTheFloorAndNeitherABankNorAWall)
{
  const HoldOut floor = held_out_of_floor([](float, float) {});
  EXPECT_GT(floor.not_ground.of, 40);
  EXPECT_EQ(floor.not_ground.part, 0);
  const HoldOut bank = held_out_of_floor(
      [](float& x, float& z)
      {
        if (x > 1.5F) z = -1 + 0.5F * (x - 1.5F);
      });
  EXPECT_GT(bank.not_ground.of, 40);
  EXPECT_LT(bank.not_ground.value(), 0.02);
  const HoldOut wall = held_out_of_floor(
      [](float& x, float& z)
      {
        if (x < -1.5F) z = -0.8F + 0.5F * (-1.5F - x), x = -2.05F;
      });
  EXPECT_GT(wall.not_ground.of, 40);
  EXPECT_EQ(wall.not_ground.part, 0);
}

}  // namespace
