#pragma once
#include <talus/baselines/window_cells.h>

#include <limits>
#include <map>

namespace talus::baselines
{
/** A cell of the paper's map. */
struct PaperCell
{
  /** Map frame, NaN: unknown. A filled cell has a ground only. */
  float elevation_m = std::numeric_limits<float>::quiet_NaN();
  float ground_m = std::numeric_limits<float>::quiet_NaN();
  /** One of both surfaces: the latest that was updated. NaN: never measured. */
  float variance_m2 = std::numeric_limits<float>::quiet_NaN();
  CellState state = CellState::Unknown;  //!< where the ground comes from

  bool stands() const { return elevation_m == elevation_m; }
  bool has_ground() const { return ground_m == ground_m; }
};
using PaperCells = RollingCells<PaperCell>;

/** The method of Xie et al., "Real-time elevation mapping with Bayesian ground filling and
 * traversability analysis for UGV navigation", section III as it is printed: plain code on one
 * thread, points in the order of the frame, to see what talus gained where. Where the text is open:
 * - a fill has no variance; the first point in its cell lends it its own. What is hit higher than
 * its gate stands on it, even where the fill was too low (Fig. 3, middle);
 * - the gap of Fig. 3, right, is looked for among the frame's points and the stored elevation;
 * - the line search goes on behind the sensor; the cell under the sensor lies on no line;
 * - dense (eq. 14) is a quarter of the neighbourhood measured, near is sparsity_range_m;
 * - the variance has a floor, min_variance_m2, as in the other maps.
 * Parameters that the paper has no word for (object_size_m, cleanup_*, ...) do nothing here. */
class PaperMap : public Method
{
 public:
  explicit PaperMap(const Parameters& parameters) : parameters_(parameters) {}
  void update(const Frame& frame) override;
  Surfaces read() override;

 private:
  /** A point with its cell and its variance (section III-A). */
  struct Hit
  {
    int cell;
    float z_m, variance_m2;
  };
  using CellHits = std::vector<Hit>::const_iterator;  //!< of one cell, in the order of the frame

  double pose_change_sine(const Frame& frame);
  std::vector<Hit> hits_of(const Frame& frame);
  void update_cells(const std::vector<Hit>& hits);
  void update_cell(PaperCell& cell, CellHits begin, CellHits end) const;
  bool fuse(float& height_m, PaperCell& cell, const Hit& hit, bool keeps_higher) const;
  float lowest_hanging_m(const PaperCell& cell, CellHits begin, CellHits end) const;
  void clean_up(const Pose& T_map_sensor, const std::vector<Hit>& hits);
  void fill(const Pose& T_map_sensor, CellState state);

  Parameters parameters_;
  PaperCells cells_;
  Pose T_map_sensor_;
  std::map<std::uint32_t, Pose> last_pose_;  //!< by sensor
};

/** What eq. 8 and 9 make of the measured ground along the line to the sensor. */
struct PaperFill
{
  float height_m;
  CellState state;  //!< Unknown: no sample on either side
};
PaperFill infer_as_printed(
    const PaperCells& cells, const Pose& T_map_sensor, int cell, const Parameters& parameters);

/** Traversability (eq. 10 to 13) and sparsity (eq. 14). */
void judge_as_printed(
    const PaperCells& cells, const Pose& T_map_sensor, const Parameters& parameters,
    Surfaces& surfaces);

}  // namespace talus::baselines
