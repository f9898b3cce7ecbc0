#include "map_source.h"

#include <talus/baselines/method.h>

namespace talus::nav
{
namespace
{
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

std::unique_ptr<MapSource> make_onesurface_source(
    const Parameters& parameters, const ObstacleOptions& options)
{
  return std::make_unique<OneSurfaceSource>(parameters, options);
}

}  // namespace talus::nav
