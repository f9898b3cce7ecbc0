// What talus is compared with, and how it is scored: against cases worked out by hand.
#include <gtest/gtest.h>
#include <talus/baselines/fills.h>
#include <talus/baselines/real_log.h>
#include <talus/baselines/rivals.h>
#include <talus/baselines/window_truth.h>

#include <cmath>
#include <limits>

#include "message_of.h"
#include "small_window.h"

using namespace talus;
using namespace talus::baselines;

namespace
{
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/** A window of n x n cells of 0.1 m without anything known. */
SparseGround nothing_known(int n)
{
  SparseGround s;
  s.window = {n, 0.1, 0, 0};
  s.ground_m.assign(static_cast<std::size_t>(n * n), kNan);
  return s;
}

TEST(HeightGridMethod, AveragesFloorAndTableTopToNeitherAndGrowsWithTheRobotsWay)
{
  const auto map = make_method("heightgrid", small_window());
  map->update(Scan({{0.55f, 0.05f, 0.0f}, {0.55f, 0.05f, 2.0f}}).view());
  Surfaces s = map->read();
  EXPECT_NEAR(at(s, s.ground_m, 0.55, 0.05), 1.0f, kFloat_m);
  EXPECT_TRUE(std::isnan(at(s, s.ground_m, 0.75, 0.05)));
  Scan far({{0.55f, 0.05f, 0.3f}});
  Frame frame = far.view();
  frame.T_map_sensor.m[3] = 7.0;
  map->update(frame);
  s = map->read();
  EXPECT_NEAR(at(s, s.ground_m, 7.55, 0.05), 0.3f, kFloat_m);
}

TEST(ReadColumn, StandsOnGapsUpToTheClearanceAndHangsAboveLargerOnes)
{
  std::vector<bool> occupied(30, false);
  EXPECT_TRUE(std::isnan(read_column(occupied, 0.0, 0.1, 0.6).ground_m));
  occupied[2] = occupied[3] = occupied[7] = true;  // 0.2, 0.3, 0.7: a gap of 0.3 m
  occupied[20] = true;  // 2.0: hangs
  const Column c = read_column(occupied, 0.0, 0.1, 0.6);
  EXPECT_NEAR(c.ground_m, 0.2f, kFloat_m);
  EXPECT_NEAR(c.elevation_m, 0.7f, kFloat_m);
}

TEST(OctoMapMethod, SeesThePointsWhereTheyAreAndTheRaysFromTheSensor)
{
  OctoMapMethod map(small_window());
  map.update(Scan({{0.85f, 0.05f, 0.05f}, {0.85f, 0.05f, 0.45f}}).view());
  const Surfaces s = map.read();
  EXPECT_NEAR(at(s, s.ground_m, 0.85, 0.05), 0.05f, kFloat_m);
  EXPECT_NEAR(at(s, s.elevation_m, 0.85, 0.05), 0.45f, kFloat_m);
  EXPECT_EQ(at(s, s.traversability, 0.85, 0.05), 0.0f);
  double occupancy = 0;
  ASSERT_TRUE(map.map().getPointOccupancy(0.45f, 0.05f, 0.47f, occupancy));
  EXPECT_LT(occupancy, 0.5);
}

TEST(HighestPointMap, KeepsTheHighestAndFusesWhatIsNear)
{
  Parameters p = small_window();
  p.a_beam = 0;  // all points have the same variance
  const auto map = make_method("highest", p);
  map->update(Scan({{0.55f, 0.05f, 0.0f}, {0.55f, 0.05f, 0.4f}, {0.55f, 0.05f, 0.0f}}).view());
  Surfaces s = map->read();
  EXPECT_NEAR(at(s, s.elevation_m, 0.55, 0.05), 0.4f, kFloat_m);
  map->update(Scan({{0.55f, 0.05f, 0.41f}}).view());
  s = map->read();
  EXPECT_NEAR(at(s, s.elevation_m, 0.55, 0.05), 0.405f, kFloat_m);
}

TEST(HighestPointMap, ErasesOnceASecondWhatRaysWentThrough)
{
  const auto map = make_method("highest", small_window());
  map->update(Scan({{0.45f, 0.05f, 0.45f}}, 10.0).view());
  map->update(Scan({{0.85f, 0.05f, 0.0f}}, 10.5).view());
  Surfaces s = map->read();
  EXPECT_NEAR(at(s, s.elevation_m, 0.45, 0.05), 0.45f, kFloat_m);
  map->update(Scan({{0.85f, 0.05f, 0.0f}}, 11.5).view());
  s = map->read();
  EXPECT_TRUE(std::isnan(at(s, s.elevation_m, 0.45, 0.05)));
}

TEST(WindowFeatures, GiveAPlaneTheWeightOfItsSlopeAndItsStep)
{
  Parameters p = small_window();
  Surfaces s(window_around(p, Pose()));
  const double slope = 0.2;
  const int n = s.window.cells;
  for (int k = 0; k < n * n; ++k) s.elevation_m[k] = static_cast<float>(slope * 0.1 * (k % n));
  judge_one_surface(s, p);
  // The neighbourhood is 5 x 5 cells: the greatest difference is 2 cells uphill.
  const double expected = 0.4 * (1 - std::atan(slope) / 0.6) + 0.3 * (1 - 0.04 / 0.2) + 0.3;
  EXPECT_NEAR(at(s, s.traversability, 0.05, 0.05), expected, 1e-4);
}

TEST(WindowFeatures, BlockAStepOfTheThresholdForTwoCellsOnBothSides)
{
  Parameters p = small_window();
  Surfaces s(window_around(p, Pose()));
  const int n = s.window.cells;
  for (int k = 0; k < n * n; ++k) s.elevation_m[k] = k % n < n / 2 ? 0.0f : 0.25f;
  judge_one_surface(s, p);
  EXPECT_GT(at(s, s.traversability, -0.25, 0.05), 0.0f);
  EXPECT_EQ(at(s, s.traversability, -0.15, 0.05), 0.0f);
  EXPECT_EQ(at(s, s.traversability, 0.15, 0.05), 0.0f);
  EXPECT_GT(at(s, s.traversability, 0.25, 0.05), 0.0f);
}

TEST(SparseKernel, IsOneAtZeroAThirdAtHalfAndZeroAtItsLength)
{
  EXPECT_DOUBLE_EQ(sparse_kernel(0, 2), 1.0);
  // d = 1/2: (2 + cos(pi)) / 3 * 1/2 + sin(pi) / (2 pi) = 1/6
  EXPECT_NEAR(sparse_kernel(1, 2), 1.0 / 6, 1e-12);
  EXPECT_EQ(sparse_kernel(2, 2), 0.0);
}

TEST(FillBgk, WeightsTheMeasuredCellsByTheKernelOfTheirDistanceUpToItsLength)
{
  SparseGround s = nothing_known(10);
  s.ground_m[0] = 1.0f;  // 0.1 m from the cell asked for
  EXPECT_FALSE(std::isnan(fill_bgk(s, 0.3)[2]));
  EXPECT_TRUE(std::isnan(fill_bgk(s, 0.3)[3]));
  s.ground_m[4] = 2.0f;  // 0.3 m
  const double near = sparse_kernel(0.1, 1.0), far = sparse_kernel(0.3, 1.0);
  const auto filled = fill_bgk(s, 1.0);
  EXPECT_NEAR(filled[1], (near * 1 + far * 2) / (near + far), 1e-5);
  EXPECT_EQ(filled[0], 1.0f);
}

TEST(FillMinFilter, SpreadsTheLowestNeighbourOneCellAPass)
{
  SparseGround s = nothing_known(8);
  s.ground_m[0] = 3.0f;
  s.ground_m[2] = 1.0f;
  const auto filled = fill_min_filter(s, 2);
  EXPECT_EQ(filled[1], 1.0f);
  EXPECT_EQ(filled[4], 1.0f);
  EXPECT_TRUE(std::isnan(filled[5]));
}

TEST(FillInpaint, KeepsALevelLevelAcrossAGapThatReachesTheBorder)
{
  for (const auto fill : {fill_inpaint_navier_stokes, fill_inpaint_telea})
  {
    SparseGround s = nothing_known(20);
    for (std::size_t k = 0; k < s.ground_m.size(); ++k)
      if (k % 20 < 8 || k % 20 > 11) s.ground_m[k] = -0.75f;
    const auto filled = fill(s, 3);
    for (float h : filled)
      EXPECT_NEAR(h, -0.75f, 1e-3f);  // Telea's term of one unit, 0.1 mm a cell
  }
}

TEST(Flood, GoesThroughOpenCellsSidewaysOnly)
{
  //  S 1 0
  //  0 0 1
  //  1 1 1
  const std::vector<std::uint8_t> open{1, 1, 0, 0, 0, 1, 1, 1, 1}, start{1, 0, 0, 0, 0, 0, 0, 0, 0};
  const std::vector<std::uint8_t> reached{1, 1, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(flood(open, start, 3), reached);
}

TEST(Score, TakesTheRootOfTheMeanSquareAndTheQuantileThatNinetyFivePercentKeep)
{
  Errors e;
  for (int i = 0; i < 19; ++i) e.add(-0.1f);
  e.add(0.5f);
  EXPECT_NEAR(e.rmse_m(), std::sqrt((19 * 0.01 + 0.25) / 20), 1e-7);
  EXPECT_FLOAT_EQ(static_cast<float>(e.quantile_m(0.95)), 0.1f);
}

TEST(Score, CallsInflationTheFarthestRingWithMoreThanFivePercentBlocked)
{
  Score s;
  for (int i = 0; i < 100; ++i)
  {
    s.ring_blocked[0].add(i < 50);
    s.ring_blocked[1].add(i < 6);
    s.ring_blocked[2].add(i < 5);
  }
  EXPECT_EQ(s.inflation_cells(), 2);
  EXPECT_TRUE(std::isnan(Score().inflation_cells()));
}

TEST(Methods, SayWhichOnesThereAreWhenTheNameIsUnknown)
{
  EXPECT_TRUE(
      has(message_of([] { make_method("occupancy", Parameters()); }),
          "talus, paper, octomap, heightgrid"));
}

TEST(Methods, AllShowTheWindowThatTalusShows)
{
  Scan scan({{0.55f, 0.05f, 0.0f}});
  Frame frame = scan.view();
  frame.T_map_sensor.m[3] = -0.31;
  frame.T_map_sensor.m[7] = 12.34;
  frame.T_base_sensor = Pose();
  frame.T_base_sensor->m[3] = 0.4;
  for (const MethodInfo& info : method_list())
  {
    const auto method = make_method(info.name, small_window());
    method->update(frame);
    const Window expected =
        window_around(small_window(), pose_of_base(frame.T_map_sensor, frame.T_base_sensor));
    const Window shown = method->read().window;
    EXPECT_EQ(shown.min_cell_x, expected.min_cell_x) << info.name;
    EXPECT_EQ(shown.min_cell_y, expected.min_cell_y) << info.name;
    EXPECT_EQ(shown.cells, expected.cells) << info.name;
  }
}

/** Floor at z = 0 in cells of 0.1 m, and a thing of half a metre in the cell around (0.55, 0.05),
 * as long as it stands. */
ScanFrame floor_with_thing(double time_s, bool stands)
{
  ScanFrame f;
  f.stamp_s = f.time_s = time_s;
  f.T_map_sensor.m[11] = 0.5;
  f.T_true = f.T_map_sensor;
  const auto add = [&](double x, double y, double z)
  {
    f.x_m.push_back(static_cast<float>(x));
    f.y_m.push_back(static_cast<float>(y));
    f.z_m.push_back(static_cast<float>(z - 0.5));
  };
  for (int iy = -10; iy < 10; ++iy)
    for (int ix = -10; ix < 10; ++ix)
      if (ix != 5 || iy != 0 || !stands) add(0.1 * ix + 0.05, 0.1 * iy + 0.05, 0);
  for (const double z : {0.02, 0.25, 0.45})
    if (stands) add(0.55, 0.05, z);
  return f;
}

/** Labels of that place, whose ground lies at a height. */
LabelMap labels_at(float ground_m)
{
  LabelMap labels;
  labels.stack = {20, 20, 0.1, -1, -1, {"ground", "label"}, {}};
  labels.stack.layers = {
      std::vector<float>(400, ground_m), std::vector<float>(400, LabelMap::kGround)};
  labels.stack.layers[0][10 * 20 + 15] = kNan;
  labels.stack.layers[1][10 * 20 + 15] = LabelMap::kObstacle;
  return labels;
}

RealLogScore score_of(
    const Sequence& sequence, const LabelMap* labels, const std::string& method = "highest")
{
  EvaluationOptions options;
  options.parameters = small_window();
  options.methods = {method};
  const Evaluation evaluation = evaluate_sequence(sequence, nullptr, nullptr, options);
  return score_real_log(sequence, evaluation, labels, options.parameters).front();
}

TEST(RealLog, LabelsSayWhatIsGroundAndWhatIsBlocked)
{
  const Sequence still{"still", {floor_with_thing(0, true), floor_with_thing(0.1, true)}};
  const LabelMap right = labels_at(0), lower = labels_at(-0.5F);
  const RealLogScore score = score_of(still, &right);
  EXPECT_EQ(score.recall.of, 2 * 399);
  EXPECT_EQ(score.recall.value(), 1);
  EXPECT_GT(score.precision.value(), 0.99);  // the thing's foot is none
  EXPECT_EQ(score.obstacle_blocked.of, 1);
  EXPECT_EQ(score.obstacle_blocked.value(), 1);
  EXPECT_GT(score.ground_passable.of, 300);
  EXPECT_EQ(score.low_blocked.of, 0);
  EXPECT_EQ(score_of(still, &lower).precision.value(), 0);
}

TEST(RealLog, WhatIsLabelledAsMovingAndThenWasGroundHasLeft)
{
  Sequence passes{"passes", {}};
  for (int i = 0; i < 8; ++i) passes.frames.push_back(floor_with_thing(0.1 * i, i < 2));
  LabelMap labels = labels_at(0);
  EXPECT_EQ(score_of(passes, &labels).left_blocked.of, 0) << "what stands";
  labels.stack.layers[1][10 * 20 + 15] = LabelMap::kMoves;
  EXPECT_EQ(score_of(passes, &labels).left_blocked.of, 1);
  EXPECT_EQ(score_of(passes, nullptr).left_blocked.of, 0) << "nobody says that it moves";
  passes.frames.resize(6);  // four frames of ground are too few to say so
  EXPECT_EQ(score_of(passes, &labels).left_blocked.of, 0);
}

TEST(RealLog, LabelsSayWhatMoves)
{
  const Sequence still{"still", {floor_with_thing(0, true), floor_with_thing(0.1, true)}};
  LabelMap labels = labels_at(0);
  labels.stack.layers[1][10 * 20 + 15] = LabelMap::kMoves;
  labels.stack.layers[1][10 * 20 + 16] = LabelMap::kMoves;
  const Share swept = score_of(still, &labels, "talus").swept_blocked;
  EXPECT_EQ(swept.of, 2);
  EXPECT_EQ(swept.value(), 0.5);
}

}  // namespace
