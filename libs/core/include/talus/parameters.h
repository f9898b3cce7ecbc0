#pragma once
#include <talus/channels.h>

#include <cstddef>
#include <string>
#include <vector>

namespace talus
{
/** Most cells along a side of the window: indices of cells stay in 32 bits, the resident layers
 * below 16 GB. */
constexpr int kMostCellsASide = 16384;

/** Most boxes of the robot's body. */
constexpr std::size_t kMostBodyBoxes = 32;

/** A box of the robot's own body, in the frame of its base [m]. */
struct BodyBox
{
  /** Limits of the box: x ahead, y left, z up from the ground under the robot. */
  double min_x_m, max_x_m, min_y_m, max_y_m, min_z_m, max_z_m;
};

/** Everything that can be tuned, in SI units. Defaults are those of the paper where it gives any,
 * unless doc/concepts.md says why not.
 *
 * Names, ranges and descriptions live in parameters.cpp once; INI files, `--help`, summary.json and
 * doc/parameters.md are all made from there (see parameter_table()). */
struct Parameters
{
  /// @name Window
  /// @{
  double resolution_m = 0.05;  //!< side of a cell
  double window_m = 8.0;  //!< side of the square window around the robot's base
  /// @}

  /// @name Stage 1: which points are accepted
  /// @{
  /** Nearer points are dropped, zero-range returns among them [m]. */
  double min_range_m = 0.2;
  /** Farther points are dropped [m]. */
  double max_range_m = 100.0;
  double min_height_m = -3.0;  //!< lowest accepted height above the sensor, along the map's z
  double max_height_m = 1.5;  //!< highest
  /** The robot's own body, whose points are dropped: up to kMostBodyBoxes boxes. If a frame does
   * not give the sensor's pose on the robot, the base is the sensor. */
  std::vector<BodyBox> body_boxes_m{};
  double voxel_m = 0.0;  //!< keep one point of each voxel of this size in a frame; 0: keep all
  /// @}

  /// @name Stage 1: uncertainty of a point (eq. 2-4)
  /// @{
  double c_beam_m = 0.01;  //!< constant part of the sensor's standard deviation
  double a_beam = 0.001;  //!< its growth with range [m/m]
  double lambda_t = 1.0;  //!< weight of the pose change
  /// @}

  /// @name Stage 3: update
  /// @{
  double mahalanobis_gate =
      3.0;  //!< a point farther than this many standard deviations is not fused
  double min_variance_m2 = 1e-6;  //!< floor of the variance of a fused height
  double clearance_m =
      0.6;  //!< height that the robot needs: what hangs higher above the ground is passable
  /// @}

  /// @name Stage 5: visibility cleanup
  /// @{
  double cleanup_margin_m =
      0.05;  //!< a surface is seen through when a ray passed this far below it
  int cleanup_frames = 2;  //!< consecutive frames that must see through a cell before it is cleared
  /// @}

  /// @name Stage 4: the start
  /// @{
  /** In the first frame, unmeasured ground within this radius around the base is presumed to be the
   * plane of the base [m]; negative: the blind zone of that frame's rays, up to 3 m; 0: none. */
  double start_radius_m = -1;
  /// @}

  /// @name Stages 4 and 6: filling
  /// @{
  double object_size_m = 1.0;  //!< measured ground narrower than this that stands out steeply is an
                               //!< object; 2 to 65 cells, counted in steps of four
  double fill_search_m = 2.0;  //!< how far to look for measured ground, each way along the ray
  double fill_kernel_m = 2.0;  //!< support of the sparse kernel of eq. 8
  int fill_samples = 2;  //!< measured cells taken on each side
  double fill_variance_per_m =
      0.1;  //!< growth of the standard deviation of a fill with the distance to its sample
  /// @}

  /// @name Stage 7: traversability (eq. 10-13)
  /// @{
  double feature_radius_m = 0.1;  //!< half side of the square neighbourhood
  /** A steeper plane through the neighbourhood is impassable. */
  double slope_threshold_rad = 0.6;
  /** Ground that stands higher above the mean of its neighbourhood is impassable. */
  double step_threshold_m = 0.2;
  /** Elevation that is higher above the mean of its neighbourhood is impassable. */
  double roughness_threshold_m = 0.2;
  /** Weights of the three features in eq. 13. */
  double weight_slope = 0.4, weight_step = 0.3, weight_roughness = 0.3;
  /// @}

  /// @name Stage 7: sparsity (eq. 14)
  /// @{
  double sparsity_range_m = 4.0;  //!< fills nearer than this may drop
  double sparsity_distance_m =
      2.0;  //!< d_c: a height difference counts the more the nearer it is than this
  double sparsity_search_m = 4.0;  //!< how far to look for ground on the other side
  /// @}

  /// @name Channels
  /// @{
  std::vector<Channel> channels{};  //!< what frames bring to each point, see Frame::channels
  std::vector<ChannelCost> channel_cost{};  //!< classes that make cells impassable, or dear
  /// @}

  /** The number of cells along one side of the window. */
  int cells() const;

  /** Throws std::invalid_argument that names the first parameter out of its range, the value and
   * the range. */
  void validate() const;
};

/** One parameter of the table. It is a number, unless is_text(): then `min` and `max` are 0, `get`
 * and `set` null. */
struct ParameterInfo
{
  /** Name in files and on command lines. */
  const char* name;
  const char* unit;  //!< "m", "rad", "m^2", "" for pure numbers
  /** Allowed range, limits included. */
  double min, max;
  /** A short description, for help and pages. */
  const char* description;
  /** Reads the value; null for a text. */
  double (*get)(const Parameters&);
  void (*set)(Parameters&, double);  //!< without a check; set_parameter() checks
  bool is_integer;  //!< whether it is a whole number
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

/** The name nearest to a misspelt one by edit distance, with or without its unit, for error
 * messages; empty if the distance is more than a third of the length (more than 1 for a short
 * word). */
std::string nearest_name(const std::string& name, const std::vector<std::string>& names);
/** nearest_name() among all parameters. */
std::string nearest_parameter_name(const std::string& name);

/** Parses the text of a value (a number, boxes) and sets it. Throws std::invalid_argument naming
 * the parameter, the text, and what is allowed. */
void set_parameter(Parameters& p, const std::string& name, const std::string& text);

/** Sets a parameter to a number. Throws std::invalid_argument that names the parameter, the value
 * and the allowed range, also for NaN. */
void set_parameter(Parameters& p, const ParameterInfo& info, double value);

/** The text that set_parameter() reads back. */
std::string parameter_text(const Parameters& p, const ParameterInfo& info);

}  // namespace talus
