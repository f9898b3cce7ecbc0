#pragma once
#include <talus/baselines/real_log.h>

#include <cstdint>
#include <vector>

namespace talus::baselines
{
/** By a label of SemanticKITTI, as the protocol of Patchwork++ has it (Lee et al., 2022): ground is
 * road, parking, sidewalk, other ground, lane marking and terrain; vegetation, what has no label
 * and outliers are not scored. The upper 16 bits, which number objects, do not count. */
GroundTruth ground_truth_of(std::uint32_t semantic_kitti_label);

/** By the labels of cells, for each point of a scan. */
std::vector<GroundTruth> ground_truth_of(const ScanFrame& scan, const LabelMap& labels);

/** How rightly points are said to be ground, by the labels of talus::label_points(). All other
 * labels say that a point is not. */
struct LabelScore
{
  bool alone = false;  //!< each scan by a map of its own, without a past
  /** From the sensor, seen from above [m]; infinity: in the whole window. */
  double within_m = 0;
  int scans = 0;  //!< those with ground, of truth and as said
  std::uint64_t points = 0;  //!< that are scored
  /** Means of the scans, as the public tables have them; NaN: there is none. */
  double precision = 0, recall = 0, f1 = 0;
};

/** Within 12 m, within 40 m if the window goes so far, and in the whole window: by the map of all
 * scans so far, each scan right after it, and, where there are several, by each one alone. `truth`
 * has a value for each point of each scan. */
std::vector<LabelScore> score_labels(
    const Sequence& sequence, const std::vector<std::vector<GroundTruth>>& truth,
    const Parameters& parameters, Backend backend);

}  // namespace talus::baselines
