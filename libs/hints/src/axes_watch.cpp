#include "axes_watch.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "figures.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kStep_m = 0.2;  // of a direction of travel
constexpr double kKeptStep_m = 0.8, kKeptTurn_rad = 0.3;  // between frames that are kept
constexpr std::size_t kMaxFrames = 24, kMaxStraight = 12;  // the others are for turns
constexpr std::size_t kMaxStanding = 6;
constexpr std::size_t kStandingStep = 8;  // frames, of a robot that hardly moves
constexpr double kSpeedGap_s = 0.5;  // of a speed
constexpr std::size_t kMaxSpeeds = 1000, kMinSpeeds = 5;
constexpr double kSameWalls_m = 4;  // frames that see the same walls
constexpr double kAcross = 0.7;  // cosine between the normal of a wall and the path
constexpr double kMinAcross = 40;  // of these, to compare
/** What a position counts that is no metre, in metres; and the other way round. */
constexpr double kUnits[] = {0.001, 0.01, 0.0254, 0.1, 0.3048, 1 / 0.3048, 10};
constexpr double kNearUnit = 0.05;  // a scale as near to one is that

std::string scaled_by(double scale)
{
  return "positions are multiplied by " + fixed_text(scale, scale < 1 ? 4 : 2);
}
}  // namespace

bool AxesWatch::wants(double stamp_s, const Pose& T_map_base)
{
  const double heading = std::atan2(T_map_base.m[4], T_map_base.m[0]);
  if (frames_ == 0) step_begin_ = last_ = T_map_base, step_begin_s_ = last_s_ = stamp_s;
  const double passed_s = stamp_s - last_s_;
  const double rate_hz = passed_s > 0 && passed_s < kSpeedGap_s ? 1 / passed_s : 0;
  const double x_mps = rate_hz * (T_map_base.x() - last_.x()),
               y_mps = rate_hz * (T_map_base.y() - last_.y());
  const double turn_rps =
      rate_hz * std::remainder(heading - std::atan2(last_.m[4], last_.m[0]), 2 * M_PI);
  last_ = T_map_base, last_s_ = stamp_s;
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
  if (kept_.empty()) first_heading_rad_ = heading;
  const double turned_rad = std::remainder(heading - first_heading_rad_, 2 * M_PI);
  most_turned_rad_ = std::max(most_turned_rad_, std::abs(turned_rad));
  const bool may_stand =
      frames_++ % kStandingStep == 0 && path_m_ < kKeptStep_m && kept_.size() < kMaxStanding;
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
  kept_.push_back({T_map_base.x(), T_map_base.y(), heading, x_mps, y_mps, turn_rps, {}});
  return true;
}

std::optional<double> AxesWatch::sideways_rad() const
{
  const double always = std::hypot(cos_sum_, sin_sum_);
  if (path_m_ < kMinSidewaysPath_m || always < kAlwaysSideways * path_m_) return {};
  return std::atan2(sin_sum_, cos_sum_) / 2;
}

/** Its pose, so long after its stamp. */
AxesWatch::Kept AxesWatch::changed(const Kept& k, const Change& c, double time_s)
{
  const double given = k.heading_rad + time_s * k.turn_rps;
  const double cos = std::cos(given), sin = std::sin(given);
  double x = k.x_m + time_s * k.x_mps, y = k.y_m + time_s * k.y_mps;
  if (c.inverts) std::tie(x, y) = std::pair(-cos * x - sin * y, sin * x - cos * y);
  if (c.swaps) std::swap(x, y);
  x -= cos * c.ahead_m - sin * c.left_m;
  y -= sin * c.ahead_m + cos * c.left_m;
  const double heading = (c.inverts || c.mirrors_yaw ? -given : given) + c.turn_rad;
  return {c.scale * x, (c.mirrors_y ? -1 : 1) * c.scale * y, heading, 0, 0, 0, {}};
}

double AxesWatch::apart_m(const Change& c) const
{
  std::vector<std::vector<WallLine>> lines;
  std::vector<Kept> places;
  for (const Kept& k : kept_)
  {
    places.push_back(c.inverts ? changed(k, c, 0) : Kept{k.x_m, k.y_m, 0, 0, 0, 0, {}});
    lines.emplace_back();
    for (const Facet& f : k.facets)
    {
      const Kept at = changed(k, c, f.time_s);
      lines.back().push_back(wall_line(f, at.x_m, at.y_m, at.heading_rad));
    }
  }
  WallsApart apart;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
    {
      const double x = places[i].x_m - places[k].x_m, y = places[i].y_m - places[k].y_m;
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
  constexpr int kTurns = 72, kScales = 40, kLevers = 7;
  constexpr double kLeverStep_m = 0.5;
  std::vector<Change> all{
      {"y of the poses is mirrored", true},
      {"x of the poses is mirrored", true, false, false, M_PI},
      {"y and yaw of the poses are mirrored (or y of the points)", true, true},
      {"the yaw of the poses is mirrored", false, true},
      {"x and y of the poses are swapped", false, false, true},
      {"the yaw of the poses is that of a compass, clockwise from y", false, true, false,
       M_PI / 2}};
  Change other{"the poses are inverted: of the map in the frame of the robot"};
  other.inverts = true;
  all.push_back(other);
  other = {"the poses are those of a point of the robot, not of its base: "};
  for (int i = 0; i < kLevers * kLevers; ++i)
  {
    other.ahead_m = kLeverStep_m * (i % kLevers - kLevers / 2);
    other.left_m = kLeverStep_m * (i / kLevers - kLevers / 2);
    if (other.ahead_m != 0 || other.left_m != 0) all.push_back(other);
  }
  constexpr double kScaleStep = 1.04;
  for (int i = 1; i < kTurns; ++i)
    all.push_back({"the sensor is turned by yaw ", false, false, false, 2 * M_PI * i / kTurns});
  for (int i = -kScales; i <= kScales; ++i)
    if (i != 0) all.push_back({"", false, false, false, 0, std::pow(kScaleStep, i)});
  for (const double unit : kUnits) all.push_back({"", false, false, false, 0, unit});
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
  for (const double by : {0.5, 0.25, 0.125})  // steps
  {
    const Change coarse = best;
    for (const double sign : {-1, 0, 1})
    {
      Change fine = coarse;
      if (fine.turn_rad != 0) fine.turn_rad += sign * by * 2 * M_PI / kTurns;
      if (fine.scale != 1) fine.scale *= std::pow(kScaleStep, sign * by);
      look(fine);
      if (is_lever(coarse))
        for (const double side : {-1, 0, 1})
        {
          fine.ahead_m = coarse.ahead_m + sign * by * kLeverStep_m;
          fine.left_m = coarse.left_m + side * by * kLeverStep_m;
          look(fine);
        }
    }
  }
  for (const double unit : kUnits)
    if (std::abs(best.scale / unit - 1) < kNearUnit) best.scale = unit;
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
  if (is_lever(best))
    text += fixed_text(best.ahead_m, 1) + " m ahead and " + fixed_text(best.left_m, 1) + " m left";
  if (best.turn_rad != 0 && !best.mirrors_yaw && !best.mirrors_y)
    text += fixed_text(std::remainder(best.turn_rad, 2 * M_PI) * 180 / M_PI, 0) + " degrees";
  if (best.scale != 1) text = scaled_by(best.scale);
  return Fit{given_m, best_m, text};
}

std::optional<AxesWatch::Fit> AxesWatch::better_scale() const
{
  constexpr double kFits = 0.2, kHardlyFits = 0.25;  // of the walls; of those that fit best
  Change change{""};
  change.only_across = true;
  const double given_m = apart_m(change);
  double best_m = given_m, scale = 1;
  for (const double unit : kUnits)
  {
    change.scale = unit;
    if (const double m = apart_m(change); m < best_m) best_m = m, scale = unit;
  }
  const double given = 1 - given_m / kMaxApart_m, best = 1 - best_m / kMaxApart_m;
  if (!(best > kFits && given < kHardlyFits * best)) return {};
  return Fit{given_m, best_m, scaled_by(scale)};
}

/** By all motions of up to 2 m and 34 degrees. */
std::optional<AxesWatch::Fit> AxesWatch::better_motions() const
{
  constexpr std::size_t kMinWalls = 12, kMaxWalls = 30, kMinFramePairs = 4;
  constexpr int kMaxSteps = 8, kMaxTurns = 10;  // to each side
  constexpr double kGrid_m = 0.25, kGrid_rad = 0.06, kMotionFits = 0.6;
  struct Motion
  {
    double ahead_m, left_m, turn_rad;
  };
  /** In the frame of its base, moved. */
  const auto lines_of = [&](const Kept& k, const Motion& by)
  {
    std::vector<WallLine> lines;
    const double c = std::cos(by.turn_rad - k.heading_rad),
                 s = std::sin(by.turn_rad - k.heading_rad);
    for (std::size_t i = 0; i < std::min(k.facets.size(), kMaxWalls); ++i)
    {
      const Facet& f = k.facets[i];
      const double x = f.time_s * k.x_mps, y = f.time_s * k.y_mps;
      lines.push_back(wall_line(
          f, by.ahead_m + c * x - s * y, by.left_m + s * x + c * y,
          by.turn_rad + f.time_s * k.turn_rps));
    }
    return lines;
  };
  const auto apart = [&](std::size_t i, const Motion& by)
  {
    WallsApart sum;
    sum.add(lines_of(kept_[i], by), lines_of(kept_[i - 1], {}));
    return sum.mean_m(kMinWalls);
  };
  Values given_m, best_m;
  for (std::size_t i = 1; i < kept_.size(); ++i)
  {
    const Kept &a = kept_[i - 1], &b = kept_[i];
    const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, c = std::cos(a.heading_rad),
                 s = std::sin(a.heading_rad);
    const double m = apart(i, {c * x + s * y, c * y - s * x, b.heading_rad - a.heading_rad});
    if (!std::isnan(m) && a.facets.size() >= kMinWalls) given_m.add(m);
  }
  if (given_m.size() < kMinFramePairs || !(given_m.median() > kMinMovedWalls_m)) return {};
  for (std::size_t i = 1; i < kept_.size(); ++i)
  {
    double least_m = HUGE_VAL;
    Motion best{};
    const auto look = [&](const Motion& by)
    {
      if (const double m = apart(i, by); m < least_m) least_m = m, best = by;
    };
    for (int x = -kMaxSteps; x <= kMaxSteps; ++x)
      for (int y = -kMaxSteps; y <= kMaxSteps; ++y)
        for (int turn = -kMaxTurns; turn <= kMaxTurns; ++turn)
          look({kGrid_m * x, kGrid_m * y, kGrid_rad * turn});
    for (const double by : {0.5, 0.25})
    {
      const Motion middle = best;
      for (int n = 0; n < 27; ++n)
        look(
            {middle.ahead_m + by * kGrid_m * (n % 3 - 1),
             middle.left_m + by * kGrid_m * (n / 3 % 3 - 1),
             middle.turn_rad + by * kGrid_rad * (n / 9 - 1)});
    }
    best_m.add(least_m);
  }
  const Fit fit{given_m.median(), best_m.median(), ""};
  return fit.best_m < kMotionFits * fit.given_m ? std::optional(fit) : std::nullopt;
}

double AxesWatch::apart_standing_m() const
{
  return path_m_ > 0 ? std::numeric_limits<double>::quiet_NaN() : apart_m({""});
}

double AxesWatch::apart_without_yaw_m() const
{
  constexpr double kSteady_rad = 0.01, kTurns = 0.95;
  const bool turns = path_m_ > 0 && std::hypot(cos_sum_, sin_sum_) < kTurns * path_m_;
  return turns && most_turned_rad_ < kSteady_rad ? apart_m({""})
                                                 : std::numeric_limits<double>::quiet_NaN();
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
