#include <talus/sim/world.h>

#include <algorithm>

namespace talus::sim
{
namespace
{
constexpr double kGroundReflectivity = 0.3;
}

Pose Mover::pose(double time_s) const
{
  const auto next = std::upper_bound(
      path.begin(), path.end(), time_s, [](double t, const Stop& s) { return t < s.time_s; });
  if (path.size() == 1) return pose_from_rpy({path[0].x_m, path[0].y_m, 0}, 0);
  // Outside its times it keeps the heading of its first or last leg.
  const auto b = next == path.begin() ? path.begin() + 1 : next == path.end() ? next - 1 : next;
  const auto a = b - 1;
  const double leg_s = b->time_s - a->time_s;
  const double w = leg_s > 0 ? std::clamp((time_s - a->time_s) / leg_s, 0.0, 1.0) : 1.0;
  const double dx = b->x_m - a->x_m, dy = b->y_m - a->y_m;
  const double yaw = dx != 0 || dy != 0 ? std::atan2(dy, dx) : 0.0;
  return pose_from_rpy({a->x_m + w * dx, a->y_m + w * dy, 0}, 0, 0, yaw);
}

Pose Mover::on_ground(double time_s, const Ground& ground) const
{
  Pose T = pose(time_s);
  T.m[11] = ground.height_m(T.x(), T.y());
  return T;
}

std::vector<Shape> Mover::placed(const Pose& T_map_mover) const
{
  std::vector<Shape> in_map = shapes;
  for (Shape& s : in_map) s.T_map_shape = compose(T_map_mover, s.T_map_shape);
  return in_map;
}

const Ground& World::ground_at(double time_s) const
{
  const auto next = std::upper_bound(
      ground_changes.begin(), ground_changes.end(), time_s,
      [](double t, const GroundChange& c) { return t < c.time_s; });
  return next == ground_changes.begin() ? ground : (next - 1)->ground;
}

double World::floor_m(double x_m, double y_m, double time_s, double highest_m) const
{
  double floor = ground_at(time_s).height_m(x_m, y_m);
  std::vector<Span> spans;
  for (const Shape& deck : decks)
  {
    if (!deck.is_there(time_s)) continue;
    spans.clear();
    column(deck, x_m, y_m, spans);
    if (!spans.empty() && spans[0].exit_m <= highest_m) floor = std::max(floor, spans[0].exit_m);
  }
  return floor;
}

Scene::Scene(const World& world, double time_s, bool with_movers)
    : world_(world), time_s_(time_s), ground_(world.ground_at(time_s))
{
  if (!with_movers) return;
  for (const Mover& m : world.movers)
    for (const Shape& s : m.placed(m.on_ground(time_s, ground_)))
      if (s.is_there(time_s)) movers_.push_back(s);
}

std::optional<Scene::Hit> Scene::cast(const Ray& ray, double max_m, std::uint64_t chance) const
{
  std::optional<Hit> best;
  const auto reach_m = [&] { return best ? best->range_m : max_m; };
  for (const Shape& s : movers_)
    if (const auto range = first_hit(s, ray, chance); range && *range < reach_m())
      best = Hit{*range, s.reflectivity, &s};
  if (const auto hit = world_.objects.cast(ray, reach_m(), chance, time_s_))
    best = Hit{hit->range_m, hit->shape->reflectivity, hit->shape};
  if (const auto range = ground_.cast(ray, reach_m()))
    best = Hit{*range, kGroundReflectivity, nullptr};
  return best;
}

void Scene::column(double x_m, double y_m, std::vector<Span>& heights_m) const
{
  heights_m.clear();
  world_.objects.column(x_m, y_m, time_s_, heights_m);
  for (const Shape& s : movers_) sim::column(s, x_m, y_m, heights_m);
  std::sort(
      heights_m.begin(), heights_m.end(),
      [](const Span& a, const Span& b) { return a.enter_m < b.enter_m; });
}

}  // namespace talus::sim
