#pragma once
#include <talus/calibrate/associate.h>

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

}  // namespace talus::calibrate
