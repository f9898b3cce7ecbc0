#include "axes_watch.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kStep_m = 0.2;  // of a direction of travel
constexpr double kKeptStep_m = 0.8, kKeptTurn_rad = 0.3;  // between frames that are kept
constexpr std::size_t kMaxFrames = 24, kMaxStraight = 12;  // the others are for turns
constexpr std::size_t kStandingStep = 8;  // frames, of a robot that stands
constexpr std::size_t kMaxSpeeds = 1000, kMinSpeeds = 5;
constexpr double kSameWalls_m = 4;  // frames that see the same walls
constexpr double kAcross = 0.7;  // cosine between the normal of a wall and the path
constexpr double kMinAcross = 40;  // of these, to compare
constexpr double kMinScale = 1.1;  // what a sound drive fits by chance: less
}  // namespace

bool AxesWatch::wants(double stamp_s, const Pose& T_map_base)
{
  const double heading = std::atan2(T_map_base.m[4], T_map_base.m[0]);
  if (frames_ == 0) step_begin_ = T_map_base, step_begin_s_ = stamp_s;
  const double x = T_map_base.x() - step_begin_.x(), y = T_map_base.y() - step_begin_.y();
  if (const double moved_m = std::hypot(x, y); moved_m >= kStep_m)
  {
    const double middle = std::atan2(step_begin_.m[4], step_begin_.m[0]);
    const double off = std::atan2(y, x) - middle - std::remainder(heading - middle, 2 * M_PI) / 2;
    path_m_ += moved_m;
    cos_sum_ += moved_m * std::cos(2 * off);
    sin_sum_ += moved_m * std::sin(2 * off);
    if (stamp_s > step_begin_s_ && speeds_mps_.size() < kMaxSpeeds)
      speeds_mps_.push_back(static_cast<float>(moved_m / (stamp_s - step_begin_s_)));
    step_begin_ = T_map_base, step_begin_s_ = stamp_s;
  }
  const bool may_stand = frames_++ % kStandingStep == 0 && path_m_ == 0;
  if (kept_.size() >= kMaxFrames) return false;
  if (!kept_.empty())
  {
    const Kept& last = kept_.back();
    const bool turned =
        std::abs(std::remainder(heading - last.heading_rad, 2 * M_PI)) > kKeptTurn_rad;
    const bool moved =
        std::hypot(T_map_base.x() - last.x_m, T_map_base.y() - last.y_m) > kKeptStep_m;
    if (!turned && !((moved || may_stand) && kept_.size() < kMaxStraight)) return false;
  }
  kept_.push_back({T_map_base.x(), T_map_base.y(), heading, {}});
  return true;
}

std::optional<double> AxesWatch::sideways_rad() const
{
  const double always = std::hypot(cos_sum_, sin_sum_);
  if (path_m_ < kMinSidewaysPath_m || always < kAlwaysSideways * path_m_) return {};
  return std::atan2(sin_sum_, cos_sum_) / 2;
}

double AxesWatch::apart_m(const Change& c) const
{
  std::vector<std::vector<WallLine>> lines;
  for (const Kept& k : kept_)
  {
    const double x = c.scale * (c.swaps ? k.y_m : k.x_m), y = c.scale * (c.swaps ? k.x_m : k.y_m);
    const double heading = (c.mirrors_yaw ? -1 : 1) * k.heading_rad + c.turn_rad;
    lines.emplace_back();
    for (const Facet& f : k.facets)
      lines.back().push_back(wall_line(f, x, c.mirrors_y ? -y : y, heading));
  }
  WallsApart apart;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
    {
      const double x = kept_[i].x_m - kept_[k].x_m, y = kept_[i].y_m - kept_[k].y_m;
      const double away_m = std::hypot(x, y);
      if (away_m >= kSameWalls_m) continue;
      auto walls = lines[i];
      const auto is_along = [&](const WallLine& wall)
      { return std::abs(wall.normal_x * x + wall.normal_y * y) < kAcross * away_m; };
      if (c.only_across)
        walls.erase(std::remove_if(walls.begin(), walls.end(), is_along), walls.end());
      apart.add(walls, lines[k]);
    }
  return apart.mean_m(c.only_across ? kMinAcross : kMinCompared);
}

AxesWatch::Change AxesWatch::best_change() const
{
  std::vector<Change> all{
      {"y of the poses is mirrored", true},
      {"y and yaw of the poses are mirrored (or y of the points)", true, true},
      {"the yaw of the poses is mirrored", false, true},
      {"x and y of the poses are swapped", false, false, true}};
  constexpr int kTurns = 72, kScales = 40;
  constexpr double kScaleStep = 1.04;
  for (int i = 1; i < kTurns; ++i)
    all.push_back({"the sensor is turned by yaw ", false, false, false, 2 * M_PI * i / kTurns});
  for (int i = -kScales; i <= kScales; ++i)
    if (i != 0)
      all.push_back(
          {"positions are multiplied by ", false, false, false, 0, std::pow(kScaleStep, i)});
  Change best = all.front();
  double least_m = HUGE_VAL;
  const auto look = [&](const Change& change)
  {
    const double m = apart_m(change);
    if (!(m < least_m)) return;
    least_m = m;
    best = change;
  };
  for (const Change& change : all) look(change);
  const Change coarse = best;
  for (const double by : {-0.5, -0.25, 0.25, 0.5})  // steps
  {
    Change fine = coarse;
    if (fine.turn_rad != 0) fine.turn_rad += by * 2 * M_PI / kTurns;
    if (fine.scale != 1) fine.scale *= std::pow(kScaleStep, by);
    if (fine.turn_rad != 0 || fine.scale != 1) look(fine);
  }
  return best;
}

std::optional<AxesWatch::Fit> AxesWatch::better_axes() const
{
  const double given_m = apart_m({""});
  if (!(given_m > kMinWrongAxes_m)) return {};
  const Change best = best_change();
  const double best_m = apart_m(best);
  if (!(best_m < kAxesFit * given_m)) return {};
  std::string text = best.text;
  if (best.turn_rad != 0)
    text += fixed_text(std::remainder(best.turn_rad, 2 * M_PI) * 180 / M_PI, 0) + " degrees";
  if (best.scale != 1) text += fixed_text(best.scale, 2);
  return Fit{given_m, best_m, text};
}

std::optional<AxesWatch::Fit> AxesWatch::better_scale() const
{
  constexpr int kScales = 80;
  constexpr double kScaleStep = 1.02;
  constexpr double kFits = 0.2, kHardlyFits = 0.25;  // of the walls; of those that fit best
  Change change{""};
  change.only_across = true;
  const double given_m = apart_m(change);
  double best_m = given_m, scale = 1;
  for (int i = -kScales; i <= kScales; ++i)
  {
    change.scale = std::pow(kScaleStep, i);
    if (const double m = apart_m(change); m < best_m) best_m = m, scale = change.scale;
  }
  const double given = 1 - given_m / kMaxApart_m, best = 1 - best_m / kMaxApart_m;
  if (!(best > kFits && given < kHardlyFits * best) || std::max(scale, 1 / scale) < kMinScale)
    return {};
  return Fit{given_m, best_m, "positions are multiplied by " + fixed_text(scale, 2)};
}

double AxesWatch::apart_standing_m() const
{
  return path_m_ > 0 ? std::numeric_limits<double>::quiet_NaN() : apart_m({""});
}

double AxesWatch::speed_mps() const
{
  if (speeds_mps_.size() < kMinSpeeds) return 0;
  auto sorted = speeds_mps_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

}  // namespace talus::hints
