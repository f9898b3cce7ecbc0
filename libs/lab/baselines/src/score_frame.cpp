#include <talus/baselines/window_truth.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace talus::baselines
{
namespace
{
constexpr float kWrong_m = 0.2f;
constexpr double kDitchRange_m = 4.0;
constexpr float kSparse = 0.5f;

/** Scores one map in one frame, cell by cell. */
class FrameScorer
{
 public:
  FrameScorer(
      const Surfaces& map, const TruthMap& truth, const WindowTruth& here, const Observed& observed,
      Score& score)
      : map_(map), truth_(truth), here_(here), observed_(observed), score_(score)
  {
    measure_distance_to_upright();
  }

  void run()
  {
    for (std::size_t k = 0; k < map_.size(); ++k)
    {
      score_.cover(state(k));
      if (here_.at[k] < 0 || here_.touched[k]) continue;
      const auto at = static_cast<std::size_t>(here_.at[k]);
      if (!truth_.known(at)) continue;
      heights(k, at);
      hanging(k, at);
      blocked_and_free(k, at);
      ditches(k, at);
    }
    posts();
    paths();
  }

 private:
  CellState state(std::size_t k) const { return static_cast<CellState>(map_.state[k]); }

  /** Chessboard distance in cells to the nearest upright obstacle cell that was hit. */
  void measure_distance_to_upright()
  {
    const int n = map_.window.cells;
    cv::Mat no_upright(n, n, CV_8U, 1);
    for (int k = 0; k < n * n; ++k)
    {
      const int at = here_.at[k];
      if (at < 0 || !observed_.shows_obstacle(at)) continue;
      if (truth_.vertical[at]) no_upright.at<std::uint8_t>(k / n, k % n) = 0;
    }
    cv::distanceTransform(no_upright, to_upright_, cv::DIST_C, 3);
  }
  int distance_to_upright(std::size_t k) const
  {
    const int n = map_.window.cells, i = static_cast<int>(k);
    return static_cast<int>(std::lround(to_upright_.at<float>(i / n, i % n)));
  }

  void heights(std::size_t k, std::size_t at)
  {
    if (!truth_.surely_free(at) || !map_.known(k)) return;
    const float error = truth_.height_error_m(at, map_.ground_m[k]);
    if (state(k) == CellState::FilledTwoSided)
      (here_.could_see[k] ? score_.two_sided_seen : score_.two_sided_unseen).add(error);
    if (state(k) == CellState::FilledOneSided) score_.one_sided.add(error);
    if (state(k) == CellState::Presumed) score_.presumed_ground.add(error);
    if (state(k) != CellState::Measured || truth_.clear(at)) score_.bars.add(map_, k, error);
    if (state(k) != CellState::Measured || !truth_.clear(at)) return;
    const auto terrain = static_cast<std::size_t>(truth_.terrain[at]);
    score_.measured_ground[terrain].add(error);
    if (observed_.ground_hit[at]) score_.measured_ground_hit[terrain].add(error);
    score_.measured_elevation.add(truth_.height_error_m(at, map_.elevation_m[k]));
  }

  void hanging(std::size_t k, std::size_t at)
  {
    if (!truth_.hangs[at] || truth_.doubtful[at] || !map_.known(k)) return;
    if (!truth_.clear(at)) return;
    if (truth_.truth.underside[at] > here_.highest_shown_m) return;
    const bool wrong = truth_.height_error_m(at, map_.ground_m[k]) > kWrong_m ||
                       truth_.height_error_m(at, map_.elevation_m[k]) > kWrong_m;
    score_.hanging_wrong.add(wrong);
    if (!here_.could_see[k]) return;
    score_.hanging_wrong_seen.add(wrong);
    score_.hanging_passable.add(map_.passable(k));
  }

  void blocked_and_free(std::size_t k, std::size_t at)
  {
    if (truth_.doubtful[at]) return;
    risk(k, at);
    if (observed_.shows_obstacle(at) && !truth_.platform[at])
    {
      score_.obstacle_blocked.add(map_.blocked(k));
      if (truth_.covered_whole(at)) score_.obstacle_blocked_whole.add(map_.blocked(k));
    }
    if (!truth_.free(at) || !observed_.ground_hit[at]) return;
    score_.free_passable_all.add(map_.passable(k));
    const int from_obstacle = truth_.to_obstacle[at];
    if (truth_.clear(at)) score_.free_passable.add(map_.passable(k));
    if (from_obstacle >= 1 && from_obstacle <= kRings && distance_to_upright(k) == from_obstacle)
      score_.ring_blocked[from_obstacle - 1].add(map_.blocked(k));
  }

  void risk(std::size_t k, std::size_t at)
  {
    if (map_.risk.empty() || !map_.passable(k) || truth_.platform[at]) return;
    if (!(map_.risk[k] >= 0)) return;
    const auto tenth = static_cast<std::size_t>(map_.risk[k] * kTenths);
    score_.risky[std::min<std::size_t>(tenth, kTenths - 1)].add(truth_.blocked(at));
  }

  void ditches(std::size_t k, std::size_t at)
  {
    if (!truth_.ditch[at] || truth_.blocked(at)) return;
    const int n = map_.window.cells, i = static_cast<int>(k);
    const double dx = i % n - n / 2, dy = static_cast<double>(i / n) - n / 2;
    if (std::hypot(dx, dy) * map_.window.resolution_m > kDitchRange_m) return;
    const bool warned = !map_.sparsity.empty() && map_.sparsity[k] < kSparse;
    const bool bridged =
        map_.passable(k) && !warned && map_.ground_m[k] - truth_.truth.ground[at] > kWrong_m;
    score_.ditch_found.add(!bridged);
  }

  void posts()
  {
    const int n = map_.window.cells;
    std::vector<std::uint8_t> hit(static_cast<std::size_t>(truth_.posts), 0), kept(hit);
    for (int k = 0; k < n * n; ++k)
    {
      const int at = here_.at[k];
      const int post = at < 0 ? -1 : truth_.post[at];
      const int x = k % n, y = k / n;
      if (post < 0 || x < 1 || y < 1 || x + 1 >= n || y + 1 >= n) continue;
      const auto number = static_cast<std::size_t>(post);
      hit[number] |= observed_.shows_obstacle(at);
      for (int d = 0; d < 9; ++d) kept[number] |= map_.blocked((y + d / 3 - 1) * n + x + d % 3 - 1);
    }
    for (std::size_t i = 0; i < hit.size(); ++i)
      if (hit[i]) score_.posts.add(kept[i]);
  }

  void paths()
  {
    std::vector<std::uint8_t> open(map_.size());
    for (std::size_t k = 0; k < open.size(); ++k) open[k] = map_.passable(k);
    const auto reached = flood(open, here_.start, map_.window.cells);
    for (std::size_t k = 0; k < open.size(); ++k)
    {
      if (here_.at[k] < 0) continue;
      const auto at = static_cast<std::size_t>(here_.at[k]);
      if (truth_.blocked(at) && truth_.depth[at] >= 2 && !truth_.doubtful[at] &&
          !truth_.climbable[at])
      {
        score_.leak.add(reached[k]);
        if (observed_.shows_obstacle(at)) score_.leak_hit.add(reached[k]);
      }
      if (!here_.free_now[k] || here_.start[k] || truth_.doubtful[at]) continue;
      if (!here_.reachable[k]) score_.beyond.add(reached[k]);
      if (!here_.reachable[k]) continue;
      score_.reach.add(reached[k]);
      if (here_.reachable_seen[k] && truth_.clear(at)) score_.reach_seen.add(reached[k]);
    }
  }

  const Surfaces& map_;
  const TruthMap& truth_;
  const WindowTruth& here_;
  const Observed& observed_;
  Score& score_;
  cv::Mat to_upright_;
};

}  // namespace

void score_frame(
    const Surfaces& map, const TruthMap& truth, const WindowTruth& here, const Observed& observed,
    Score& score)
{
  FrameScorer(map, truth, here, observed, score).run();
}

}  // namespace talus::baselines
