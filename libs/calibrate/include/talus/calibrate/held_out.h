#pragma once
#include <talus/calibrate/associate.h>
#include <talus/calibrate/information.h>
#include <talus/calibrate/pose_track.h>
#include <talus/calibrate/scan_set.h>

#include <cstddef>
#include <vector>

namespace talus::calibrate
{
/** How thick the ground is at some ranges. */
struct RangeBin
{
  double from_m = 0, to_m = 0;
  std::size_t points = 0;
  double thickness_m = 0;  //!< robust standard deviation of the distance from the ground
  double offset_m = 0;  //!< median distance: a tilted sensor sees far ground too high or too low
};

/** How well frames that had no part in the fit agree with the ground that the other frames show. */
struct HeldOutFigures
{
  std::size_t points = 0;
  double thickness_m = 0;  //!< robust standard deviation about zero
  double p95_m = 0;  //!< of the absolute distance
  std::vector<RangeBin> by_range;
};

struct BeforeAfter
{
  HeldOutFigures before, after;
};

/** The figures of two estimates on the same points: those of the held-out frames that lie on
 * ground, of at least three of the other frames, in both maps. */
BeforeAfter held_out_figures(
    const ScanSet& scans, const PoseTrack& track, const Vector& before, const Vector& after);

/** Changes the chosen parameters and all planes of `a` until the robust sum of squares of all
 * residuals, points on planes and contacts, is least (Ceres, Levenberg-Marquardt; the planes are
 * eliminated by a Schur complement). Throws std::runtime_error when Ceres fails. */
Vector solve(
    const ScanSet& scans, const PoseTrack& track, const Vector& start, const Choice& chosen,
    Association& a);

/** For each of the chosen parameters: how far the estimates of the two halves of the frames lie
 * apart, over what their deviations allow; at least 1, and 1 for the others. */
Vector disagreement_of_halves(
    const ScanSet& scans, const PoseTrack& track, const Vector& v, const Choice& chosen,
    const Association& a);

/** The robot stands on the ground, so the ground around it is on average parallel to its base and
 * `base_height_m` below it. Turns the mounting in roll and pitch and lifts it until that holds for
 * the median frame: right to about a degree whatever was given. Throws std::runtime_error that says
 * what to do where the ground is above the sensor. */
Vector level_mounting(const ScanSet& scans, const Vector& given);

/** Throws std::runtime_error that says what to do where the ground leans by more than 10 degrees
 * under the robot in the median frame: what the log does not show was given wrong. */
void require_level_ground(const ScanSet& scans, const Vector& v);

/** The same mounting with half a turn of roll more. */
Vector rolled_over(Vector v);

/** Whether the ground is where the robot stands if the sensor is rolled over, and not if it is
 * mounted as given. `rolled_scans` has the points that may be ground then. */
bool is_upside_down(const ScanSet& scans, const ScanSet& rolled_scans, const Vector& given);

}  // namespace talus::calibrate
