#include "map_source.h"

#include <ground_cost.h>
#include <talus/baselines/method.h>

#include <vector>

namespace talus::nav
{
namespace
{
class TerrainSource : public MapSource
{
 public:
  TerrainSource(
      const Parameters& p, Backend backend, int threads, const ObstacleOptions& options,
      const RobotBody& body)
      : map_(p, backend, threads), options_(options), ground_(body.footprint())
  {
  }

  void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double stamp_s) override
  {
    map_.update(frame_of(scan, T_map_base, T_base_sensor, stamp_s));
    ground_.update(map_);
  }

  Around look(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      double within_m) override
  {
    return look_around(map_, T_map_base, options_, prism_heights_m, within_m);
  }

  double ground_cost(const Pose2& robot) const override { return ground_.cost(map_, robot); }

  void update_costmap(const mrpt::poses::CPose3D& T_map_base, Costmap& costmap) override
  {
    ObstacleOptions o = options_;
    o.unseen = Unseen::Free;
    nav::update_costmap(map_, pose_from(T_map_base), o, costmap);
  }

  void block_unseen(const mrpt::poses::CPose3D& T_map_base, Costmap& costmap) override
  {
    nav::update_costmap(map_, pose_from(T_map_base), options_, costmap);
  }

  Ahead ahead(
      const mrpt::poses::CPose3D& T_map_base, double v_mps, double w_radps, double width_m) override
  {
    const auto ahead_m = [&](const ObstacleOptions& o)
    { return known_ahead_m(map_, pose_from(T_map_base), v_mps, w_radps, width_m, o); };
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
  GroundCost ground_;
};

/** The map of a baseline as obstacles are made of it. */
MapSnapshot snapshot_of(const baselines::Surfaces& s, const Parameters& p)
{
  MapSnapshot out;
  out.window = s.window;
  out.parameters = p;
  const auto layer = [&](Layer l) -> std::vector<float>&
  { return out.layers[static_cast<std::size_t>(l)]; };
  layer(Layer::GroundElevation) = s.ground_m;
  layer(Layer::Elevation) = s.elevation_m;
  layer(Layer::Traversability) = s.traversability;
  layer(Layer::Variance).assign(s.size(), 0);
  layer(Layer::State).assign(s.state.begin(), s.state.end());
  return out;
}

class OneSurfaceSource : public MapSource
{
 public:
  OneSurfaceSource(const Parameters& p, const ObstacleOptions& options)
      : parameters_(p), options_(options), map_(baselines::make_method("highest", p))
  {
    options_.unseen = Unseen::Free;  // it knows nothing of the ground below a robot that starts
  }

  void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double stamp_s) override
  {
    map_->update(frame_of(scan, T_map_base, T_base_sensor, stamp_s));
    now_ = snapshot_of(map_->read(), parameters_);
  }

  Around look(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      double within_m) override
  {
    return look_around(now_, T_map_base, options_, prism_heights_m, within_m);
  }

  void update_costmap(const mrpt::poses::CPose3D& T_map_base, Costmap& costmap) override
  {
    nav::update_costmap(now_, pose_from(T_map_base), options_, costmap);
  }

 private:
  Parameters parameters_;
  ObstacleOptions options_;
  std::unique_ptr<baselines::Method> map_;
  MapSnapshot now_;
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

Around look_around(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& options,
    const std::vector<double>& prism_heights_m, double within_m)
{
  Around out;
  const Pose T = pose_from(T_map_base);
  const auto cells = classify_cells(map, T, options);
  const auto edges = find_edges(map, T, cells);
  const Window w = map.window();
  const Pose2 here = from_above(T);
  for (std::size_t i = 0; i < cells.size(); i++)
  {
    if (cells[i] != Passage::Obstacle) continue;
    const double x_m = w.min_x_m() + (static_cast<int>(i) % w.cells + 0.5) * w.resolution_m;
    const double y_m = w.min_y_m() + (static_cast<int>(i) / w.cells + 0.5) * w.resolution_m;
    const Point2 p = here.to_robot({x_m, y_m});
    if (std::hypot(p.x_m, p.y_m) < within_m) out.blocked.push_back({p.x_m, p.y_m, edges[i]});
  }
  for (const auto& p : find_obstacles(map, T, options, cells, prism_heights_m))
    out.obstacles.insertPointFast(p.x_m, p.y_m, p.z_m);
  return out;
}

std::unique_ptr<MapSource> make_terrain_source(
    const Parameters& parameters, Backend backend, int threads, const ObstacleOptions& options,
    const RobotBody& body)
{
  return std::make_unique<TerrainSource>(parameters, backend, threads, options, body);
}

std::unique_ptr<MapSource> make_onesurface_source(
    const Parameters& parameters, const ObstacleOptions& options)
{
  return std::make_unique<OneSurfaceSource>(parameters, options);
}

}  // namespace talus::nav
