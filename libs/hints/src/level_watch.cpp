#include "level_watch.h"

#include <algorithm>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
/** How a plane with that normal rises along a level direction [rad]. */
double rise_rad(const Vec3& normal, double along_x, double along_y)
{
  return std::atan2(-(normal.x * along_x + normal.y * along_y), normal.z);
}

Vec3 up_of(const Pose& T) { return {T.m[2], T.m[6], T.m[10]}; }
}  // namespace

void LevelWatch::add(const Pose& T_map_base)
{
  note_height(T_map_base.z());
  const double up = std::clamp(T_map_base.m[10], -1.0, 1.0);
  most_lean_rad_ = std::max(most_lean_rad_, std::acos(up));
  if (!begin_) begin_ = T_map_base;
  const Vec3 moved = origin_of(T_map_base) - origin_of(*begin_);
  if (std::hypot(moved.x, moved.y) < kSlopePiece_m) return;
  if (normal_) end_piece(T_map_base);
  begin_ = T_map_base;
  normal_.reset();
}

void LevelWatch::note_height(double z_m)
{
  lowest_m_ = heights_ == 0 ? z_m : std::min(lowest_m_, z_m);
  highest_m_ = heights_ == 0 ? z_m : std::max(highest_m_, z_m);
  const double step_m = z_m - last_m_;
  if (heights_ >= 2)
  {
    bend_squares_ += (step_m - step_m_) * (step_m - step_m_);
    ++bends_;
  }
  last_m_ = z_m;
  step_m_ = step_m;
  ++heights_;
}

void LevelWatch::end_piece(const Pose& T_map_base)
{
  const Vec3 moved = origin_of(T_map_base) - origin_of(*begin_);
  const double path_m = std::hypot(moved.x, moved.y);
  const double x = moved.x / path_m, y = moved.y / path_m;
  const double slope = std::atan2(moved.z, path_m);
  const double lean = (rise_rad(up_of(*begin_), x, y) + rise_rad(up_of(T_map_base), x, y)) / 2;
  slopes_ += slope * slope;
  leans_ += lean * slope;
  grounds_ += rise_rad(*normal_, x, y) * slope;
  ++pieces_;
}

double LevelWatch::path_slope_rad() const
{
  return pieces_ == 0 ? 0 : std::sqrt(slopes_ / static_cast<double>(pieces_));
}

double LevelWatch::noise_slope_rad() const
{
  // Second differences of white noise have six times its variance; two heights make a slope.
  const double variance = bends_ == 0 ? 0 : bend_squares_ / (6 * static_cast<double>(bends_));
  return std::sqrt(2 * variance) / kSlopePiece_m;
}

double LevelWatch::pose_share() const { return slopes_ > 0 ? leans_ / slopes_ : 1; }

double LevelWatch::ground_share() const { return slopes_ > 0 ? grounds_ / slopes_ : 1; }

}  // namespace talus::hints
