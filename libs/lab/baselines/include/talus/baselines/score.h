#pragma once
#include <talus/baselines/truth_map.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace talus::baselines
{
/** A share of cells; NaN when there are none. */
struct Share
{
  double part = 0, of = 0;
  void add(bool counts) { part += counts ? 1 : 0, of += 1; }
  void add(const Share& other) { part += other.part, of += other.of; }
  double value() const;
};

/** Absolute errors [m], one a cell and evaluated frame. */
struct Errors
{
  std::vector<float> abs_m;
  void add(float error_m) { abs_m.push_back(error_m < 0 ? -error_m : error_m); }
  void add(const Errors& other)
  {
    abs_m.insert(abs_m.end(), other.abs_m.begin(), other.abs_m.end());
  }
  std::size_t count() const { return abs_m.size(); }
  /** NaN when empty. */
  double rmse_m() const;
  double quantile_m(double q) const;
};

/** Errors of heights beside the standard deviations that a map estimates for them. */
struct EstimateErrors
{
  std::vector<float> abs_m, estimated_m;  //!< the error and the estimated deviation, one a height

  /** Leaves out a height without a variance. */
  void add(float error_m, float variance_m2);
  void add(const EstimateErrors& other);
  std::size_t count() const { return abs_m.size(); }
  /** Share of the heights whose error is at most `deviations` estimated ones; NaN when empty. */
  double within(double deviations) const;
  /** Share of the heights within the deviations that hold `probability` of a normal distribution;
   * NaN when empty. True bars give `probability`, in (0, 1), back. */
  double share_within(double probability) const;
  double median_estimated_m() const;  //!< NaN when empty
  double true_m() const;  //!< what 68 % of the errors do not exceed; NaN when empty
};

/** Where heights come from: the states of a cell but the unknown one. */
constexpr int kHeightKinds = 4;
/** Names in files, in the order of CellState from Measured on. */
constexpr const char* kHeightKindNames[kHeightKinds] = {
    "measured", "two_sided", "one_sided", "presumed"};

/** The same for each kind of height, near to the robot and far from it. */
class HeightBars
{
 public:
  /** Adds the ground of cell `k` of a map with variances; `error_m` may have a sign. Nothing
   * is known of an unknown cell: it is left out. `reference_m2` is the variance of what the height
   * is compared with [m^2]. Near is within a quarter of the window's side around its middle. */
  void add(const Surfaces& map, std::size_t k, float error_m, float reference_m2 = 0);
  void add(const HeightBars& other);

  const EstimateErrors& near(int kind) const { return of_[kind][0]; }
  const EstimateErrors& far(int kind) const { return of_[kind][1]; }
  EstimateErrors all(int kind) const;
  bool empty() const;

 private:
  std::array<std::array<EstimateErrors, 2>, kHeightKinds> of_;
};

constexpr int kRings = 10, kTenths = 10;

/** How one map did in one world. Cells of all evaluated frames are pooled. Cells are those of the
 * window; all but `reach`, `leak` and `beyond` leave out cells where a mover is or was.
 *
 * "Hit" means: since the cell came into the window, a point inside range and height band fell into
 * it; on the ground: within 5 cm of it; on an obstacle: Observed::shows_obstacle(). Obstacles: see
 * TruthMap::truth_options(); those within 5 cm of the step threshold count neither as obstacle nor
 * as free. */
struct Score
{
  std::string method;

  /// @name Heights, on cells that are really free
  /// @{
  /** |ground - truth| of measured cells two or more cells away from obstacles, by terrain. */
  std::array<Errors, kTerrainCount> measured_ground;
  /** The same where the ground was hit. Elsewhere an object was taken for it. */
  std::array<Errors, kTerrainCount> measured_ground_hit;
  Errors measured_elevation;  //!< the same of the elevation, all terrain
  Errors two_sided_seen;  //!< fills from two sides, where a ray of the scanner could have met the
                          //!< ground in some frame so far
  Errors two_sided_unseen, one_sided;
  Errors presumed_ground;  //!< where the robot stood, or started
  /** Of cells in tenths of the risk that the map estimates, without those that it says to be
   * impassable: those that are. Without platforms and what may be judged either way. */
  std::array<Share, kTenths> risky;
  /** The errors of all of these heights beside the variances that the map estimates for them; empty
   * for methods without. */
  HeightBars bars;
  /// @}

  /// @name Coverage, of all cells of the window
  /// @{
  Share measured, filled_two_sided, filled_one_sided, presumed, unknown;
  /// @}

  /// @name Hanging objects: free cells below something that leaves more than the clearance, two or
  /// more cells from obstacles
  /// @{
  Share hanging_wrong;  //!< of known ones: elevation or ground off by more than 0.2 m
  Share hanging_wrong_seen;  //!< the same of those whose ground a ray could have met so far
  Share hanging_passable;  //!< of known ones whose ground a ray could have met so far
  /// @}

  /// @name Obstacles and free space
  /// @{
  Share obstacle_blocked;  //!< of obstacle cells that were hit: blocked
  Share obstacle_blocked_whole;  //!< the same of cells that the obstacle covers whole
  Share free_passable;  //!< of free cells whose ground was hit, two or more cells away from
                        //!< obstacles: passable
  Share free_passable_all;  //!< the same with those next to obstacles
  /** Of free cells whose ground was hit, at 1, 2, ... cells from the nearest obstacle, which is
   * an upright object that was hit: blocked. */
  std::array<Share, kRings> ring_blocked;
  Share posts;  //!< of thin upright things (at most 5 x 5 cells) that were hit: still blocked, in
                //!< the cells around them included
  /** Of ditch cells within 4 m of the sensor: not shown as passable ground more than 0.2 m above
   * the truth (unless sparsity is below 0.5). */
  Share ditch_found;
  /// @}

  /// @name Paths: what a flood over passable cells reaches from within 0.35 m of the robot
  /// (4-connected)
  /// @{
  Share leak;  //!< of obstacle cells that have obstacle cells all around: reached
  Share leak_hit;  //!< the same of those that were hit themselves
  Share reach;  //!< of free cells that are truly reachable: reached
  Share reach_seen;  //!< the same of those to which a path leads over ground that rays could have
                     //!< met so far, two or more cells away from obstacles
  Share beyond;  //!< of free cells that are truly not reachable: reached
  /// @}

  /// @name Movers
  /// @{
  /** Of cells where a mover was hit and left: passable at the latest 5 frames after rays showed
   * that, see MoverTruth. */
  Share mover_freed;
  Errors residue_frames;  //!< frames from then until passable (abs_m holds frames)
  /// @}

  /// @name Cost
  /// @{
  std::vector<double> update_ms;  //!< one a frame
  std::vector<double> read_ms;  //!< what is computed on demand: columns, features
  double memory_mb = 0;  //!< heap that the map holds after the last frame
  /// @}

  /** Counts a cell of the window by where its ground comes from. */
  void cover(CellState state);
  /** Largest distance up to which more than 5 % of a ring of 20 cells or more are blocked; NaN
   * without rings. */
  double inflation_cells() const;
  Errors all_measured_ground() const;
  /** Pools the cells and frames of another world; the memory is the larger one. */
  void add(const Score& other);
};

/** Every figure by name, in the order of tables and files; NaN: not applicable. Errors give
 * `..._rmse_m`, `..._p95_m` and `..._n`. */
using Figures = std::vector<std::pair<std::string, double>>;
Figures figures(const Score& score);

/** How one fill did, on the same cells as all others: those that talus filled and every other
 * fill, too, has a value for; free cells without movers. */
struct FillScore
{
  std::string fill;
  Errors all, two_sided, one_sided;
  Errors seen;  //!< where a ray of the scanner could have met the ground so far; what lies behind
                //!< walls nobody can know
  Share coverage;  //!< of cells without measured ground: has a value
  std::vector<double> ms;  //!< one an evaluated frame; empty for talus (part of its update)

  void add(const FillScore& other);
};
Figures figures(const FillScore& score);

}  // namespace talus::baselines
