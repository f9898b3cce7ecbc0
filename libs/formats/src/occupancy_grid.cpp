#include <talus/formats/convert.h>
#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/packed_log.h>
#include <talus/number_text.h>

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
  const auto border = [&](double m, int cells)
  { return static_cast<float>(m + cells * map.resolution_m); };
  out.setSize(
      border(min_x_m, 0), border(min_x_m, map.cells_x), border(min_y_m, 0),
      border(min_y_m, map.cells_y), static_cast<float>(map.resolution_m), kUnknown);
  if (std::hypot(out.getXMin() - min_x_m, out.getYMin() - min_y_m) > map.resolution_m / 10)
    throw std::runtime_error(
        "MRPT's occupancy grid has borders of 32 bit at whole multiples of its cells, which would "
        "move this map: take an origin off (--origin) that is whole cells from its corner, " +
        exact_number_text(map.min_x_m) + "," + exact_number_text(map.min_y_m) + ", and near it");
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
