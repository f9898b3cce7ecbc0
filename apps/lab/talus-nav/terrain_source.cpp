#include "map_source.h"

#include <talus/mrpt/pose_from.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace talus::nav
{
namespace
{
/** From where a cell was in doubt: blocked only by comparison with filled ground. */
enum class Doubt : std::uint8_t
{
  FromAfar,
  FromNearby
};
/** Column and row of a cell of the map frame. */
using Cell = std::pair<int, int>;
constexpr float kAdmitted = 0.55F;  // as costmap_from_map() makes what is hardly traversable

class TerrainSource : public MapSource
{
 public:
  TerrainSource(const Parameters& p, Backend backend, int threads, const ObstacleOptions& options)
      : map_(p, backend, threads), options_(options)
  {
  }

  void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double stamp_s) override
  {
    map_.update(frame_of(scan, T_map_base, T_base_sensor, stamp_s));
  }

  void obstacles(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      mrpt::maps::CSimplePointsMap& out) override
  {
    make_obstacles(map_, T_map_base, options_, prism_heights_m, out);
  }

  void update_costmap(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    ObstacleOptions o = options_;
    o.unseen = Unseen::Free;
    talus::update_costmap(map_, T_map_base, o, grid);
    note_doubts(T_map_base);
  }

  void block_unseen(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    talus::update_costmap(map_, T_map_base, options_, grid);
  }

  void admit_doubtful(mrpt::maps::COccupancyGridMap2D& grid) override
  {
    const double side_m = map_.window().resolution_m;
    for (const auto& [cell, doubt] : doubts_)
      if (doubt == Doubt::FromAfar)
        grid.setCell(
            grid.x2idx((cell.first + 0.5) * side_m), grid.y2idx((cell.second + 0.5) * side_m),
            kAdmitted);
  }

  Ahead ahead(
      const mrpt::poses::CPose3D& T_map_base, double v_mps, double w_radps, double width_m) override
  {
    ObstacleOptions careful = options_;
    careful.drops = Drops::Avoid;
    const auto ahead_m = [&](const ObstacleOptions& o)
    { return known_ahead_m(map_, T_map_base, v_mps, w_radps, width_m, o); };
    return {ahead_m(careful), ahead_m(options_)};
  }

  const ElevationMapper* terrain() const override { return &map_; }

 private:
  /** Remembers what is in doubt, also where the window has left; and for good what stays so from
   * nearby, so that the robot does not come back for it. */
  void note_doubts(const mrpt::poses::CPose3D& T_map_base)
  {
    const auto doubtful = find_doubtful(map_, options_);
    const Window w = map_.window();
    const auto n = static_cast<std::size_t>(w.cells);
    for (std::size_t i = 0; i < doubtful.size(); i++)
    {
      const double x_m = w.min_x_m() + (static_cast<double>(i % n) + 0.5) * w.resolution_m;
      const double y_m = w.min_y_m() + (static_cast<double>(i / n) + 0.5) * w.resolution_m;
      const Cell cell{
          static_cast<int>(std::floor(x_m / w.resolution_m)),
          static_cast<int>(std::floor(y_m / w.resolution_m))};
      const auto known = doubts_.find(cell);
      if (known != doubts_.end() && known->second == Doubt::FromNearby) continue;
      const double distance_m = std::hypot(x_m - T_map_base.x(), y_m - T_map_base.y());
      if (doubtful[i])
        doubts_[cell] = distance_m > options_.seen_within_m ? Doubt::FromAfar : Doubt::FromNearby;
      else if (known != doubts_.end())
        doubts_.erase(known);
    }
  }

  ElevationMapper map_;
  ObstacleOptions options_;
  std::map<Cell, Doubt> doubts_;
};
}  // namespace

Frame frame_of(
    const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
    const mrpt::poses::CPose3D& T_base_sensor, double stamp_s)
{
  Frame frame;
  frame.stamp_s = stamp_s;
  frame.T_map_sensor = pose_from(T_map_base + T_base_sensor);
  frame.T_base_sensor = pose_from(T_base_sensor);
  frame.x_m = scan.x_m.data();
  frame.y_m = scan.y_m.data();
  frame.z_m = scan.z_m.data();
  frame.size = scan.size();
  return frame;
}

void make_obstacles(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& options,
    const std::vector<double>& prism_heights_m, mrpt::maps::CSimplePointsMap& out)
{
  if (prism_heights_m.empty())
    obstacles_2d(map, T_map_base, options, out);
  else
    obstacles_3d(map, T_map_base, options, prism_heights_m, out);
}

std::unique_ptr<MapSource> make_terrain_source(
    const Parameters& parameters, Backend backend, int threads, const ObstacleOptions& options)
{
  return std::make_unique<TerrainSource>(parameters, backend, threads, options);
}

}  // namespace talus::nav
