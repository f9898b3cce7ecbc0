#include <talus/formats/convert.h>
#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/packed_log.h>

#include "close_islands.h"
#include "needed_layer.h"

namespace talus::formats
{
namespace
{
constexpr float kFree = 0.95F, kOccupied = 0.05F, kUnknown = 0.5F;  // probability of being free

void fill(const io::LayerStack& map, const Occupancy& o, mrpt::maps::COccupancyGridMap2D& out)
{
  const std::vector<Kind> kinds = kinds_of(map, o);
  const auto border = [](double m) { return static_cast<float>(m); };
  out.setSize(
      border(map.min_x_m), border(map.min_x_m + map.cells_x * map.resolution_m),
      border(map.min_y_m), border(map.min_y_m + map.cells_y * map.resolution_m),
      border(map.resolution_m), kUnknown);
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
  fill(map, {blocked_at, 0}, out);
}

void write_occupancy_grid(const std::string& path, const io::LayerStack& map, const Occupancy& o)
{
  mrpt::maps::COccupancyGridMap2D grid;
  fill(map, o, grid);
  io::AtomicFile file(path);
  io::PackedLog packed(file.temporary_path(), path);
  packed.write(grid);
  packed.close();
  file.commit();
}

}  // namespace talus::formats
