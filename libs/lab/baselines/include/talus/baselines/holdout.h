#pragma once
#include <talus/baselines/evaluate.h>
#include <talus/baselines/real_log.h>

namespace talus::baselines
{
/** How ground points are held out of a log without truth, to be predicted by the fills.
 *
 * The points of each scan are sorted into `groups` bands of equal elevation angle in the sensor
 * frame, from the 1st to the 99th percentile; every `every`-th band that has points is kept from
 * the map. Of what is held out, the lowest point of each cell is predicted, if it is sure to be
 * ground: no point of the log lies more than 0.3 m above it, and nowhere within 3 m does the ground
 * of the log (the second lowest of what its frames saw in a cell, held out or not) lie below a cone
 * of slope 0.3 that begins 0.1 m below it. Cells with measured ground in the map are left out,
 * since nothing is filled there.
 *
 * The held-out beams also make a map of their own. Where it measured such ground, and nothing
 * stands higher than half a step within two cells, the heights of both maps are compared with the
 * variances of both. What all beams share does not show: errors of poses, reflections of a wet
 * floor. */
struct HoldOutOptions
{
  int every = 4;
  int groups = 64;
  int from_frame = 3;  //!< frames before this only fill the map
};

struct HoldOut
{
  std::string name, sensor;
  int frames = 0;
  std::vector<FillScore> fills;  //!< `all`, `two_sided` and `one_sided` on the same cells for every
                                 //!< fill; talus's first
  Share not_ground;  //!< of what they predict and people labelled, see LabelMap::truth_of()
  HeightBars bars;  //!< of talus, measured ground included
};

/** `labels` may be nullptr. */
HoldOut hold_out(
    const Sequence& sequence, const EvaluationOptions& options, const HoldOutOptions& holdout,
    const LabelMap* labels);

}  // namespace talus::baselines
