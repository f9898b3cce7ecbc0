#include "map_source.h"

#include <talus/mrpt/pose_from.h>

#include <vector>

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
  }

  void block_unseen(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    talus::update_costmap(map_, T_map_base, options_, grid);
  }

  Ahead ahead(
      const mrpt::poses::CPose3D& T_map_base, double v_mps, double w_radps, double width_m) override
  {
    const auto ahead_m = [&](const ObstacleOptions& o)
    { return known_ahead_m(map_, T_map_base, v_mps, w_radps, width_m, o); };
    const double dared_m = ahead_m(options_);
    if (options_.drops == Drops::Avoid) return {dared_m, dared_m};
    ObstacleOptions careful = options_;
    careful.drops = Drops::Avoid;
    return {ahead_m(careful), dared_m};
  }

  const ElevationMapper* terrain() const override { return &map_; }

 private:
  ElevationMapper map_;
  ObstacleOptions options_;
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
