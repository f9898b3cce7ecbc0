#include <gtest/gtest.h>
#include "scene.h"

#include <cstring>

using namespace talus;
using namespace talus::test;

namespace
{
Scan textured(double x, double y)
{
  Scan s(x, y, 0.7);
  s.add_surface(
      x - 4, y - 4, x + 4, y + 4,
      [](double u, double v) { return 0.05 * std::sin(3 * u) * std::cos(2 * v); });
  return s;
}

/** Compares the cells that both windows hold, bit by bit, in all persistent layers. Returns how
 * many. */
int expect_common_cells_equal(
    const std::array<std::vector<float>, 4>& before, const Window& wb, const ElevationMapper& after)
{
  const Window wa = after.window();
  int common = 0;
  for (int iy = 0; iy < wa.cells; iy++)
    for (int ix = 0; ix < wa.cells; ix++)
    {
      const auto bx = ix + wa.min_cell_x - wb.min_cell_x, by = iy + wa.min_cell_y - wb.min_cell_y;
      if (bx < 0 || by < 0 || bx >= wb.cells || by >= wb.cells) continue;
      common++;
      for (int l = 0; l < 4; l++)
      {
        const float a =
            after.layer(static_cast<Layer>(l))[static_cast<std::size_t>(iy * wa.cells + ix)];
        const float b =
            before[static_cast<std::size_t>(l)][static_cast<std::size_t>(by * wb.cells + bx)];
        EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0) << "layer " << l << " at " << ix << "," << iy;
      }
    }
  return common;
}
}  // namespace

TEST(Stage3Roll, AnyWholeNumberOfCellsKeepsWhatStays)
{
  const int moves[][2] = {{1, 0}, {-1, 0}, {0, 3}, {5, -7}, {-80, 40}, {159, 159}, {-159, 0}};
  for (const auto& move : moves)
  {
    TestMap m;
    m.update(textured(0.02, 0.02));
    std::array<std::vector<float>, 4> before;
    for (int l = 0; l < 4; l++)
      before[static_cast<std::size_t>(l)] = m.map.layer(static_cast<Layer>(l));
    const Window window = m.map.window();
    m.update(Scan(0.02 + 0.05 * move[0], 0.02 + 0.05 * move[1]));
    // Nothing can be filled in a map that was full: cells that enter may be guessed, those that
    // stay may not change.
    const int common = expect_common_cells_equal(before, window, m.map);
    EXPECT_EQ(common, (160 - std::abs(move[0])) * (160 - std::abs(move[1])));
  }
}

TEST(Stage3Roll, WhatEntersIsEmptyEvenWhenItWasSeenLongAgo)
{
  TestMap m;
  m.update(textured(0, 0));
  m.update(Scan(20, 0));
  m.update(Scan(0, 0));
  for (float v : m.map.layer(Layer::State)) EXPECT_EQ(v, 0.0f);
  for (float v : m.map.layer(Layer::Elevation)) EXPECT_TRUE(std::isnan(v));
}

TEST(Stage3Roll, TheWindowFollowsFarFromTheOriginWithoutDrift)
{
  // 100 km out, in both directions, a point still falls into the cell that holds it.
  for (const double x : {1e5, -1e5})
  {
    TestMap m;
    m.update(Scan(x, -x).add(x + 1.026, -x + 1.026, 0.01));
    EXPECT_EQ(m.state(x + 1.026, -x + 1.026), CellState::Measured);
    EXPECT_LE(std::abs(m.map.window().min_x_m() + 4.0 - x), 0.05);
  }
}
