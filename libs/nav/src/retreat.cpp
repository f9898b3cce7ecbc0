#include <talus/nav/route.h>

#include <cmath>

namespace talus::nav
{
namespace
{
constexpr double kPatience_s = 5;  // longer than any turn on the spot
constexpr double kStands_m = 0.15;  // poses jump a little
constexpr double kBack_m = 0.8, kIsBack_m = 0.3;
constexpr double kTime_s = 6;  // to get there
constexpr double kTrailStep_m = 0.1;

double apart_m(const Point2& a, const Point2& b)
{
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}
}  // namespace

std::optional<Point2> Retreat::target(double time_s, const Point2& at)
{
  follow(time_s, at);
  if (going_back_to_ && (time_s > give_up_s_ || apart_m(at, *going_back_to_) < kIsBack_m))
  {
    going_back_to_.reset();
    stands_since_s_ = time_s;
  }
  if (!going_back_to_ && time_s - stands_since_s_ > kPatience_s)
  {
    going_back_to_ = position_behind(at);
    give_up_s_ = time_s + kTime_s;
    if (!going_back_to_) stands_since_s_ = time_s;
  }
  return going_back_to_;
}

void Retreat::follow(double time_s, const Point2& at)
{
  if (trail_.empty() || apart_m(at, trail_.back()) > kTrailStep_m) trail_.push_back(at);
  if (apart_m(at, stands_at_) < kStands_m) return;
  stands_at_ = at;
  stands_since_s_ = time_s;
}

std::optional<Point2> Retreat::position_behind(const Point2& at) const
{
  for (auto at_then = trail_.rbegin(); at_then != trail_.rend(); ++at_then)
    if (apart_m(at, *at_then) > kBack_m) return *at_then;
  return std::nullopt;
}

}  // namespace talus::nav
