#pragma once
#include <talus/hints/highest_ray.h>
#include <talus/hints/hint.h>

#include <optional>
#include <vector>

#include "figures.h"

namespace talus::hints
{
/** See HintFinder::find(). */
std::vector<Hint> judge(const Figures& figures, const Parameters& parameters, double known_share);

/** With boxes around what moves with the robot beside those that are known. */
Parameters with_body(const Figures& f, Parameters p);

/** Of all sensors the highest ray ahead, where a drive shows it for certain. */
std::optional<HighestRay> highest_ray(const Figures& f);

/// @name One cause each; nothing where it is not certain
/// @{
std::optional<Hint> wrong_axes(const Figures& f);
std::optional<Hint> sideways(const Figures& f);
std::optional<Hint> pose_jumps(const Figures& f);
std::optional<Hint> upside_down(const Figures& f);
std::optional<Hint> tilted_ground(const Figures& f);
std::optional<Hint> sensor_in_ground(const Figures& f);
std::optional<Hint> two_grounds(const Figures& f);
std::optional<Hint> wrong_mounting(const Figures& f);
std::optional<Hint> level_poses(const Figures& f);
std::optional<Hint> wrong_times(const Figures& f);
std::optional<Hint> contradiction(const Figures& f);
std::optional<Hint> height_band(const Figures& f, const Parameters& p);
std::optional<Hint> window_too_small(const Figures& f, const Parameters& p, double known_share);
std::optional<Hint> little_seen(const Figures& f, const Parameters& p, double known_share);
std::optional<Hint> own_body(const Figures& f, const Parameters& p);
std::optional<Hint> nothing_seen_ahead(const Figures& f, const Parameters& p);
/// @}

/** Adds to `spreads_m` the deviation of the heights in each small cell of ground that one frame hit
 * often. `points`: all within reach, in the frame of the base. */
void note_spreads(const std::vector<Vec3>& points, const NearPlane& ground, Values& spreads_m);

}  // namespace talus::hints
