#include <talus/baselines/highest_point_map.h>

#include <cmath>
#include <limits>

namespace talus::baselines
{
namespace
{
constexpr float kGate_deviations = 2.5f;  //!< Mahalanobis distance, as elevation_mapping's default
constexpr double kCleanupPeriod_s = 1.0;
}  // namespace

void HighestPointMap::fuse(Cell& c, const MapPoint& p, double stamp_s) const
{
  const float difference = p.z_m - c.height_m, most = kGate_deviations * std::sqrt(c.variance_m2);
  if (!c.known() || difference > most)
    c = {p.z_m, point_variance_m2(p), stamp_s};
  else if (difference >= -most)
    kalman(c, p, stamp_s);
}

std::vector<MapPoint> HighestPointMap::insert(const Frame& frame)
{
  roll_to(frame);
  std::vector<MapPoint> points = accepted_points(frame, parameters());
  for (const MapPoint& p : points)
    if (Cell* c = cells().find(p.x_m, p.y_m)) fuse(*c, p, frame.stamp_s);
  return points;
}

void HighestPointMap::update(const Frame& frame)
{
  const auto points = insert(frame);
  if (frame.stamp_s - last_cleanup_s_ < kCleanupPeriod_s) return;
  clean_up(frame, points);
  last_cleanup_s_ = frame.stamp_s;
}

Surfaces HighestPointMap::read()
{
  Surfaces s = surfaces();
  judge_one_surface(s, parameters());
  return s;
}

void CuCppMap::update(const Frame& frame) { clean_up(frame, insert(frame)); }

Surfaces CuCppMap::read()
{
  Surfaces s = surfaces();
  Parameters p = parameters();
  p.weight_slope = p.weight_roughness = 0.5;
  p.weight_step = 0;
  p.step_threshold_m = std::numeric_limits<double>::infinity();
  judge_one_surface(s, p);
  return s;
}

}  // namespace talus::baselines
