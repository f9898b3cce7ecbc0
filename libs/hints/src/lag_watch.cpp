#include "lag_watch.h"

#include <algorithm>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr std::size_t kMaxStops = 100000;
constexpr std::size_t kMaxTurningFrames = 12, kMaxTurnFrames = 4, kMaxCalmFrames = 6;  // frames
constexpr std::size_t kPartners = 3;  // of each frame
constexpr double kPartnerReach_m = 4, kPartnerTime_s = 20;
constexpr double kLateStep_s = 0.1;
constexpr double kGap_s = 0.5;  // of a turn rate

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }
}  // namespace

bool LagWatch::wants(double stamp_s, const Pose& T_map_base)
{
  double heading = std::atan2(T_map_base.m[4], T_map_base.m[0]);
  double turn_rps = 0;
  bool has_rate = false;
  if (!path_.empty())
  {
    const Stop& last = path_.back();
    const double passed_s = stamp_s - last.stamp_s;
    if (passed_s <= 0 || path_.size() >= kMaxStops) return false;
    heading = last.heading_rad + wrapped(heading - last.heading_rad);
    has_rate = passed_s < kGap_s;
    turn_rps = (heading - last.heading_rad) / passed_s;
  }
  path_.push_back({stamp_s, T_map_base.x(), T_map_base.y(), heading});
  return has_rate && keeps(stamp_s, turn_rps);
}

/** Some frames of each turn, and calm ones between turns. */
bool LagWatch::keeps(double stamp_s, double turn_rps)
{
  const bool turns = std::abs(turn_rps) > kMinTurn_rps;
  of_turn_ = turns && turn_rps * last_rps_ > 0 ? of_turn_ + 1 : 1;
  last_rps_ = turns ? turn_rps : 0;
  const std::size_t calm = kept_.size() - turning_;
  if (turns && (turning_ >= kMaxTurningFrames || of_turn_ > kMaxTurnFrames)) return false;
  const double step_s = turning_ == 0 ? kCalmStep_s : kKeptStep_s;
  const bool is_soon = !kept_.empty() && stamp_s - kept_.back().stamp_s < step_s;
  if (!turns && (calm >= kMaxCalmFrames || is_soon)) return false;
  if (!turns && turning_ == 0) kept_.clear();  // the last before the first turn is enough
  turning_ += turns;
  kept_.push_back({stamp_s, turn_rps, {}});
  return true;
}

void LagWatch::add(std::vector<Facet> facets) { kept_.back().facets = std::move(facets); }

double LagWatch::fastest_rps() const
{
  double fastest = 0;
  for (const Kept& k : kept_) fastest = std::max(fastest, std::abs(k.turn_rps));
  return fastest;
}

LagWatch::Stop LagWatch::place_at(double stamp_s) const
{
  const auto after = std::lower_bound(
      path_.begin(), path_.end(), stamp_s, [](const Stop& p, double t) { return p.stamp_s < t; });
  if (after == path_.begin()) return path_.front();
  if (after == path_.end()) return path_.back();
  const Stop &a = *(after - 1), &b = *after;
  const double f = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
  const auto between = [f](double from, double to) { return from + f * (to - from); };
  return {
      stamp_s, between(a.x_m, b.x_m), between(a.y_m, b.y_m), between(a.heading_rad, b.heading_rad)};
}

std::vector<WallLine> LagWatch::lines_of(const Kept& kept, const Lag& lag) const
{
  std::vector<WallLine> lines;
  lines.reserve(kept.facets.size());
  const double late_s =
      lag.late_s + lag.grown_s * (kept.stamp_s - path_.front().stamp_s) / duration_s();
  for (const Facet& f : kept.facets)
  {
    const double turn =
        lag.sweep_s < 0 ? lag.first_rad - f.bearing_rad : f.bearing_rad - lag.first_rad;
    const double share = turn / (2 * M_PI) - std::floor(turn / (2 * M_PI));
    const double time_s = lag.times * f.time_s + share * std::abs(lag.sweep_s);
    const Stop at = place_at(kept.stamp_s - late_s + time_s);
    lines.push_back(wall_line(f, at.x_m, at.y_m, at.heading_rad));
  }
  return lines;
}

/** Those near by that turned most differently. */
std::vector<std::size_t> LagWatch::partners_of(std::size_t kept) const
{
  const Kept& one = kept_[kept];
  const Stop at = place_at(one.stamp_s);
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t i = 0; i < kept_.size(); ++i)
  {
    const Stop other = place_at(kept_[i].stamp_s);
    const double apart_rps = std::abs(kept_[i].turn_rps - one.turn_rps);
    if (apart_rps > kMinTurn_rps && std::abs(other.stamp_s - at.stamp_s) < kPartnerTime_s &&
        std::hypot(other.x_m - at.x_m, other.y_m - at.y_m) < kPartnerReach_m)
      found.emplace_back(-apart_rps, i);
  }
  std::sort(found.begin(), found.end());
  if (found.size() > kPartners) found.resize(kPartners);
  std::vector<std::size_t> partners;
  partners.reserve(found.size());
  for (const auto& [rate, i] : found) partners.push_back(i);
  return partners;
}

double LagWatch::apart_m(const Lag& lag) const
{
  std::vector<std::vector<WallLine>> lines;
  for (const Kept& k : kept_) lines.push_back(lines_of(k, lag));
  WallsApart apart;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    for (const std::size_t other : partners_of(i)) apart.add(lines[i], lines[other]);
  return apart.mean_m();
}

Lag LagWatch::refined(Lag lag, double Lag::*changed, double step_s) const
{
  for (double step = step_s / 2; step > 0.004; step /= 2)
  {
    Lag best = lag;
    for (const double change : {-step, step})
    {
      Lag tried = lag;
      tried.*changed += change;
      if (apart_m(tried) < apart_m(best)) best = tried;
    }
    lag = best;
  }
  return lag;
}

Lag LagWatch::best_clock(const Lag& from, double Lag::*changed, double max_s) const
{
  Lag best = from, tried = from;
  for (tried.*changed = -max_s; tried.*changed <= max_s + 1e-9; tried.*changed += kLateStep_s)
    if (apart_m(tried) < apart_m(best)) best = tried;
  return refined(best, changed, kLateStep_s);
}

Lag LagWatch::best_sweep() const
{
  Lag best;
  for (const double sweep_s : {-0.1, -0.05, 0.05, 0.1})
    for (const double first_rad : {0.0, M_PI / 2, M_PI, -M_PI / 2})
      for (const double late : {0.0, 0.5, 1.0})  // stamped at its beginning, middle, end
        if (const Lag lag{late * std::abs(sweep_s), sweep_s, first_rad};
            apart_m(lag) < apart_m(best))
          best = lag;
  return refined(best, &Lag::late_s, 0.05);
}

}  // namespace talus::hints
