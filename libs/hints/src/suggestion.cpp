#include <talus/hints/hint.h>

#include <talus/hints/hint_finder.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

#include "judge.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr double kMinHalfWindow_m = 4, kMaxHalfWindow_m = 12;
constexpr double kBeyondReach = 1.2;  // of what 9 of 10 points on the ground are nearer than
constexpr double kMaxCells = 360;  // along a side; coarser cells miss and widen what is small
constexpr double kBelowGround_m = 1.2;  // ditches and slopes down
constexpr double kHeightError_m = 0.03;  // of the sensor's height by the ground
constexpr double kAboveGround_m = 2.2;  // what a robot could meet
constexpr double kMinNoise_m = 0.01, kMaxNoise_m = 0.03;  // neighbours of a ring err alike
constexpr double kCalmShare = 0.25;  // of the cells: those without roughness of their own

double round_up(double value, double step) { return std::ceil(value / step - 1e-6) * step; }
double to_step(double value, double step) { return std::round(value / step) * step; }
std::string metres(double m) { return fixed_text(m, 2) + " m"; }

/** What a suggestion rests on. */
struct Basis
{
  double height_m = 0;  //!< of the sensor above the ground; 0: none was seen
  double reach_m = 0;
  double half_window_m = 0, resolution_m = 0;
  std::optional<HighestRay> highest;  //!< ahead
};

Basis basis_of(const Figures& f, const SensorFigures& s)
{
  Basis b;
  b.highest = highest_ray(f);
  if (s.share(s.ground_m) > kGroundShare)
    b.height_m = s.sensor_above_m.median();
  else if (s.above_far_ground_m.size() > 0)
    b.height_m = s.above_far_ground_m.median();
  b.height_m = std::max(0.0, b.height_m);
  b.reach_m = s.reach_m.median();
  const double far_m = std::max(
      std::min(kMaxHeights * b.height_m, kBeyondReach * b.reach_m),
      kBeyondNearest * s.nearest_m.median());
  b.half_window_m = std::clamp(std::round(far_m), kMinHalfWindow_m, kMaxHalfWindow_m);
  b.resolution_m = 2 * b.half_window_m / 0.05 <= kMaxCells ? 0.05 : 0.1;
  return b;
}

using Suggestions = std::vector<Suggestion>;

void suggest_window(const Basis& b, Suggestions& out)
{
  const double window_m = 2 * b.half_window_m;
  out.push_back(
      {"resolution_m", number_text(b.resolution_m),
       number_text(window_m / b.resolution_m) + " cells along a side, of no more than " +
           number_text(kMaxCells)});
  out.push_back(
      {"window_m", number_text(window_m),
       "to 7 times the height of the sensor (" + metres(b.height_m) +
           "), beyond which beams graze the ground, not beyond what is seen (" + metres(b.reach_m) +
           ") nor " + number_text(2 * kMaxHalfWindow_m) + " m"});
}

void suggest_heights(const Basis& b, Suggestions& out)
{
  const Parameters defaults;
  const double low_m = std::max(-defaults.min_height_m, round_up(b.height_m + kBelowGround_m, 0.5));
  const double high_m = std::max(0.5, round_up(kAboveGround_m - b.height_m, 0.1));
  const double clearance_m =
      std::max(defaults.clearance_m, round_up(b.height_m - kHeightError_m, 0.1));
  const std::string ground = "the ground lies " + metres(b.height_m) + " below the sensor";
  out.push_back({"min_height_m", number_text(-low_m), ground + ", ditches deeper"});
  out.push_back(
      {"max_height_m", number_text(high_m), ground + ": up to where a robot could meet something"});
  out.push_back(
      {"clearance_m", number_text(clearance_m),
       "the robot is as high as its sensor (" + metres(b.height_m) + ") at least" +
           (b.highest ? "; ahead something that high is seen " + seen_ahead(*b.highest, clearance_m)
                      : std::string())});
}

void suggest_filling(const Basis& b, Suggestions& out)
{
  const Parameters defaults;
  const double search_m = to_step(std::max(defaults.fill_search_m, b.half_window_m / 3), 0.5);
  const std::string reason = "rings of beams are so far apart near the border of the window";
  out.push_back({"fill_search_m", number_text(search_m), reason});
  out.push_back({"fill_kernel_m", number_text(search_m), reason});
  const double radius_m = std::max(
      defaults.feature_radius_m, b.resolution_m < 0.1 ? 2 * b.resolution_m : 3 * b.resolution_m);
  out.push_back({"feature_radius_m", number_text(radius_m), "a few cells each way"});
}

void suggest_body(const Figures& f, const Parameters& p, Suggestions& out)
{
  const Parameters with = with_body(f, p);
  const bool knows = std::any_of(
      f.sensors.begin(), f.sensors.end(),
      [](const SensorFigures& s) { return s.body.is_conclusive(); });
  if (knows && with.body_boxes_m.empty()) return;
  out.push_back(
      {"body_boxes_m", parameter_text(with, *find_parameter("body_boxes_m")),
       knows ? "what moves with the robot"
             : "unknown: what moves with the robot is known once it has driven " +
                   number_text(kMinBodyPath_m) + " m and turned by " +
                   number_text(kMinBodyTurn_deg) + " degrees"});
}

void suggest_noise(const SensorFigures& s, Suggestions& out)
{
  const Parameters defaults;
  const double seen_m = s.spread_m.quantile(kCalmShare);
  if (s.spread_m.size() == 0)
    out.push_back(
        {"c_beam_m", number_text(defaults.c_beam_m),
         "the default: no piece of ground was hit often enough"});
  else
    out.push_back(
        {"c_beam_m", number_text(std::clamp(to_step(seen_m, 0.001), kMinNoise_m, kMaxNoise_m)),
         "heights of calm ground scatter by " + fixed_text(seen_m, 3) + " m within a scan; " +
             number_text(kMinNoise_m) + " at least"});
}
}  // namespace

std::vector<Suggestion> HintFinder::suggest() const
{
  Suggestions out;
  const SensorFigures* s = figures_->sensor_with_most_frames();
  if (!s) return out;
  const Basis basis = basis_of(*figures_, *s);
  if (basis.height_m > 0)
  {
    suggest_window(basis, out);
    suggest_heights(basis, out);
    suggest_filling(basis, out);
  }
  suggest_body(*figures_, parameters_, out);
  suggest_noise(*s, out);
  return out;
}

}  // namespace talus::hints
