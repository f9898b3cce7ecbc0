#pragma once
#include "kernels/platform.h"

namespace talus::kernels
{
/** talus::Parameters for the kernels: as float, squared, in cells. Constant over the life of a map.
 */
struct Config
{
  int cells;  //!< n: the window has n x n cells
  float resolution_m, inverse_resolution;
  float min_range2_m2, max_range2_m2, min_height_m, max_height_m;
  float inverse_voxel;  //!< 0: no voxel filter
  float c_beam_m, a_beam;
  float gate2, min_variance_m2, clearance_m;
  float cleanup_margin_m;
  int cleanup_frames;
  float start_radius_m;  //!< the largest one if automatic
  int start_automatic;
  int object_radius;  //!< half of object_size_m, in pairs of cells
  float max_slope;  //!< tangent of the slope threshold
  float fill_search_m, inverse_fill_kernel, fill_variance_per_m;
  int fill_samples;
  int feature_radius_cells;
  float inverse_slope_threshold, step_threshold_m, inverse_step_threshold,
      inverse_roughness_threshold;
  float weight_slope, weight_step, weight_roughness;
  float sparsity_range_m, sparsity_distance_m, sparsity_search_m;
#if defined(TALUS_RULE_SWITCHES)
  std::uint64_t rules_off;  //!< bit r: rule r does not count, see rule_switches.h
#endif
};

constexpr int kMostBodyBoxes = 32;

/** The robot's own body: boxes in the frame of its base [m], borders included; constant. */
struct Body
{
  int boxes;
  float min_m[kMostBodyBoxes][3], max_m[kMostBodyBoxes][3];
};

}  // namespace talus::kernels
