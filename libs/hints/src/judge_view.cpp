// Hints about settings: what of the points reaches the map. And which hints count.
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

#include "judge.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
std::string percent(double share) { return fixed_text(100 * share, 0) + " %"; }

double share_of(std::uint64_t part, std::uint64_t whole)
{
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/** Height of the sensor above the ground, 0 where none was seen. */
double height_of(const SensorFigures* s)
{
  return s && s->share(s->ground_m) > kGroundShare ? s->sensor_above_m.median() : 0;
}
}  // namespace

std::optional<Hint> height_band(const Figures& f, const Parameters& p)
{
  const double height_m = height_of(f.sensor_with_most_frames());
  const double below = share_of(f.below_band, f.sampled), above = share_of(f.above_band, f.sampled);
  const bool cuts_ground = height_m > 0 && -height_m < p.min_height_m;
  const bool ground_above = height_m > 0 && -height_m > p.max_height_m;
  if (ground_above || (above > kMajority && p.max_height_m < p.clearance_m - height_m))
    return Hint{
        Kind::HeightBand,
        percent(above) + " of the points lie above max_height_m = " + number_text(p.max_height_m) +
            " (from the sensor, which is " + fixed_text(height_m, 2) +
            " m above the ground): set max_height_m to " +
            fixed_text(std::max(0.5, p.clearance_m - height_m + 0.5), 1) + " or more"};
  if (below > kMajority || (cuts_ground && below > 0.1))
    return Hint{
        Kind::HeightBand,
        percent(below) + " of the points lie below min_height_m = " + number_text(p.min_height_m) +
            " (from the sensor" +
            (height_m > 0 ? ", which is " + fixed_text(height_m, 2) + " m above the ground"
                          : std::string()) +
            "): set min_height_m to " +
            fixed_text(-std::ceil(std::max(height_m, -p.min_height_m) + 1), 0)};
  return {};
}

namespace
{
/** The window that shows the ground, no smaller than it is. */
std::string enough_window(const SensorFigures* s, const Parameters& p)
{
  if (!s) return fixed_text(2 * std::ceil(p.window_m), 0);
  const double height_m = height_of(s) > 0 ? height_of(s) : s->above_far_ground_m.median();
  const double reach_m = s->reach_m.median();
  const double enough_m = height_m > 0 ? std::min(reach_m, kMaxHeights * height_m) : reach_m;
  const double least_m = kBeyondNearest * s->nearest_m.median();
  return fixed_text(2 * std::ceil(std::max({enough_m, least_m, p.window_m})), 0);
}

/** The ground begins where the window ends. */
std::optional<Hint> ground_outside(const SensorFigures* s, const Parameters& p)
{
  if (!s || s->share(s->nearest_m) <= kGroundShare) return {};
  const double nearest_m = s->nearest_m.median();
  if (nearest_m < kGroundAtBorder * p.window_m / 2) return {};
  return Hint{
      Kind::Window, "the ground begins " + fixed_text(nearest_m, 1) +
                        " m from the sensor, outside of the window of " + number_text(p.window_m) +
                        " m: set window_m to " + enough_window(s, p)};
}
}  // namespace

std::optional<Hint> window_too_small(const Figures& f, const Parameters& p, double known_share)
{
  const SensorFigures* s = f.sensor_with_most_frames();
  if (auto hint = ground_outside(s, p)) return hint;
  const auto outside = f.rejected[static_cast<std::size_t>(Reject::Outside)];
  const double share = share_of(outside, outside + f.accepted);
  const double reach_m = s ? s->reach_m.median() : 0;
  const bool is_blind_spot = p.window_m / 2 < kMinHeights * height_of(s);
  const bool is_empty = known_share < kKnownInside;
  if (share < kOutside && !(share > kMajority && (is_blind_spot || is_empty))) return {};
  return Hint{
      Kind::Window,
      percent(share) + " of the points lie outside of the window of " + number_text(p.window_m) +
          " m" +
          (reach_m > 0 ? " (the ground is seen up to " + fixed_text(reach_m, 0) + " m away)"
                       : std::string()) +
          ": set window_m to " + enough_window(s, p)};
}

std::optional<Hint> little_seen(const Figures&, const Parameters& p, double known_share)
{
  if (!(known_share < kSeen)) return {};
  return Hint{
      Kind::LittleSeen, "only " + percent(known_share) + " of the window of " +
                            number_text(p.window_m) + " m was seen, in cells of " +
                            number_text(p.resolution_m) +
                            " m: set a smaller window_m or a larger resolution_m"};
}

Parameters with_body(const Figures& f, Parameters p)
{
  auto& boxes = p.body_boxes_m;
  for (const SensorFigures& s : f.sensors)
  {
    if (s.share(s.ground_m) <= kGroundShare)
      continue;  // nothing separates the body from the ground
    const auto more = s.body.boxes(s.ground(), s.sensor);
    boxes.insert(boxes.end(), more.begin(), more.end());
  }
  boxes.resize(std::min(boxes.size(), kMaxBodyBoxes));
  return p;
}

std::optional<Hint> own_body(const Figures& f, const Parameters& p)
{
  const Parameters with = with_body(f, p);
  if (with.body_boxes_m.size() == p.body_boxes_m.size()) return {};
  return Hint{
      Kind::OwnBody, "points move with the robot, its own body: set body_boxes_m = " +
                         parameter_text(with, *find_parameter("body_boxes_m"))};
}

std::optional<Hint> nothing_seen_ahead(const Figures& f, const Parameters& p)
{
  const auto ray = highest_ray(f);
  const auto unseen = ray ? unseen_ahead(*ray, p.clearance_m) : std::nullopt;
  if (!unseen) return {};
  return Hint{Kind::UnseenAhead, *unseen};
}

std::vector<Hint> judge(const Figures& f, const Parameters& p, double known_share)
{
  std::vector<Hint> hints;
  const auto take = [&](std::optional<Hint> hint)
  {
    if (hint) hints.push_back(*std::move(hint));
    return !hints.empty();
  };
  // Where a frame is wrong, all else follows from it.
  if (take(upside_down(f)) || take(tilted_ground(f)) || take(sensor_in_ground(f)) ||
      take(two_grounds(f)) || take(wrong_mounting(f)))
    return hints;
  if (!take(wrong_axes(f))) take(sideways(f));
  if (!hints.empty()) return hints;
  if (!take(pose_jumps(f)) && !take(level_poses(f)) && !take(wrong_times(f)))
    take(contradiction(f));
  const std::size_t frames_wrong = hints.size();
  take(height_band(f, p));
  if (hints.size() == frames_wrong) take(window_too_small(f, p, known_share));
  if (hints.size() == frames_wrong) take(little_seen(f, p, known_share));
  take(own_body(f, p));
  take(nothing_seen_ahead(f, p));
  return hints;
}

}  // namespace talus::hints
