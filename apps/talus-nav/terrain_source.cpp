#include "map_source.h"

#include <talus/mrpt/pose_from.h>

#include <set>
#include <utility>

namespace talus::nav
{
namespace
{
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
    Frame frame;
    frame.stamp_s = stamp_s;
    frame.T_map_sensor = pose_from(T_map_base + T_base_sensor);
    frame.T_base_sensor = pose_from(T_base_sensor);
    frame.x_m = scan.x_m.data();
    frame.y_m = scan.y_m.data();
    frame.z_m = scan.z_m.data();
    frame.size = scan.size();
    map_.update(frame);
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
    look_at_doubtful(T_map_base, grid);
  }

  void block_unseen(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    talus::update_costmap(map_, T_map_base, options_, grid);
  }

  void admit_doubtful(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    const auto strict = grid;
    talus::admit_doubtful(map_, T_map_base, options_, grid);
    for (const auto& [x, y] : looked_at_) grid.setCell(x, y, strict.getCell(x, y));
  }

  double known_ahead_m(
      const mrpt::poses::CPose3D& T_map_base, double v_mps, double w_radps, double width_m) override
  {
    return talus::known_ahead_m(map_, T_map_base, v_mps, w_radps, width_m, options_);
  }

  const ElevationMapper* terrain() const override { return &map_; }

 private:
  /** Remembers what stays in doubt from nearby, so that the robot does not come back for it. */
  void look_at_doubtful(
      const mrpt::poses::CPose3D& T_map_base, const mrpt::maps::COccupancyGridMap2D& grid)
  {
    const auto doubtful = find_doubtful(map_, options_);
    const Window w = map_.window();
    for (std::size_t i = 0; i < doubtful.size(); i++)
    {
      const auto n = static_cast<std::size_t>(w.cells);
      const double x_m = w.min_x_m() + (static_cast<double>(i % n) + 0.5) * w.resolution_m;
      const double y_m = w.min_y_m() + (static_cast<double>(i / n) + 0.5) * w.resolution_m;
      if (doubtful[i] &&
          std::hypot(x_m - T_map_base.x(), y_m - T_map_base.y()) <= options_.seen_within_m)
        looked_at_.emplace(grid.x2idx(x_m), grid.y2idx(y_m));
    }
  }

  ElevationMapper map_;
  ObstacleOptions options_;
  std::set<std::pair<int, int>> looked_at_;  //!< column and row in the costmap
};
}  // namespace

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
