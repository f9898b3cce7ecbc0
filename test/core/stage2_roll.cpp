#include <gtest/gtest.h>
#include "scene.h"

#include <array>
#include <cstdlib>

using namespace talus;
using namespace talus::test;

namespace
{
/** The heights of cells and their variances, then the states. */
std::vector<std::array<float, 5>> surfaces(const TestMap& m, const CellRect& cells)
{
  std::vector<std::array<float, 5>> all;
  for (const CellRecord& r : m.map.read_cells({cells}))
    all.push_back(
        {r.ground_m, r.ground_variance_m2, r.elevation_m, r.elevation_variance_m2,
         static_cast<float>(r.state)});
  return all;
}
}  // namespace

TEST(Stage2Roll, AnyWholeNumberOfCellsKeepsWhatStays)
{
  const int moves[][2] = {{1, 0}, {-1, 0}, {0, 3}, {5, -7}, {-80, 40}, {159, 159}, {-159, 0}};
  for (const auto& move : moves)
  {
    TestMap m(textured(0.02, 0.02));
    const auto [dx, dy] = move;
    const Window w = m.map.window();
    const CellRect common{
        w.min_cell_x + std::max(dx, 0), w.min_cell_y + std::max(dy, 0), 160 - std::abs(dx),
        160 - std::abs(dy)};
    const auto before = surfaces(m, common);
    m.update(Scan(0.02 + 0.05 * dx, 0.02 + 0.05 * dy));
    // In a full map nothing is filled: cells that enter may be guessed, others may not change.
    EXPECT_EQ(before.size(), common.size());
    EXPECT_TRUE(before == surfaces(m, common)) << dx << "," << dy;
  }
}

TEST(Stage2Roll, WhatEntersIsEmptyEvenWhenItWasSeenLongAgo)
{
  TestMap m(textured(0, 0));
  m.update(Scan(20, 0));
  m.update(Scan(0, 0));
  for (float v : m.map.layer(Layer::State)) EXPECT_EQ(v, 0.0f);
  for (float v : m.map.layer(Layer::Elevation)) EXPECT_TRUE(std::isnan(v));
}

namespace
{
constexpr double kCell_m = 0.2;

/** A height of its own for every cell of the map, which a float has exactly. */
double height_of(std::int64_t cell_x, std::int64_t cell_y)
{
  const auto mixed = static_cast<std::uint64_t>(cell_x * 7919 + cell_y * 104729);
  return static_cast<double>(mixed % 64) / 4096;
}

/** The column of cells at cell_x, as many as the window is wide, from a sensor at cell `at`. */
Scan column(std::int64_t at, std::int64_t cell_x, int cells)
{
  Scan s((static_cast<double>(at) + 0.5) * kCell_m, 0.5 * kCell_m, 0.5);
  for (std::int64_t y = -cells / 2; y < cells / 2; y++)
    s.add(
        (static_cast<double>(cell_x) + 0.5) * kCell_m, (static_cast<double>(y) + 0.5) * kCell_m,
        height_of(cell_x, y));
  return s;
}
}  // namespace

TEST(Stage2Roll, OnTheLast10KmOf100NothingDriftsByABit)
{
  // In each step a column of cells at the front is measured, once. While the window rolls over it,
  // it must stay as it is. What adds up wrongly does so fastest far from the origin.
  constexpr std::int64_t kStep_cells = 9, kSteps = 5556, kBegin_cells = 50000 * kStep_cells;
  TestMap m(with({{"resolution_m", kCell_m}, {"window_m", 4}}));
  const int n = m.map.parameters().cells();
  std::int64_t wrong = 0, checked = 0;
  for (std::int64_t i = 0; i < kSteps; i++)
  {
    const std::int64_t at = kBegin_cells + kStep_cells * i;
    m.update(column(at, at + kStep_cells, n));
    const Window w = m.map.window();
    ASSERT_EQ(w.min_cell_x, at - n / 2);
    ASSERT_EQ(w.min_cell_y, -n / 2);
    if (i % 11) continue;  // layers are copied for it
    const auto &ground = m.map.layer(Layer::GroundElevation), &state = m.map.layer(Layer::State);
    for (std::int64_t x = at + kStep_cells; x >= w.min_cell_x && x > kBegin_cells; x -= kStep_cells)
      for (int iy = 0; iy < n; iy++)
      {
        const auto o = static_cast<std::size_t>(iy * n + (x - w.min_cell_x));
        checked++;
        if (state[o] != 1.0f || ground[o] != static_cast<float>(height_of(x, iy - n / 2))) wrong++;
      }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(checked, 3 * n * (kSteps / 11 - 2));
}

TEST(Stage2Roll, TheWindowFollowsTheBaseWhereTheFrameTellsWhereTheSensorIs)
{
  TestMap m;
  Pose scaled = translation(0, 0, 0.7);
  scaled.m[0] = 2;
  for (const Pose& bad : {translation(std::nan(""), 0, 0), translation(2000, 0, 0), scaled})
    EXPECT_THROW(m.update(Scan(), bad), std::invalid_argument);
  EXPECT_TRUE(m.map.empty());
  Scan s(3.0, -1.0, 0.9);  // turned to the left, 0.4 m before the middle of the robot
  s.pose_.m = {0, -1, 0, 3.0, 1, 0, 0, -1.0, 0, 0, 1, 0.9};
  m.update(s, translation(0.4, 0.0, 0.9));
  const Window w = m.map.window();
  EXPECT_NEAR(w.min_x_m() + w.cells / 2 * w.resolution_m, 3.0, 0.051);
  EXPECT_NEAR(w.min_y_m() + w.cells / 2 * w.resolution_m, -1.4, 0.051);
}

TEST(Stage2Roll, ASensorFarFromTheBaseMapsWhatIsInTheWindow)
{
  // Beyond an eighth of the window, and beyond the window itself.
  for (const double ahead_m : {0.0, 0.9, 2.0, 10.0})
  {
    TestMap m;
    Scan s = Scan(ahead_m, 0, 0.7)
                 .add_surface(1.0, -1.0, 3.0, 1.0, flat)
                 .add_surface(2.0, 0.0, 2.1, 0.1, level(0.4));
    for (int i = 0; i < 4; i++) m.update(s, translation(ahead_m, 0, 0.7));
    EXPECT_EQ(m.map.window().min_cell_x, -80) << ahead_m;
    EXPECT_NEAR(m.ground(1.525, 0.525), 0.0, 1e-3) << ahead_m;
    EXPECT_NEAR(m.elevation(2.025, 0.025), 0.4, 1e-3) << ahead_m;
  }
}

TEST(Stage2Follow, HeightsFollowThePosesByTheMeanOfAllHitsThatAgree)
{
  // The pose rose by 0.22 m, and noise spreads the hits over three bins of the histogram.
  Random random(3);
  const auto risen = [&random](double, double)
  { return 0.22 + 0.04 * std::floor(random.uniform(-1, 2)); };
  TestMap m(Scan(0, 0, 0.7).add_surface(1.0, -1.0, 3.5, 1.0, flat));
  m.update(Scan(0, 0, 0.92).add_surface(1.0, -1.0, 3.0, 1.0, risen));
  EXPECT_NEAR(m.ground(3.225, 0.025), 0.22, 0.01);  // not hit again
}

TEST(Stage2Follow, GrassThatStandsUpBehindTheRobotDoesNotRaiseTheMap)
{
  // Blades hide the ground of the track, which the robot knows from having stood there. No other
  // cell is bare, and a scanner of many beams hits many blades beside the robot.
  TestMap m;
  for (int i = 0; i < 20; i++)
  {
    const double x = 0.1 * i;
    Scan s(x, 0, 0.7);
    const auto low = [](double, double y) { return std::abs(y) < 0.4 ? 0.36 : 0.0; };
    const double from_m = i == 0 ? -1 : 0;
    s.add_surface(from_m, -1, 4, 1, low).add_surface(from_m, -1, 4, 1, level(0.47));
    for (int k = 0; k < 8; k++) s.add_surface(x - 0.3, -0.3, x + 0.3, 0.3, level(0.38 + 0.01 * k));
    m.update(s, translation(0, 0, 0.7), 0.1 * i);
  }
  EXPECT_NEAR(m.ground(-0.525, 0.725), 0, 0.05) << "seen in the first frame only";
}

TEST(Stage2Follow, WallsBesideTheRobotDoNotRaiseTheMap)
{
  // Each frame hits the walls of a corridor a little higher than the one before, and no floor.
  TestMap m;
  const Box left{{-2, 0.45, 0}, {6, 0.5, 2}}, right{{-2, -0.5, 0}, {6, -0.45, 2}};
  for (int i = 0; i < 20; i++)
  {
    const Scan s = Scan(0.1 * i, 0, 0.68).cast({left, right}, 720, -0.26, 0.26, 16);
    m.update(s, translation(0, 0, 0.68), 0.1 * i);
  }
  EXPECT_NEAR(m.ground(1.925, 0.025), 0, 0.02) << "below the robot";
}
