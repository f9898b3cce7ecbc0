#include "map_source.h"

#include <mrpt/math/TPose2D.h>
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

  std::vector<BlockedPlace> blocked_places(
      const mrpt::poses::CPose3D& T_map_base, double within_m) override
  {
    return blocked_places_of(map_, T_map_base, options_, within_m);
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

std::vector<BlockedPlace> MapSource::blocked_places(
    const mrpt::poses::CPose3D& T_map_base, double within_m)
{
  mrpt::maps::CSimplePointsMap points;
  obstacles(T_map_base, {}, points);
  std::vector<BlockedPlace> out;
  for (std::size_t i = 0; i < points.size(); i++)
  {
    const BlockedPlace p{points.getPointsBufferRef_x()[i], points.getPointsBufferRef_y()[i], false};
    if (std::hypot(p.x_m, p.y_m) < within_m) out.push_back(p);
  }
  return out;
}

std::vector<BlockedPlace> blocked_places_of(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& options,
    double within_m)
{
  std::vector<BlockedPlace> out;
  const auto cells = classify_cells(map, T_map_base, options);
  const auto edges = find_edges(map, T_map_base, cells);
  const Window w = map.window();
  const mrpt::math::TPose2D here(T_map_base.x(), T_map_base.y(), T_map_base.yaw());
  for (std::size_t i = 0; i < cells.size(); i++)
  {
    if (cells[i] != Passage::Obstacle) continue;
    const double x_m = w.min_x_m() + (static_cast<int>(i) % w.cells + 0.5) * w.resolution_m;
    const double y_m = w.min_y_m() + (static_cast<int>(i) / w.cells + 0.5) * w.resolution_m;
    const auto p = here.inverseComposePoint(mrpt::math::TPoint2D(x_m, y_m));
    if (p.norm() < within_m) out.push_back({p.x, p.y, edges[i]});
  }
  return out;
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
