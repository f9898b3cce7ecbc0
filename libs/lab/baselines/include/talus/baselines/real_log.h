#pragma once
#include <talus/baselines/evaluate.h>
#include <talus/io/layer_stack.h>

#include <cstdint>
#include <vector>

namespace talus::baselines
{
/** What people say of a point. */
enum class GroundTruth : std::uint8_t
{
  NotScored,
  Ground,
  Other
};

/** Labels of real scans, by the cell: a GeoTIFF with the bands `ground` (mean height of the points
 * that people labelled as ground, map frame; NaN: none) and `label`. */
struct LabelMap
{
  enum Label
  {
    kNotKnown = 0,
    kGround = 1,  //!< ground points only
    kObstacle = 2,  //!< a point of something 0.3 to 1.8 m above the ground beside it
    kVegetation = 3,  //!< the same of vegetation only
    kLow = 4,  //!< a point of an obstacle 0.1 to 0.3 m up, and of none higher
    kMoves = 5  //!< a point of something that moves through the cell in one of the scans
  };
  io::LayerStack stack;

  /** Whether a file holds such labels, and no truth of talus-sim. */
  static bool is_one(const io::LayerStack& stack);
  /** The cell of (x, y), or -1 outside. */
  std::ptrdiff_t cell_at(double x_m, double y_m) const;
  float ground_m(std::ptrdiff_t cell) const;
  int label(std::ptrdiff_t cell) const;
  /** Of a point of the map frame [m]: ground is what lies within 0.15 m of the ground of its cell.
   * What is not on the ground of a cell of vegetation may be a lawn, and is not scored, nor is what
   * lies in a cell without a label. */
  GroundTruth truth_of(double x_m, double y_m, float z_m) const;
};

/** How a map did on a real log, by its window after the last frame. Points are those that pass
 * range and height band. */
struct RealLogScore
{
  std::string method;

  /// @name Against labels, see LabelMap::truth_of(). A point is on the map's ground if it lies
  /// within 0.15 m of it
  /// @{
  Share precision;  //!< of points on the map's ground: on the ground that was labelled
  Share recall;  //!< of points on the ground that was labelled: on the map's
  Share obstacle_blocked;  //!< of cells labelled kObstacle
  Share low_blocked;  //!< of cells labelled kLow that were hit higher up than the step threshold
  Share ground_passable;  //!< of cells labelled kGround that do not touch an obstacle
  /** Of cells labelled kMoves that were hit 0.3 to 1.8 m up, and afterwards in 5 or more frames
   * only near the ground: blocked all the same. */
  Share left_blocked;
  Share swept_blocked;  //!< of cells labelled kMoves: in the site of the whole drive, of talus only
  /// @}

  Share unjudged;  //!< of cells with a ground: without a traversability
  Share two_sided_unjudged;  //!< the same of those filled from two sides

  /** 2 P R / (P + R). */
  double f1() const;
};

/** One score a method of `evaluation`, which is that of this log without truth. `labels` may be
 * nullptr. */
std::vector<RealLogScore> score_real_log(
    const Sequence& sequence, const Evaluation& evaluation, const LabelMap* labels,
    const Parameters& parameters);

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

/** Ground points are held out of a log without truth, to be predicted by the fills.
 *
 * The points of each scan are sorted into 64 bands of equal elevation angle in the sensor
 * frame, from the 1st to the 99th percentile; every fourth band that has points is kept from the
 * map. The first three frames only fill it. Of what is held out, the lowest point of each cell is
 * predicted, if it is sure to be ground: no point of the log lies more than 0.3 m above it, and
 * nowhere within 3 m does the ground of the log (the second lowest of what its frames saw in a
 * cell, held out or not) lie below a cone of slope 0.3 that begins 0.1 m below it. Cells with
 * measured ground in the map are left out, since nothing is filled there.
 *
 * The held-out beams also make a map of their own. Where it measured such ground, and nothing
 * stands higher than half a step within two cells, the heights of both maps are compared with the
 * variances of both. What all beams share does not show: errors of poses, reflections of a wet
 * floor. */
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
    const Sequence& sequence, const EvaluationOptions& options, const LabelMap* labels);

}  // namespace talus::baselines
