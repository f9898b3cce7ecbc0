// A floor as one map that is kept up to date is the one that is made anew.
#include <gtest/gtest.h>
#include <talus/site/floor_map.h>

#include <cstring>

#include "log_files.h"
#include "sites.h"

using namespace talus;
using namespace talus::site;
using namespace talus::test;

namespace
{
constexpr int kMaxCells = 500;

class FloorMaps : public testing::Test
{
 protected:
  /** With the robot at a cell. */
  void expect_as_anew(std::int64_t x, std::int64_t y, int floor = 0)
  {
    const double x_m = static_cast<double>(x) * 0.05, y_m = static_cast<double>(y) * 0.05;
    const MapSnapshot& kept = map_.update(site_, floor, {}, kMaxCells, x_m, y_m);
    FloorMap fresh;
    const MapSnapshot& anew = fresh.update(site_, floor, {}, kMaxCells, x_m, y_m);
    ASSERT_EQ(kept.window.cells, anew.window.cells);
    ASSERT_EQ(kept.window.min_cell_x, anew.window.min_cell_x);
    ASSERT_EQ(kept.window.min_cell_y, anew.window.min_cell_y);
    for (std::size_t l = 0; l < kept.layers.size(); ++l)
    {
      const auto &a = kept.layers[l], &b = anew.layers[l];
      ASSERT_EQ(a.size(), b.size());
      EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0)
          << layer_name(static_cast<Layer>(l));
    }
    if (floor > 0) return;
    const Window& w = kept.window;
    const auto at = static_cast<std::size_t>((y - w.min_cell_y) * w.cells + (x - w.min_cell_x));
    EXPECT_EQ(kept.layer(Layer::GroundElevation)[at], cell_at(site_, x, y).cell.ground_m);
  }

  ScratchDir dir_;
  Site site_{0.05, std::size_t{4} << 20, dir_ / "tiles"};
  FloorMap map_;
};
}  // namespace

TEST_F(FloorMaps, are_as_made_anew_while_cells_change_and_the_floor_grows)
{
  EXPECT_EQ(map_.update(site_, 0, {}, kMaxCells, 0, 0).window.cells, 0);
  for (int i = 0; i < 40; ++i)
  {
    const std::int64_t x = 37 * i - 300, y = 11 * i - 90;  // wider than it shows at the end
    cell_at(site_, x, y) = measured(0.1F * static_cast<float>(i));
    cell_at(site_, x, y + 7) = with_obstacle(measured(1), 0.5F);
    expect_as_anew(x, y);
  }
  const std::int64_t before = map_.update(site_, 0, {}, kMaxCells, 28, 0).window.min_cell_x;
  EXPECT_EQ(map_.update(site_, 0, {}, kMaxCells, 30.9, 0).window.min_cell_x, before)
      << "stays for a while";
  cell_at(site_, -300, -90) = measured(9);
  expect_as_anew(-300, -90);
}

TEST_F(FloorMaps, show_what_changed_in_a_window_that_stays)
{
  for (int i = 0; i < 300; ++i) cell_at(site_, i, i) = measured(1);
  expect_as_anew(150, 150);
  cell_at(site_, 20, 30) = measured(5);
  cell_at(site_, 200, 210) = with_obstacle(measured(2), 0.3F);
  expect_as_anew(20, 30);
  cell_at(site_, 299, 299) = SiteCell{};  // the window shrinks
  expect_as_anew(150, 150);
}

TEST_F(FloorMaps, show_one_floor_and_then_the_other)
{
  cell_at(site_, 5, 5, 0) = measured(1);
  cell_at(site_, 5, 5, 1) = measured(4);
  expect_as_anew(5, 5);
  expect_as_anew(5, 5, 1);
  cell_at(site_, 5, 5, 0) = measured(2);
  expect_as_anew(5, 5, 1);
  expect_as_anew(5, 5);
}
