#include "map_source.h"

#include <talus/mrpt/pose_from.h>

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
    if (prism_heights_m.empty())
      obstacles_2d(map_, T_map_base, options_, out);
    else
      obstacles_3d(map_, T_map_base, options_, prism_heights_m, out);
  }

  void update_costmap(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) override
  {
    ObstacleOptions o = options_;
    o.unknown = CellPolicy::Free;  // where nothing is known a way may be hoped for
    talus::update_costmap(map_, T_map_base, o, grid);
  }

  const ElevationMapper* terrain() const override { return &map_; }

 private:
  ElevationMapper map_;
  ObstacleOptions options_;
};
}  // namespace

std::unique_ptr<MapSource> make_terrain_source(
    const Parameters& parameters, Backend backend, int threads, const ObstacleOptions& options)
{
  return std::make_unique<TerrainSource>(parameters, backend, threads, options);
}

}  // namespace talus::nav
