#include <talus/point_filter.h>
#include "backend.h"
#include "kernels/1_accept.h"

#include <algorithm>

namespace talus
{
struct PointFilter::Impl
{
  MapConfig map;
  kernels::FrameContext frame;
};

PointFilter::PointFilter(
    const Parameters& p, const Pose& T_map_sensor, const std::optional<Pose>& T_base_sensor)
{
  const auto to_floats = [](const Pose& from, float* to)
  {
    std::transform(
        from.m.begin(), from.m.end(), to, [](double v) { return static_cast<float>(v); });
  };
  Impl made{make_config(p), {}};
  to_floats(T_map_sensor, made.frame.poses[0].m);
  to_floats(T_base_sensor.value_or(Pose{}), made.frame.T_base_sensor);
  impl_ = std::make_unique<const Impl>(made);
}
PointFilter::~PointFilter() = default;

bool PointFilter::accepts(float x_m, float y_m, float z_m) const
{
  const kernels::Point p{x_m, y_m, z_m};
  return kernels::accept(p, rise_m(x_m, y_m, z_m), impl_->map.config).code == kernels::kAccepted &&
         !kernels::is_body(p, impl_->frame, impl_->map.body);
}

float PointFilter::rise_m(float x_m, float y_m, float z_m) const
{
  return kernels::rise_above_sensor(impl_->frame.poses[0], {x_m, y_m, z_m});
}

}  // namespace talus
