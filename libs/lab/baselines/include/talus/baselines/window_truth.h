#pragma once
#include <talus/baselines/method.h>
#include <talus/baselines/score.h>
#include <talus/baselines/truth_map.h>

#include <optional>

namespace talus::baselines
{
/** What the scans have shown of each cell of a TruthMap since it came into the window. */
class Observed
{
 public:
  Observed(const TruthMap& truth, const Parameters& parameters);

  /** Adds the points of a frame; forgets cells outside the window. */
  void add(const ScanFrame& frame);

  /** Whether the scans have shown that this blocked cell is one: a hit on what stands there, higher
   * than the step threshold and kDoubt_m; where the ground itself blocks, hits on the ground within
   * 3 cells whose heights differ by more than that, and one in the cell. */
  bool shows_obstacle(std::size_t at) const;

  std::vector<std::uint8_t> ground_hit;

 private:
  void forget_outside(const Window& window);
  float obstacle_from_m() const;

  std::vector<std::uint8_t> high_hit_;
  std::vector<float> lowest_m_, highest_m_;  //!< hits on the ground; NaN: none
  std::vector<float> ground_up_to_m_;  //!< a hit this high is one on the ground there or beside it
  const TruthMap& truth_;
  Parameters parameters_;
};

/** Where movers are and were; what remains of them in the maps is watched by MoverWatch. */
class MoverTruth
{
 public:
  MoverTruth(const TruthMap& truth, const sim::World& world, const Parameters& parameters);

  /** Goes to the next frame. */
  void advance(const ScanFrame& frame);

  std::vector<std::uint8_t> blocked_now;  //!< by a mover
  std::vector<std::uint8_t> near_now;  //!< those and the cells next to them
  std::vector<std::uint8_t> touched;  //!< near_now, at any time since in the window
  /** Lowest underside of a mover there since in the window; -infinity: it stood on the ground; NaN:
   * none. */
  std::vector<float> underside_m;
  std::vector<float> hit_top_m;  //!< highest hit on a mover there; NaN: none
  std::vector<float> lowest_ray_m;  //!< of this frame, over a touched cell; NaN: no ray
  /** A ray of this frame went on between the bottom of the mover and its highest hit there. */
  std::vector<std::uint8_t> went_through;
  std::vector<int> seen_through_frame;  //!< the first, after the mover left; -1: not yet
  int frame = -1;

 private:
  void mark_movers(double time_s);
  void enter_rays(const ScanFrame& frame);
  /** A ray that goes on in the cell. */
  void enter_ray(std::size_t cell, float height_m);
  /** Whether rays of this frame show that the mover left, one that went through where it was, and
   * that nothing higher than a step is there. A ray below what has air below it shows neither. */
  bool sees_through(std::size_t cell) const;
  void forget_outside(const Window& window);

  const TruthMap& truth_;
  const sim::World& world_;
  Parameters parameters_;
};

/** Counts for one map how soon mover cells are passable again. */
class MoverWatch
{
 public:
  explicit MoverWatch(const TruthMap& truth) : freed_(truth.size(), 0), counted_(truth.size(), 0) {}

  /** True when read() of the map would be needed after this frame. */
  bool has_work(const MoverTruth& movers, const TruthMap& truth) const;
  void look(const MoverTruth& movers, const TruthMap& truth, const Surfaces& map, Score& score);

 private:
  std::vector<std::uint8_t> freed_, counted_;
};

/** The truth about the cells of one window at one time; index as in Surfaces. */
struct WindowTruth
{
  Window window;
  std::vector<int> at;  //!< index into the TruthMap, or -1
  std::vector<std::uint8_t> free_now, blocked_now;  //!< with movers
  std::vector<std::uint8_t> touched;  //!< a mover is or was here
  std::vector<std::uint8_t> could_see;  //!< a ray of some frame so far could have met its ground
  std::vector<std::uint8_t> start;  //!< where the robot stands
  std::vector<std::uint8_t> reachable;  //!< free and connected with the start
  std::vector<std::uint8_t> reachable_seen;  //!< the same over what could be seen
  double highest_shown_m = 0;  //!< map frame; of what is higher no map gets a point
};

/** Cells of a flood through `open` cells (4-connected) from all `start` cells. */
std::vector<std::uint8_t> flood(
    const std::vector<std::uint8_t>& open, const std::vector<std::uint8_t>& start, int cells);

/** `scene` decides what could be seen (nullptr: only what was hit); `movers` may be nullptr. */
WindowTruth window_truth(
    const TruthMap& truth, const Observed& observed, const MoverTruth* movers,
    const std::vector<ScanFrame>& frames, std::size_t now, const Parameters& parameters,
    const sim::Scene* scene, const sim::Scanner* scanner);

/** Adds one evaluated frame of one map to its score. */
void score_frame(
    const Surfaces& map, const TruthMap& truth, const WindowTruth& here, const Observed& observed,
    Score& score);

}  // namespace talus::baselines
