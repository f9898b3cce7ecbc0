#include <talus/sim/robot.h>

#include <algorithm>
#include <limits>

namespace talus::sim
{
namespace
{
constexpr double kPiece_m = 0.02;
constexpr double kFloorStep_m = 0.3;  //!< a floor higher than this is not the next one

/** Tangent at waypoint i: the slopes of both chords beside it, weighted by the other's length. */
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

RobotPath::RobotPath(const World& world) : world_(world)
{
  const auto& p = world.robot.waypoints;
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
  if (!world.decks.empty() || !world.robot.lifts.empty()) follow_floors();
}

double RobotPath::path_s() const
{
  double path_s = length_m() / world_.robot.speed_mps;
  for (const Lift& lift : world_.robot.lifts) path_s += lift.duration_s;
  return path_s;
}

double RobotPath::duration_s() const
{
  return world_.robot.duration_s > 0 ? world_.robot.duration_s : path_s();
}

double RobotPath::distance_m(double time_s) const
{
  double drives_s = time_s;
  for (const Lift& lift : world_.robot.lifts)
    drives_s -= std::clamp(time_s - lift.time_s, 0.0, lift.duration_s);
  return std::clamp(world_.robot.speed_mps * drives_s, 0.0, length_m());
}

/** When the robot has driven a distance, if it comes there after this number of lifts. */
double RobotPath::time_at_s(double distance_m, std::size_t lifts) const
{
  double time = distance_m / world_.robot.speed_mps;
  for (std::size_t i = 0; i < lifts; ++i) time += world_.robot.lifts[i].duration_s;
  return time;
}

std::size_t RobotPath::point_before(double distance_m) const
{
  const auto next = std::upper_bound(
      points_.begin() + 1, points_.end(), distance_m,
      [](double d, const Point& p) { return d < p.distance_m; });
  return static_cast<std::size_t>(next - points_.begin()) - 1;
}

void RobotPath::follow_floors()
{
  legs_.push_back(leg(0, 0, world_.ground.height_m(points_[0].x_m, points_[0].y_m)));
  for (const Lift& lift : world_.robot.lifts)
  {
    const double from_m = stand(lift.time_s, legs_.size() - 1).z();
    const std::size_t at = point_before(distance_m(lift.time_s));
    legs_.push_back(leg(at, lift.time_s + lift.duration_s, from_m + lift.z_m));
  }
}

RobotPath::Leg RobotPath::leg(std::size_t first, double start_s, double floor_m) const
{
  Leg out;
  out.first = first;
  out.lands_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i < points_.size(); ++i)
  {
    const Point& p = points_[i];
    const double time_s = std::max(start_s, time_at_s(p.distance_m, legs_.size()));
    const double floor = world_.floor_m(p.x_m, p.y_m, time_s, floor_m + kFloorStep_m);
    const bool landed = out.lands_m <= p.distance_m;
    if (!landed && std::abs(floor - floor_m) <= kFloorStep_m) out.lands_m = p.distance_m;
    if (landed || out.lands_m <= p.distance_m) floor_m = floor;
    out.floor_m.push_back(floor_m);
  }
  return out;
}

Pose RobotPath::T_map_base(double time_s) const
{
  if (legs_.empty()) return stand(time_s, 0);
  const auto& lifts = world_.robot.lifts;
  const auto next = std::upper_bound(
      lifts.begin(), lifts.end(), time_s, [](double t, const Lift& l) { return t < l.time_s; });
  const auto leg = static_cast<std::size_t>(next - lifts.begin());
  if (leg == 0 || time_s >= lifts[leg - 1].time_s + lifts[leg - 1].duration_s)
    return stand(time_s, leg);
  const Lift& lift = lifts[leg - 1];
  Pose T = stand(lift.time_s, leg - 1);
  T.m[11] += lift.z_m * (time_s - lift.time_s) / lift.duration_s;
  return T;
}

/** On the floor, or above it, of one of the legs. */
Pose RobotPath::stand(double time_s, std::size_t leg) const
{
  const RobotSetup& setup = world_.robot;
  const double s = distance_m(time_s);
  double x = points_[0].x_m, y = points_[0].y_m, yaw = setup.yaw_rad;
  if (points_.size() > 1)
  {
    const std::size_t before = std::min(point_before(s), points_.size() - 2);
    const Point &a = points_[before], &b = points_[before + 1];
    const double w = (s - a.distance_m) / (b.distance_m - a.distance_m);
    x = a.x_m + w * (b.x_m - a.x_m);
    y = a.y_m + w * (b.y_m - a.y_m);
    yaw = std::atan2(b.y_m - a.y_m, b.x_m - a.x_m);
  }
  const double c = std::cos(yaw), n = std::sin(yaw);
  const double hl = 0.5 * setup.wheelbase_m, hw = 0.5 * setup.track_m;
  const auto wheel = [&](double fx, double fy)
  { return wheel_m(x + c * fx - n * fy, y + n * fx + c * fy, time_s, leg); };
  const double fl = wheel(hl, hw), fr = wheel(hl, -hw), rl = wheel(-hl, hw), rr = wheel(-hl, -hw);
  const Vec3 forward = normalized({c, n, (fl + fr - rl - rr) / (2 * setup.wheelbase_m)});
  const Vec3 sideways{-n, c, (fl + rl - fr - rr) / (2 * setup.track_m)};
  const Vec3 up = normalized(cross(forward, sideways));
  return pose_from_axes(forward, cross(up, forward), up, {x, y, 0.25 * (fl + fr + rl + rr)});
}

/** Height of a wheel's lowest point at (x, y), on one of the legs. */
double RobotPath::wheel_m(double x_m, double y_m, double time_s, std::size_t leg) const
{
  if (legs_.empty()) return world_.ground_at(time_s).height_m(x_m, y_m);
  const Leg& now = legs_[leg];
  const double s = distance_m(time_s);
  const std::size_t at = std::max(point_before(s), now.first) - now.first;
  const double around_m = now.floor_m[at];
  const double floor = world_.floor_m(x_m, y_m, time_s, around_m + kFloorStep_m);
  const bool hangs = s < now.lands_m && std::abs(floor - around_m) > kFloorStep_m;
  return hangs ? around_m : floor;
}

double RobotPath::distance_to_m(double x_m, double y_m) const
{
  constexpr double kRounding_m = 1e-6;
  double best = std::numeric_limits<double>::infinity();
  for (auto p = points_.begin(); p != points_.end();)
  {
    const double here_m = std::hypot(p->x_m - x_m, p->y_m - y_m);
    best = std::min(best, here_m);
    // No point of the curve is nearer than the path to it.
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
