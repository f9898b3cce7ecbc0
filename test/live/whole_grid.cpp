#include "whole_grid.h"

#include <gtest/gtest.h>

#include <random>

#include <talus/formats/write.h>
#include <talus/layers.h>

using namespace talus;

TEST(WholeGrid, closes_the_islands_that_an_export_closes_in_any_part_of_it)
{
  constexpr double kResolution_m = 0.1, kClose_m = 0.5;
  site::TileStore none(1 << 20, testing::TempDir());
  Window window;
  window.min_cell_x = window.min_cell_y = 20;
  window.cells = 64;
  window.resolution_m = kResolution_m;
  std::mt19937 random(3);
  std::vector<std::int8_t> cells(64 * 64);
  for (auto& cell : cells)
  {
    const auto number = random() % 10;
    cell = static_cast<std::int8_t>(number < 4 ? 0 : number < 8 ? 100 : -1);
  }
  app::WholeGrid closed(kClose_m), open(0);
  for (auto* grid : {&closed, &open})
  {
    grid->update(none, 0, window, cells);
    EXPECT_FALSE(grid->take_changed().empty());
  }
  const auto area = closed.area();
  const auto before = open.cells(area, kResolution_m), after = closed.cells(area, kResolution_m);
  io::LayerStack map;
  map.cells_x = before.cells_x;
  map.cells_y = before.cells_y;
  map.resolution_m = kResolution_m;
  map.names = {layer_name(Layer::Traversability)};
  auto& scores = map.layers.emplace_back();
  for (const auto cell : before.cells) scores.push_back(cell < 0 ? NAN : cell == 0 ? 1.0F : 0.0F);
  EXPECT_NE(before.cells, after.cells);
  EXPECT_EQ(after.cells, formats::ros_cells(map, {0, kClose_m}));

  const auto part = closed.cells({30, 25, 60, 50}, kResolution_m);
  for (int y = 25; y < 50; ++y)
    for (int x = 30; x < 60; ++x)
      EXPECT_EQ(
          part.cells[(y - 25) * 30 + (x - 30)],
          after.cells[(y - area.min_y) * after.cells_x + (x - area.min_x)]);
}
