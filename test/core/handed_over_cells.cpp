#include <gtest/gtest.h>
#include "scene.h"

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <stdexcept>

using namespace talus;
using namespace talus::test;

namespace
{
Scan bumps(double x, double y)
{
  return textured(x, y).add_surface(x + 1, y + 1, x + 1.5, y + 2, level(0.5));
}

CellRect all_of(const Window& w) { return {w.min_cell_x, w.min_cell_y, w.cells, w.cells}; }

bool same(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(const CellRecord& a, const CellRecord& b)
{
  constexpr std::size_t kBytes = offsetof(CellRecord, evidence) + CellRecord::kEvidenceBytes;
  return std::memcmp(&a, &b, kBytes) == 0;  // without what pads it
}

void expect_same(const CellRecords& a, const std::vector<CellRecord>& b)
{
  ASSERT_EQ(a.size, b.size());
  for (std::size_t i = 0; i < a.size; i++) EXPECT_TRUE(same(a[i], b[i])) << "cell " << i;
}
std::vector<CellRecord> read(const TestMap& m, const std::vector<CellRect>& rects)
{
  const CellRecords records = m.map.read_cells(rects);
  return {records.begin(), records.end()};
}
void write(TestMap& m, const std::vector<CellRect>& rects, const std::vector<CellRecord>& records)
{
  m.map.write_cells(rects, records.data(), records.size());
}
}  // namespace

TEST(HandedOverCells, AreWhatTheLayersShow)
{
  TestMap m(bumps(0.3, -0.2));
  const Window w = m.map.window();
  const CellRect right{w.min_cell_x + 150, w.min_cell_y, 10, 160};
  const CellRect top{w.min_cell_x, w.min_cell_y + 157, 150, 3};
  const std::vector<CellRecord> records = read(m, {right, top});
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
        EXPECT_TRUE(same(records[i].traversability, m.map.layer(Layer::Traversability)[at]));
        EXPECT_EQ(static_cast<float>(records[i].state), m.map.layer(Layer::State)[at]);
      }
}

TEST(HandedOverCells, PutBackMakeTheMapThatItWas)
{
  TestMap m(bumps(0, 0));
  const Window w = m.map.window();
  const std::vector<CellRecord> before = read(m, {all_of(w)});
  m.update(Scan(20, 0));
  m.update(Scan(0, 0));
  write(m, {all_of(w)}, before);
  const std::vector<CellRecord> after = read(m, {all_of(w)});
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); i++)
    EXPECT_TRUE(before[i].state == 0 || same(before[i], after[i])) << "cell " << i;
  write(m, {all_of(w)}, std::vector<CellRecord>(before.size()));
  expect_same(m.map.read_cells({all_of(w)}), after);  // what is unknown changes nothing
}

namespace
{
const std::vector<Layer> kAllLayers = {
    Layer::Elevation, Layer::GroundElevation, Layer::Variance, Layer::State,         Layer::Slope,
    Layer::Step,      Layer::Roughness,       Layer::Sparsity, Layer::Traversability};
/** More rectangles than go at once, some of them empty. */
std::vector<CellRect> stripes(const Window& w)
{
  std::vector<CellRect> rects;
  for (int i = 0; i < 11; i++)
    rects.push_back({w.min_cell_x + 3 * i, w.min_cell_y + 5 + i, i % 3, w.cells - 20});
  return rects;
}
}  // namespace

/** Of a small window kernels write layers where they are wanted, of a large one they are copied. */
TEST(HandedOverCells, AreInDeliveredLayersAsTheyAreReadBack)
{
  for (const double window_m : {8.0, 20.0})
  {
    TestMap delivers(with({{"window_m", window_m}})), is_asked(delivers.map.parameters());
    delivers.map.set_output_layers(kAllLayers);
    std::vector<float> shown_before;
    for (TestMap* m : {&delivers, &is_asked})
    {
      m->update(bumps(0, 0));
      std::vector<CellRecord> records = read(*m, stripes(m->map.window()));
      for (std::size_t i = 0; i < records.size(); i++)
      {
        records[i].state = static_cast<std::uint8_t>(i % kCellStates);
        records[i].ground_m = 0.001f * static_cast<float>(i) + 0.123f;
        records[i].ground_variance_m2 = 0.01f;
        if (i % 5 == 0) records[i].elevation_m = records[i].elevation_variance_m2 = NAN;
        records[i].traversability = i % 7 == 0 ? NAN : 0.25f;
      }
      shown_before = m->map.layer(Layer::GroundElevation);
      write(*m, stripes(m->map.window()), records);
    }
    EXPECT_NE(delivers.map.layer(Layer::GroundElevation), shown_before);
    expect_same_bits(delivers.map, is_asked.map, 1);
    EXPECT_EQ(delivers.map.save(), is_asked.map.save());
  }
}

TEST(HandedOverCells, KeepTheirTraversabilityWhenItsPartsAreAskedFor)
{
  TestMap m(bumps(0, 0));
  const std::vector<CellRect> one = {{m.map.window().min_cell_x, m.map.window().min_cell_y, 1, 1}};
  CellRecord r;
  r.ground_m = 0.25f, r.ground_variance_m2 = 0.01f, r.traversability = 0.5f, r.state = 1;
  write(m, one, {r});
  m.map.layer(Layer::Slope);
  EXPECT_EQ(m.map.layer(Layer::Traversability)[0], 0.5f);
  EXPECT_EQ(read(m, one)[0].traversability, 0.5f);
}

TEST(HandedOverCells, ComeWithAFrameAsTheyAreBeforeAndAfterIt)
{
  TestMap apart, together;
  FrameCells cells;
  for (int i = 0; i < 12; i++)
  {
    const Scan scan = bumps(0.11 * i, -0.07 * i);
    cells.before = i == 0 ? std::vector<CellRect>{} : stripes(apart.map.window());
    const Window next = apart.map.window_after(scan.frame());
    const std::vector<CellRecord> before = read(apart, cells.before);
    apart.map.update(scan.frame());
    EXPECT_EQ(next.min_cell_x, apart.map.window().min_cell_x);
    EXPECT_EQ(next.min_cell_y, apart.map.window().min_cell_y);
    EXPECT_EQ(next.cells, apart.map.window().cells);
    cells.after = i % 4 == 1 ? std::vector<CellRect>{} : stripes(apart.map.window());
    together.map.update(scan.frame(), cells, [&] { expect_same(cells.records_before, before); });
    expect_same(cells.records_after, read(apart, cells.after));
    if (i != 6) continue;
    for (TestMap* m : {&apart, &together})  // so that the next frame has another place in memory
    {
      m->map.start(scan.frame());
      m->map.start(scan.frame());
      m->map.finish();
      m->map.finish();
    }
  }
  EXPECT_EQ(apart.map.save(), together.map.save());
}

TEST(HandedOverCells, ThatCannotBeKeptEndTheFrameFirst)
{
  TestMap m, same;
  m.update(bumps(0, 0));
  same.update(bumps(0, 0));
  FrameCells cells;
  cells.before = {all_of(m.map.window())};
  const auto refuse = [&]
  {
    EXPECT_THROW(m.map.read_cells(cells.before), std::logic_error);  // the frame is in flight
    throw std::runtime_error("no room");
  };
  EXPECT_THROW(m.map.update(bumps(0.3, 0).frame(), cells, refuse), std::runtime_error);
  same.update(bumps(0.3, 0));
  EXPECT_EQ(m.map.frames_in_flight(), 0);
  EXPECT_EQ(m.map.save(), same.map.save());
}

TEST(HandedOverCells, ThatAreNotInTheWindowAreRefused)
{
  TestMap m;
  EXPECT_THROW(m.map.read_cells({{0, 0, 1, 1}}), std::invalid_argument);  // no window yet
  m.update(bumps(0, 0));
  const Window w = m.map.window();
  const CellRect outside[] = {
      {w.min_cell_x - 1, w.min_cell_y, 2, 2},
      {w.min_cell_x, w.min_cell_y + 159, 1, 2},
      {w.min_cell_x, w.min_cell_y, -1, 1},
      {w.min_cell_x, w.min_cell_y, 1 << 30, 1 << 30}};
  for (const CellRect& r : outside)
  {
    FrameCells cells;
    EXPECT_THROW(m.map.read_cells({r}), std::invalid_argument);
    cells.before = {r};
    EXPECT_THROW(m.map.update(bumps(0, 0).frame(), cells), std::invalid_argument);
    cells.before.swap(cells.after);
    EXPECT_THROW(m.map.update(bumps(0, 0).frame(), cells), std::invalid_argument);
  }
  EXPECT_EQ(m.map.read_cells({{w.min_cell_x, w.min_cell_y, 0, 160}}).size, 0u);
  EXPECT_THROW(write(m, {all_of(w)}, {CellRecord()}), std::invalid_argument);
}

TEST(HandedOverCells, OfAnotherFloorAreToldBeforeTheyGo)
{
  TestMap m;
  for (int i = 0; i < 3; i++) EXPECT_FALSE(m.update(bumps(0, 0)).leaves_floor);
  Scan higher = Scan(0, 0, 3.9).add_surface(-4, -4, 4, 4, [](double, double) { return 3.2; });
  EXPECT_TRUE(m.update(higher).leaves_floor);
  EXPECT_NEAR(read(m, {all_of(m.map.window())})[80 * 160 + 40].ground_m, 0, 0.1);
  EXPECT_FALSE(m.update(higher).leaves_floor);
  EXPECT_NEAR(read(m, {all_of(m.map.window())})[80 * 160 + 40].ground_m, 3.2, 0.1);
}

TEST(Contact, MovesAMeasuredCellByItsVariance)
{
  TestMap m(Scan().add_surface(-3, -3, 3, 3, flat), {}, 3);
  const float v = m.fused_variance(1.02, 0.02);
  m.map.contact(1.02, 0.02, 0.01, std::sqrt(v));
  EXPECT_NEAR(m.ground(1.02, 0.02), 0.005, 1e-4);
  EXPECT_NEAR(m.elevation(1.02, 0.02), 0.005, 1e-4);
  EXPECT_NEAR(m.fused_variance(1.02, 0.02), v / 2, v / 50);
  EXPECT_NEAR(m.ground(1.07, 0.02), 0, 1e-6);
}

TEST(Contact, MeasuresACellThatWasNotMeasured)
{
  TestMap m(Scan().add_surface(-3, -3, 0, 3, flat), {}, 3);
  ASSERT_NE(m.state(1.02, 0.02), CellState::Measured);
  m.map.contact(1.02, 0.02, 0.03, 0.01);
  for (int frame = 0; frame < 3; frame++)
  {
    EXPECT_EQ(m.state(1.02, 0.02), CellState::Measured);
    EXPECT_NEAR(m.ground(1.02, 0.02), 0.03, 1e-6);
    EXPECT_NEAR(m.fused_variance(1.02, 0.02), 1e-4, 1e-6);
    m.update(Scan().add_surface(-3, -3, 0, 3, flat));
  }
}

TEST(Contact, BeyondTheGateIsGroundBelowAndTopAbove)
{
  TestMap m(Scan().add_surface(-3, -3, 3, 3, flat), {}, 3);
  m.map.contact(1.02, 0.02, 0.2, 0.005);
  m.map.contact(1.52, 0.02, -0.2, 0.005);
  EXPECT_NEAR(m.ground(1.02, 0.02), 0, 1e-6);
  EXPECT_NEAR(m.elevation(1.02, 0.02), 0.2, 1e-6);
  EXPECT_NEAR(m.ground(1.52, 0.02), -0.2, 1e-6);
  EXPECT_NEAR(m.elevation(1.52, 0.02), 0, 1e-6);
}

TEST(Contact, RefusesWhatIsNoMeasurementAndChangesNothing)
{
  TestMap m;
  EXPECT_TRUE(has(message_of([&] { m.map.contact(0, 0, 0, 0.01); }), "window"));
  m.update(Scan().add_surface(-3, -3, 3, 3, flat));
  const auto before = m.map.save();
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  for (const double sigma : {0.0, -0.01, kNothing, std::numeric_limits<double>::infinity()})
    EXPECT_TRUE(has(message_of([&] { m.map.contact(0, 0, 0, sigma); }), "sigma"));
  for (const double z : {kNothing, 2e5})
    EXPECT_TRUE(has(message_of([&] { m.map.contact(0, 0, z, 0.01); }), "z is"));
  for (const double x : {4.001, -4.001, kNothing})
    EXPECT_TRUE(has(message_of([&] { m.map.contact(x, 0, 0, 0.01); }), "window"));
  EXPECT_EQ(m.map.save(), before);
}
