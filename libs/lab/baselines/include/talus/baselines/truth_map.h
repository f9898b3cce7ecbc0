#pragma once
#include <talus/baselines/method.h>
#include <talus/sim/truth.h>

#include <cstdint>
#include <vector>

namespace talus::baselines
{
/** What the ground is like, for errors by kind of terrain. */
enum class Terrain : std::uint8_t
{
  Flat = 0,
  Slope,  //!< a plane steeper than 2 degrees
  Rough,  //!< more than 3 mm RMS from a plane within 7 x 7 cells
  NearStep  //!< within 3 cells of where the surface jumps by more than 5 cm from cell to cell
};
constexpr int kTerrainCount = 4;
constexpr const char* kTerrainNames[kTerrainCount] = {"flat", "slope", "rough", "near_step"};

/** What is so near to a limit may be judged either way. */
constexpr float kDoubt_m = 0.05f;

/** The truth without movers over the whole area of a drive, and what follows from it. One entry a
 * cell of `window`, index = iy * cells_x + ix; distances are chessboard distances in cells, at
 * most 255. */
class TruthMap
{
 public:
  /** `truth` as sim::truth() gives it with truth_options() of the same parameters. */
  TruthMap(sim::Truth truth, const Parameters& parameters);

  /** What counts as an obstacle for a map with these parameters: the same clearance, slope and step
   * limits. */
  static sim::TruthOptions truth_options(const Parameters& parameters, bool movers);

  /** Index of a cell counted from the origin of the map frame, or -1 outside. */
  int index(std::int64_t cell_x, std::int64_t cell_y) const
  {
    const std::int64_t ix = cell_x - first_cell_x_, iy = cell_y - first_cell_y_;
    const bool inside =
        ix >= 0 && iy >= 0 && ix < truth.window.cells_x && iy < truth.window.cells_y;
    return inside ? static_cast<int>(iy * truth.window.cells_x + ix) : -1;
  }
  std::size_t size() const { return truth.ground.size(); }
  /** The middle of a cell [m]. */
  Middle middle(std::size_t i) const
  {
    const sim::TruthWindow& w = truth.window;
    const int at = static_cast<int>(i), x = at % w.cells_x, y = at / w.cells_x;
    return {w.min_x_m + (x + 0.5) * w.resolution_m, w.min_y_m + (y + 0.5) * w.resolution_m};
  }

  bool known(std::size_t i) const { return truth.label[i] == truth.label[i]; }
  bool free(std::size_t i) const { return truth.label[i] == 1.0f; }
  bool blocked(std::size_t i) const { return truth.label[i] == 0.0f; }
  /** Free, and a map that blocks it is wrong. */
  bool surely_free(std::size_t i) const { return free(i) && !doubtful[i]; }
  /** Two or more cells from obstacles and doubt: one cell of inflation is allowed. */
  bool clear(std::size_t i) const { return to_obstacle[i] >= 2; }
  /** Whether what makes the cell an obstacle is in all of it. */
  bool covered_whole(std::size_t i) const { return truth.covered[i] == 1.0f; }
  /** Distance [m] of a height from the ground or, where something low enough to be driven over
   * lies on it, from the nearer of the two. */
  float height_error_m(std::size_t i, float z_m) const;
  /** How high what stands here is [m]; 0: nothing. */
  float standing_m(std::size_t i) const;
  /** Height [m] of the ground or of what stands on it. */
  float surface_m(std::size_t i) const { return truth.ground[i] + standing_m(i); }

  sim::Truth truth;
  std::vector<Terrain> terrain;
  std::vector<std::uint8_t> to_obstacle;  //!< distance to the nearest blocked or doubtful cell
  std::vector<std::uint8_t> depth;  //!< of blocked cells: distance to the nearest free one, from 1
  std::vector<std::uint8_t> hangs;  //!< 1: free, and something hangs above the clearance
  /** 1: either is right. What stands there is within kDoubt_m of the step threshold, or what hangs
   * is less than that above the clearance; or it is an islet: ground more than a step above what is
   * around it, and less than a metre wide. A thing of that shape gives the same scans. */
  std::vector<std::uint8_t> doubtful;
  /** 1: on a solid, level top more than a metre wide, inside its outermost cells. A step in the
   * ground of that shape gives the same scans, and its top is free: what blocks is the edge. */
  std::vector<std::uint8_t> platform;
  std::vector<std::uint8_t> climbable;  //!< 1: platform with a path up, no step too high
  std::vector<std::uint8_t> vertical;  //!< 1: blocked by an object higher than the step threshold
  std::vector<std::uint8_t> ditch;  //!< 1: 0.3 m or more below what a 1.5 m wide board would span
  std::vector<int> post;  //!< number of the thin upright thing that stands here, or -1
  int posts = 0;

 private:
  void classify_cells(const Parameters& parameters);
  void classify_terrain();
  void find_islets(const Parameters& parameters);
  void find_platforms(const Parameters& parameters);
  std::vector<std::uint8_t> level_tops(const Parameters& parameters, bool all_around) const;
  std::vector<std::uint8_t> climbed_tops(
      const std::vector<std::uint8_t>& level, float step_m) const;
  void measure_distances();
  void find_ditches();
  void find_posts();

  std::int64_t first_cell_x_, first_cell_y_;
};

}  // namespace talus::baselines
