#pragma once
#include "kernels/math.h"

namespace talus::kernels
{
/** Those of talus::Parameters that the kernels take as they are. */
#define TALUS_TAKEN_PARAMETERS(FIELD) \
  FIELD(float, resolution_m)          \
  FIELD(float, min_height_m)          \
  FIELD(float, max_height_m)          \
  FIELD(float, c_beam_m)              \
  FIELD(float, a_beam)                \
  FIELD(float, min_variance_m2)       \
  FIELD(float, clearance_m)           \
  FIELD(float, cleanup_margin_m)      \
  FIELD(int, cleanup_frames)          \
  FIELD(float, fill_search_m)         \
  FIELD(float, fill_variance_per_m)   \
  FIELD(int, fill_samples)            \
  FIELD(float, step_threshold_m)      \
  FIELD(float, weight_slope)          \
  FIELD(float, weight_step)           \
  FIELD(float, weight_roughness)      \
  FIELD(float, sparsity_range_m)      \
  FIELD(float, sparsity_distance_m)   \
  FIELD(float, sparsity_search_m)

/** talus::Parameters for the kernels: as float, squared, in cells. Constant for a map. */
struct Config
{
#define TALUS_MEMBER(type, name) type name;
  TALUS_TAKEN_PARAMETERS(TALUS_MEMBER)
#undef TALUS_MEMBER
  int cells;  //!< n: the window has n x n cells
  float inverse_resolution;
  float min_range2_m2, max_range2_m2;
  float inverse_voxel;  //!< 0: no voxel filter
  float gate2;
  float start_radius_m;  //!< the largest one if automatic
  int start_automatic;
  int object_radius;  //!< half of object_size_m, in pairs of cells
  float max_slope;  //!< tangent of the slope threshold
  float inverse_fill_kernel;
  int feature_radius_cells;
  float inverse_slope_threshold, inverse_step_threshold, inverse_roughness_threshold;
#if defined(TALUS_RULE_SWITCHES)
  std::uint64_t rules_off;  //!< bit r: rule r does not count, see rule_switches.h
#endif
};

constexpr int kMaxBodyBoxes = 32;

/** The robot's own body: boxes in the frame of its base [m], borders included; constant. */
struct Body
{
  int boxes;
  float min_m[kMaxBodyBoxes][3], max_m[kMaxBodyBoxes][3];
};

}  // namespace talus::kernels
