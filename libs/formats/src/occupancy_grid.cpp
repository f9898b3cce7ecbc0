#include <talus/formats/convert.h>
#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/packed_log.h>

#include "close_islands.h"
#include "needed_layer.h"

#include <cmath>
#include <stdexcept>

namespace talus::formats
{
namespace
{
constexpr float kFree = 0.95F, kOccupied = 0.05F, kUnknown = 0.5F;  // probability of being free

void fill(
    const MapStrips& of, const Occupancy& o, const FileOrigin& at,
    mrpt::maps::COccupancyGridMap2D& out)
{
  const io::LayerStack& map = of.frame();
  const double min_x_m = map.min_x_m - at.x_m, min_y_m = map.min_y_m - at.y_m;
  const Kinds kinds = kinds_of(of, o);
  const auto border = [&](double m)
  {
    if (std::abs(static_cast<float>(m) - m) > map.resolution_m / 10)
      throw std::runtime_error(
          "MRPT's occupancy grid has borders of 32 bit, which are rounded so far away: take an "
          "origin near the map off (--origin)");
    return static_cast<float>(m);
  };
  out.setSize(
      border(min_x_m), border(min_x_m + map.cells_x * map.resolution_m), border(min_y_m),
      border(min_y_m + map.cells_y * map.resolution_m), static_cast<float>(map.resolution_m),
      kUnknown);
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        if (kinds[i] != Kind::Unknown)
          out.setCell(ix, iy, kinds[i] == Kind::Blocked ? kOccupied : kFree);
      });
}

}  // namespace

void to_occupancy_grid(
    const io::LayerStack& map, double blocked_at, mrpt::maps::COccupancyGridMap2D& out)
{
  fill(map, {blocked_at, 0}, {}, out);
}

void write_occupancy_grid(
    const std::string& path, const MapStrips& map, const Occupancy& o, const FileOrigin& origin)
{
  mrpt::maps::COccupancyGridMap2D grid;
  fill(map, o, origin, grid);
  io::AtomicFile file(path);
  io::PackedLog packed(file.temporary_path(), path);
  packed.write(grid);
  packed.close();
  file.commit();
}

}  // namespace talus::formats
