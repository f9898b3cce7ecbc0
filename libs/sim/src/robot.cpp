#include <talus/sim/robot.h>

#include <algorithm>
#include <limits>

namespace talus::sim
{
namespace
{
constexpr double kPiece_m = 0.02;

/** Tangent at waypoint i: the slopes of both neighbouring chords, weighted by the other's length.
 */
Vec3 tangent(const std::vector<Vec3>& p, std::size_t i)
{
  if (i == 0) return normalized(p[1] - p[0]);
  if (i + 1 == p.size()) return normalized(p[i] - p[i - 1]);
  const Vec3 before = p[i] - p[i - 1], after = p[i + 1] - p[i];
  const double a = norm(before), b = norm(after);
  return (before * (b / a) + after * (a / b)) * (1.0 / (a + b));
}

/** Cubic Hermite curve between two points at w in [0, 1]. */
Vec3 hermite(const Vec3& p0, const Vec3& m0, const Vec3& p1, const Vec3& m1, double w)
{
  const double w2 = w * w, w3 = w2 * w;
  return p0 * (2 * w3 - 3 * w2 + 1) + m0 * (w3 - 2 * w2 + w) + p1 * (3 * w2 - 2 * w3) +
         m1 * (w3 - w2);
}

}  // namespace

RobotPath::RobotPath(const RobotSetup& setup, const Ground& ground) : setup_(setup), ground_(ground)
{
  const auto& p = setup_.waypoints;
  points_.push_back({0, p[0].x, p[0].y});
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
  {
    const double chord = norm(p[i + 1] - p[i]);
    const int pieces = std::max(1, static_cast<int>(std::ceil(chord / kPiece_m)));
    const Vec3 m0 = tangent(p, i) * chord, m1 = tangent(p, i + 1) * chord;
    for (int k = 1; k <= pieces; ++k)
    {
      const Vec3 q = hermite(p[i], m0, p[i + 1], m1, static_cast<double>(k) / pieces);
      const Point& last = points_.back();
      points_.push_back({last.distance_m + std::hypot(q.x - last.x_m, q.y - last.y_m), q.x, q.y});
    }
  }
}

double RobotPath::duration_s() const
{
  return setup_.duration_s > 0 ? setup_.duration_s : length_m() / setup_.speed_mps;
}

double RobotPath::distance_m(double time_s) const
{
  return std::clamp(setup_.speed_mps * time_s, 0.0, length_m());
}

Pose RobotPath::T_map_base(double time_s) const
{
  const double s = distance_m(time_s);
  double x = points_[0].x_m, y = points_[0].y_m, yaw = setup_.yaw_rad;
  if (points_.size() > 1)
  {
    auto b = std::upper_bound(
        points_.begin(), points_.end(), s,
        [](double d, const Point& p) { return d < p.distance_m; });
    b = std::clamp(b, points_.begin() + 1, points_.end() - 1);
    const auto a = b - 1;
    const double w = (s - a->distance_m) / (b->distance_m - a->distance_m);
    x = a->x_m + w * (b->x_m - a->x_m);
    y = a->y_m + w * (b->y_m - a->y_m);
    yaw = std::atan2(b->y_m - a->y_m, b->x_m - a->x_m);
  }
  const double c = std::cos(yaw), n = std::sin(yaw);
  const double hl = 0.5 * setup_.wheelbase_m, hw = 0.5 * setup_.track_m;
  const auto wheel = [&](double fx, double fy)
  { return ground_.height_m(x + c * fx - n * fy, y + n * fx + c * fy); };
  const double fl = wheel(hl, hw), fr = wheel(hl, -hw), rl = wheel(-hl, hw), rr = wheel(-hl, -hw);
  const Vec3 forward = normalized({c, n, (fl + fr - rl - rr) / (2 * setup_.wheelbase_m)});
  const Vec3 sideways{-n, c, (fl + rl - fr - rr) / (2 * setup_.track_m)};
  const Vec3 up = normalized(cross(forward, sideways));
  return pose_from_axes(forward, cross(up, forward), up, {x, y, 0.25 * (fl + fr + rl + rr)});
}

double RobotPath::distance_to_m(double x_m, double y_m) const
{
  constexpr double kRounding_m = 1e-6;
  double best = std::numeric_limits<double>::infinity();
  for (auto p = points_.begin(); p != points_.end();)
  {
    const double here_m = std::hypot(p->x_m - x_m, p->y_m - y_m);
    best = std::min(best, here_m);
    // No place of the curve is nearer than the way there.
    const double none_before_m = p->distance_m + here_m - best - kRounding_m;
    p = std::upper_bound(
        p + 1, points_.end(), none_before_m,
        [](double d, const Point& q) { return d < q.distance_m; });
  }
  return best;
}

Bounds RobotPath::bounds() const
{
  Bounds b{{points_[0].x_m, points_[0].y_m, 0}, {points_[0].x_m, points_[0].y_m, 0}};
  for (const Point& p : points_)
  {
    b.min_m = {std::min(b.min_m.x, p.x_m), std::min(b.min_m.y, p.y_m), 0};
    b.max_m = {std::max(b.max_m.x, p.x_m), std::max(b.max_m.y, p.y_m), 0};
  }
  return b;
}

}  // namespace talus::sim
