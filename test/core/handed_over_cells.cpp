#include <gtest/gtest.h>
#include "scene.h"

#include <cstring>
#include <stdexcept>

using namespace talus;
using namespace talus::test;

namespace
{
Scan bumps(double x, double y)
{
  Scan s(x, y, 0.7);
  s.add_surface(
      x - 4, y - 4, x + 4, y + 4,
      [](double u, double v) { return 0.05 * std::sin(3 * u) * std::cos(2 * v); });
  s.add_surface(x + 1, y + 1, x + 1.5, y + 2, [](double, double) { return 0.5; });
  return s;
}

CellRect all_of(const Window& w) { return {w.min_cell_x, w.min_cell_y, w.cells, w.cells}; }

bool same(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(const CellRecord& a, const CellRecord& b)
{
  return same(a.ground_m, b.ground_m) && same(a.ground_variance_m2, b.ground_variance_m2) &&
         same(a.elevation_m, b.elevation_m) &&
         same(a.elevation_variance_m2, b.elevation_variance_m2) &&
         same(a.traversability, b.traversability) && a.state == b.state &&
         a.persistence == b.persistence && a.ray_evidence == b.ray_evidence &&
         a.extent == b.extent && a.footing == b.footing;
}
}  // namespace

TEST(HandedOverCells, AreWhatTheLayersShow)
{
  TestMap m;
  m.update(bumps(0.3, -0.2));
  const Window w = m.map.window();
  const CellRect right{w.min_cell_x + 150, w.min_cell_y, 10, 160};
  const CellRect top{w.min_cell_x, w.min_cell_y + 157, 150, 3};
  std::vector<CellRecord> records;
  m.map.read_cells({right, top}, records);
  ASSERT_EQ(records.size(), right.size() + top.size());
  std::size_t i = 0;
  for (const CellRect& r : {right, top})
    for (int y = 0; y < r.height_cells; y++)
      for (int x = 0; x < r.width_cells; x++, i++)
      {
        const auto at = static_cast<std::size_t>(
            (r.min_cell_y - w.min_cell_y + y) * w.cells + r.min_cell_x - w.min_cell_x + x);
        EXPECT_TRUE(same(records[i].ground_m, m.map.layer(Layer::GroundElevation)[at]));
        EXPECT_TRUE(same(records[i].elevation_m, m.map.layer(Layer::Elevation)[at]));
        EXPECT_TRUE(same(records[i].ground_variance_m2, m.map.layer(Layer::Variance)[at]));
        EXPECT_TRUE(same(records[i].traversability, m.map.layer(Layer::Traversability)[at]));
        EXPECT_EQ(static_cast<float>(records[i].state), m.map.layer(Layer::State)[at]);
      }
}

TEST(HandedOverCells, PutBackMakeTheMapThatItWas)
{
  TestMap m;
  m.update(bumps(0, 0));
  std::vector<CellRecord> before, after;
  const Window w = m.map.window();
  m.map.read_cells({all_of(w)}, before);
  m.update(Scan(20, 0));
  m.update(Scan(0, 0));
  m.map.write_cells({all_of(w)}, before);
  m.map.read_cells({all_of(w)}, after);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); i++)
    EXPECT_TRUE(before[i].state == 0 || same(before[i], after[i])) << "cell " << i;
}

TEST(HandedOverCells, ThatAreUnknownChangeNothing)
{
  TestMap m;
  m.update(bumps(0, 0));
  std::vector<CellRecord> before, after;
  m.map.read_cells({all_of(m.map.window())}, before);
  m.map.write_cells({all_of(m.map.window())}, std::vector<CellRecord>(before.size()));
  m.map.read_cells({all_of(m.map.window())}, after);
  for (std::size_t i = 0; i < before.size(); i++) EXPECT_TRUE(same(before[i], after[i]));
}

TEST(HandedOverCells, AreShownByOutputLayersAtOnce)
{
  TestMap m;
  m.map.set_output_layers({Layer::GroundElevation, Layer::Traversability, Layer::State});
  m.update(Scan(0, 0).add(1, 1, 0));
  CellRecord r;
  r.ground_m = 0.25f, r.ground_variance_m2 = 0.01f, r.traversability = 0.5f, r.state = 1;
  const Window w = m.map.window();
  m.map.write_cells({{w.min_cell_x + 3, w.min_cell_y + 2, 1, 1}}, {r});
  const auto at = static_cast<std::size_t>(2 * w.cells + 3);
  EXPECT_EQ(m.map.layer(Layer::GroundElevation)[at], 0.25f);
  EXPECT_EQ(m.map.layer(Layer::Traversability)[at], 0.5f);
  EXPECT_EQ(m.map.layer(Layer::State)[at], 1.0f);
}

TEST(HandedOverCells, ThatAreNotInTheWindowAreRefused)
{
  TestMap m;
  std::vector<CellRecord> records;
  EXPECT_THROW(m.map.read_cells({{0, 0, 1, 1}}, records), std::invalid_argument);  // no window yet
  m.update(bumps(0, 0));
  const Window w = m.map.window();
  const CellRect outside[] = {
      {w.min_cell_x - 1, w.min_cell_y, 2, 2},
      {w.min_cell_x, w.min_cell_y + 159, 1, 2},
      {w.min_cell_x, w.min_cell_y, -1, 1},
      {w.min_cell_x, w.min_cell_y, 1 << 30, 1 << 30}};
  for (const CellRect& r : outside)
    EXPECT_THROW(m.map.read_cells({r}, records), std::invalid_argument);
  m.map.read_cells({{w.min_cell_x, w.min_cell_y, 0, 160}}, records);
  EXPECT_TRUE(records.empty());
  EXPECT_THROW(m.map.write_cells({all_of(w)}, {CellRecord()}), std::invalid_argument);
}

TEST(HandedOverCells, AreTheSameForTheWindowThatTheNextFrameWillHave)
{
  TestMap m;
  for (const double x : {0.0, 0.42, 17.0, -3.3})
  {
    Scan scan = bumps(x, -x);
    const Window told = m.map.window_after(scan.frame());
    m.update(scan);
    EXPECT_EQ(told.min_cell_x, m.map.window().min_cell_x);
    EXPECT_EQ(told.min_cell_y, m.map.window().min_cell_y);
    EXPECT_EQ(told.cells, m.map.window().cells);
  }
}

TEST(HandedOverCells, OfAnotherFloorAreToldBeforeTheyGo)
{
  TestMap m;
  for (int i = 0; i < 3; i++) EXPECT_FALSE(m.update(bumps(0, 0)).leaves_floor);
  Scan higher(0, 0, 3.9);
  higher.add_surface(-4, -4, 4, 4, [](double, double) { return 3.2; });
  EXPECT_TRUE(m.update(higher).leaves_floor);
  std::vector<CellRecord> old;
  m.map.read_cells({all_of(m.map.window())}, old);
  EXPECT_NEAR(old[80 * 160 + 40].ground_m, 0, 0.1);
  EXPECT_FALSE(m.update(higher).leaves_floor);
  m.map.read_cells({all_of(m.map.window())}, old);
  EXPECT_NEAR(old[80 * 160 + 40].ground_m, 3.2, 0.1);
}
