#include <gtest/gtest.h>
#include <talus/interleaved_points.h>
#include <talus/map_view.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "scene.h"

// How programs read the map at a place, and hand it points as other libraries keep them.

using namespace talus;
using namespace talus::test;

namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/** x, y, z of each point, then `gap_bytes` of something else. */
std::vector<unsigned char> interleaved(const Frame& f, std::size_t gap_bytes)
{
  const std::size_t stride = 3 * sizeof(float) + gap_bytes;
  std::vector<unsigned char> bytes(f.size * stride, 0xAB);
  for (std::size_t k = 0; k < f.size; k++)
  {
    const float p[3] = {f.x_m[k], f.y_m[k], f.z_m[k]};
    std::memcpy(&bytes[k * stride], p, sizeof(p));
  }
  return bytes;
}
}  // namespace

TEST(WindowOfCells, FindsTheCellOfAPlaceOnBothSidesOfZeroAndNoneOutside)
{
  const Window w{4, 0.5, -2, -1};  // x from -1 to 1, y from -0.5 to 1.5
  EXPECT_EQ(w.index_at(-1.0, -0.5), 0u);
  EXPECT_EQ(w.index_at(-0.01, -0.01), 1u);
  EXPECT_EQ(w.index_at(0.0, 0.0), 6u);
  EXPECT_EQ(w.index_at(0.99, 1.49), 15u);
  for (const double x : {-1.01, 1.0, 1e300, -kInfinity, kInfinity, std::nan("")})
    EXPECT_FALSE(w.index_at(x, 0)) << x;
  for (const double y : {-0.51, 1.5, -1e300, std::nan("")}) EXPECT_FALSE(w.index_at(0, y)) << y;
  EXPECT_FALSE(Window().index_at(0, 0));
}

TEST(MapView, ReadsAMapAtAPlace)
{
  const Scan scan = box_ahead();
  ElevationMapper map({}, Backend::Cpu, 1);
  const MapView view = map;
  EXPECT_TRUE(std::isnan(view.at(Layer::Traversability, 0.1, 0.1)));  // no frame yet
  map.update(scan.frame());
  EXPECT_NEAR(view.at(Layer::GroundElevation, 1.22, -0.13), 0, 0.02);
  EXPECT_NEAR(view.at(Layer::Elevation, 1.52, -0.13), 0.4, 0.1);
  EXPECT_EQ(view.at(Layer::Traversability, 1.52, -0.13), 0);
  EXPECT_TRUE(std::isnan(view.at(Layer::Elevation, 4.3, 0)));  // outside of the window
}

TEST(MapView, ReadsASnapshotAsItReadsTheMap)
{
  const Scan scan = box_ahead();
  ElevationMapper map({}, Backend::Cpu, 1);
  map.update(scan.frame());
  LiveMap live({}, {Layer::Elevation}, Backend::Cpu, 1);
  live.ingest(scan.frame());
  const auto now = live.snapshot();
  ASSERT_TRUE(now);
  const float height_m = MapView(*now).at(Layer::Elevation, 1.52, -0.13);
  EXPECT_EQ(height_m, MapView(map).at(Layer::Elevation, 1.52, -0.13));
  EXPECT_THROW(MapView(*now).at(Layer::Slope, 1.5, 0), std::invalid_argument);
}

TEST(InterleavedPoints, GiveTheMapOfPointsInArraysOfTheirOwn)
{
  const Scan scan = box_ahead();
  ElevationMapper map({}, Backend::Cpu, 1);
  map.update(scan.frame());
  for (const std::size_t gap_bytes : {0u, 1u, 4u, 20u})  // 1: as in packed messages
  {
    const auto bytes = interleaved(scan.frame(), gap_bytes);
    InterleavedPoints points;
    Frame frame = points.frame(bytes.data(), scan.frame().size, 3 * sizeof(float) + gap_bytes);
    frame.T_map_sensor = scan.frame().T_map_sensor;
    ElevationMapper same({}, Backend::Cpu, 1);
    same.update(frame);
    EXPECT_EQ(same.save(), map.save()) << gap_bytes;
  }
}

TEST(InterleavedPoints, RefuseWhatCannotBe)
{
  const float p[6] = {1, 0, 0, 2, 0, 0};
  InterleavedPoints points;
  EXPECT_THROW(points.frame(p, 2, 8), std::invalid_argument);
  EXPECT_THROW(points.frame(nullptr, 1), std::invalid_argument);
  EXPECT_EQ(points.frame(nullptr, 0).size, 0u);
}
