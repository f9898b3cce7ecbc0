#include "follow.h"

#include <cmath>

namespace talus::nav
{
namespace
{
using mrpt::math::TPoint2D;

constexpr double kPatience_s = 5;  // longer than any turn on the spot
constexpr double kStands_m = 0.15;  // poses jump a little
constexpr double kBack_m = 0.8, kIsBack_m = 0.3;
constexpr double kTime_s = 6;  // to get there
constexpr double kTrailStep_m = 0.1;

double apart_m(const TPoint2D& a, const TPoint2D& b) { return std::hypot(a.x - b.x, a.y - b.y); }
}  // namespace

std::optional<TPoint2D> Retreat::target(double time_s, const TPoint2D& at)
{
  follow(time_s, at);
  if (going_back_to_ && (time_s > give_up_s_ || apart_m(at, *going_back_to_) < kIsBack_m))
  {
    going_back_to_.reset();
    stands_since_s_ = time_s;
  }
  if (!going_back_to_ && time_s - stands_since_s_ > kPatience_s)
  {
    going_back_to_ = place_behind(at);
    give_up_s_ = time_s + kTime_s;
    if (!going_back_to_) stands_since_s_ = time_s;
  }
  return going_back_to_;
}

void Retreat::follow(double time_s, const TPoint2D& at)
{
  if (trail_.empty() || apart_m(at, trail_.back()) > kTrailStep_m) trail_.push_back(at);
  if (apart_m(at, stands_at_) < kStands_m) return;
  stands_at_ = at;
  stands_since_s_ = time_s;
}

std::optional<TPoint2D> Retreat::place_behind(const TPoint2D& at) const
{
  for (auto place = trail_.rbegin(); place != trail_.rend(); ++place)
    if (apart_m(at, *place) > kBack_m) return *place;
  return std::nullopt;
}

}  // namespace talus::nav
