#pragma once
#include <talus/channels.h>

#include <cstddef>
#include <string>
#include <vector>

namespace talus
{
/** Max cells along a side: indices of cells have 32 bits, resident layers take below 16 GB. */
constexpr int kMaxCellsASide = 16384;

constexpr std::size_t kMaxBodyBoxes = 32;  //!< max boxes of the robot's body

/** A box of the robot's own body, in the frame of its base [m]. */
struct BodyBox
{
  /** Limits of the box: x ahead, y left, z up from the ground under the robot. */
  double min_x_m, max_x_m, min_y_m, max_y_m, min_z_m, max_z_m;
};

// Each parameter once, in the order of the pipeline, which is that of help and pages:
// NUMBER(type, name, default, unit, min, max, meaning) and TEXT(type, name, to_text, from_text,
// unit, meaning).
// clang-format off
#define TALUS_PARAMETERS(NUMBER, TEXT) \
  /* the window */ \
  NUMBER(double, resolution_m, 0.05, "m", 1e-3, 100, "side of a cell") \
  NUMBER(double, window_m, 8.0, "m", 1e-2, 1e6, "side of the square window around the robot's base") \
  /* stage 1: which points are accepted */ \
  NUMBER(double, min_range_m, 0.2, "m", 1e-3, 1e6, "points nearer than this are dropped") \
  NUMBER(double, max_range_m, 100.0, "m", 1e-2, 1e6, "points farther than this are dropped") \
  NUMBER(double, min_height_m, -3.0, "m", -1e6, 1e6, "lowest accepted height above the sensor, along the map's z") \
  NUMBER(double, max_height_m, 1.5, "m", -1e6, 1e6, "highest accepted height above the sensor, along the map's z") \
  TEXT(std::vector<BodyBox>, body_boxes_m, boxes_text, boxes_from, "m", \
      "robot's own body in the frame of its base, whose points are dropped: none, or up to 32 boxes 'x_min x_max " \
      "y_min y_max z_min z_max', a comma between two") \
  NUMBER(double, voxel_m, 0.0, "m", 0, 100, "keep one point a voxel of this size in each frame; 0 keeps all") \
  /* stage 1: uncertainty of a point (eq. 2-4) */ \
  NUMBER(double, c_beam_m, 0.01, "m", 1e-4, 10, \
      "standard deviation of a point at range zero (eq. 3 of the sensor model)") \
  NUMBER(double, a_beam, 0.001, "m/m", 0, 1, "growth of that standard deviation with range") \
  NUMBER(double, lambda_t, 1.0, "", 0, 1000, "weight of the pose change in a point's variance (eq. 4)") \
  /* stage 3: update */ \
  NUMBER(double, mahalanobis_gate, 3.0, "", 0.1, 100, \
      "points farther than this many standard deviations are not fused") \
  NUMBER(double, min_variance_m2, 1e-6, "m^2", 1e-10, 1, "floor of the variance of a fused height") \
  NUMBER(double, clearance_m, 0.6, "m", 1e-2, 100, \
      "height the robot needs; what hangs higher above the ground is passable") \
  /* stage 5: visibility cleanup */ \
  NUMBER(double, cleanup_margin_m, 0.05, "m", 0, 10, "a surface is seen through when a ray passed this far below it") \
  NUMBER(int, cleanup_frames, 2, "", 1, 100, "consecutive frames that must see through a cell before it is cleared") \
  /* stage 4: the start */ \
  NUMBER(double, start_radius_m, -1, "m", -1, 1000, \
      "ground so far around where the robot starts is presumed to be that under its base; below 0: what the first " \
      "frame leaves blind, up to 3 m; 0: none") \
  /* stages 4 and 6: filling */ \
  NUMBER(double, object_size_m, 1.0, "m", 2e-3, 6500, \
      "measured ground narrower than this that stands out steeply is an object; 2 to 65 cells") \
  NUMBER(double, fill_search_m, 2.0, "m", 0, 1000, "how far to look for measured ground, each way along the ray") \
  NUMBER(double, fill_kernel_m, 2.0, "m", 1e-3, 1000, "support of the sparse kernel (eq. 8)") \
  NUMBER(int, fill_samples, 2, "", 1, 16, "measured cells taken on each side") \
  NUMBER(double, fill_variance_per_m, 0.1, "m/m", 0, 10, \
      "growth of a fill's standard deviation with the distance to its sample") \
  /* stage 7: traversability (eq. 10-13) */ \
  NUMBER(double, feature_radius_m, 0.1, "m", 1e-3, 100, \
      "half side of the neighbourhood of slope, step and roughness; at most 15 cells") \
  NUMBER(double, slope_threshold_rad, 0.6, "rad", 1e-3, 1.55, "slope that is impassable (eq. 10)") \
  NUMBER(double, step_threshold_m, 0.2, "m", 1e-3, 100, "step that is impassable (eq. 11)") \
  NUMBER(double, roughness_threshold_m, 0.2, "m", 1e-3, 100, "roughness that is impassable (eq. 12)") \
  NUMBER(double, weight_slope, 0.4, "", 0, 1, "weight of the slope (eq. 13)") \
  NUMBER(double, weight_step, 0.3, "", 0, 1, "weight of the step (eq. 13)") \
  NUMBER(double, weight_roughness, 0.3, "", 0, 1, "weight of the roughness (eq. 13)") \
  /* stage 7: sparsity (eq. 14) */ \
  NUMBER(double, sparsity_range_m, 4.0, "m", 0, 1e6, "fills nearer than this may drop") \
  NUMBER(double, sparsity_distance_m, 2.0, "m", 1e-2, 1e6, "distance threshold d_c (eq. 14)") \
  NUMBER(double, sparsity_search_m, 4.0, "m", 0, 1000, "how far to look for ground on the other side (eq. 14)") \
  /* channels */ \
  TEXT(std::vector<Channel>, channels, channels_text, channels_from, "", \
      "values of points that become layers: none, or up to four 'name:rule', a comma between two; the rule is " \
      "mean, latest, max or vote") \
  TEXT(std::vector<ChannelCost>, channel_cost, channel_costs_text, channel_costs_from, "", \
      "the most that cells of a class of a vote get as traversability, 0: impassable: none, or " \
      "'name:class=score,class=score'")
// clang-format on

/** Everything that can be tuned, in SI units; doc/parameters.md lists it, INI files, `--help` and
 * summary.json are made of the table above. Defaults are the paper's, unless doc/concepts.md says
 * why not. Without the sensor's pose on the robot the base of body_boxes_m is the sensor. */
struct Parameters
{
#define TALUS_NUMBER(type, name, value, unit, min, max, meaning) type name = value;
#define TALUS_TEXT(type, name, to_text, from_text, unit, meaning) type name{};
  TALUS_PARAMETERS(TALUS_NUMBER, TALUS_TEXT)
#undef TALUS_NUMBER
#undef TALUS_TEXT

  /** The number of cells along one side of the window. */
  int cells() const;

  /** Throws std::invalid_argument that names the first parameter out of range, value and range. */
  void validate() const;
};

/** One parameter of the table: a number, unless is_text(); then min, max are 0, get, set null. */
struct ParameterInfo
{
  const char* name;  //!< name in files and on command lines
  const char* unit;  //!< "m", "rad", "m^2", "" for pure numbers
  /** allowed range, limits included */
  double min, max;
  const char* description;  //!< a short description, for help and pages
  /** Reads the value; null for a text. */
  double (*get)(const Parameters&) = nullptr;
  void (*set)(Parameters&, double) = nullptr;  //!< without a check; set_parameter() checks
  bool is_integer = false;  //!< whether it is a whole number
  std::string (*get_text)(const Parameters&) = nullptr;  //!< with all digits
  /** Throws std::invalid_argument that says what is wrong with a text. */
  void (*set_text)(Parameters&, const std::string&) = nullptr;

  /** Whether it is a text, for get_text and set_text. */
  bool is_text() const { return get_text != nullptr; }
};

/** All parameters, in the order of the pipeline. */
const std::vector<ParameterInfo>& parameter_table();

/** The parameter of that name (case ignored), or nullptr. */
const ParameterInfo* find_parameter(const std::string& name);

/** Whether a parameter has the same value in both, to the last bit. */
bool is_same_value(const ParameterInfo& info, const Parameters& a, const Parameters& b);

/** The name nearest to a misspelt one by edit distance, with or without its unit; empty if that is
 * more than a third of the length (more than 1 for a short word). */
std::string nearest_name(const std::string& name, const std::vector<std::string>& names);
/** nearest_name() among all parameters. */
std::string nearest_parameter_name(const std::string& name);

/** Sets the value that a text gives. Throws std::invalid_argument with what is allowed. */
void set_parameter(Parameters& p, const std::string& name, const std::string& text);

/** Sets a number. Throws std::invalid_argument with the allowed range, also for NaN. */
void set_parameter(Parameters& p, const ParameterInfo& info, double value);

/** The text that set_parameter() reads back. */
std::string parameter_text(const Parameters& p, const ParameterInfo& info);

/** The environment variable that names the rules that are left out of maps, such as "27,30". Only a
 * build with -DTALUS_RULE_SWITCHES=ON looks at it. */
constexpr const char* kWithoutRulesVariable = "TALUS_WITHOUT_RULES";

/** The rules (kernels/rules.md) that such a build can leave out, in rising order; else empty. */
std::vector<int> switchable_rules();

}  // namespace talus
