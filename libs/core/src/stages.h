#pragma once
#include "kernels/1_points.h"
#include "kernels/1_voxel_filter.h"
#include "kernels/2_follow.h"
#include "kernels/3_update.h"
#include "kernels/4_classify.h"
#include "kernels/4_reach.h"
#include "kernels/4_start.h"
#include "kernels/4_underfoot.h"
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"
#include "kernels/6_variance.h"
#include "kernels/7_judge.h"
#include "kernels/9_channels.h"
#include "map_buffers.h"

#include <array>

namespace talus
{
// The stages of a frame: one list for all that runs them. `On` is Cores, a Device, or a stand-in
// for one. Its functions are loops over points, rays, pairs or cells. How they share threads and
// launches is its own concern, and changes no bit.

/** The loops that are alike on cores and on devices. */
template <class ExecutorType>
class StageLoops
{
 public:
  using Executor = ExecutorType;
  using Atomics = typename Executor::Atomics;
  StageLoops(MapBuffers<Executor>& map, Executor& executor) : map_(map), executor_(executor) {}

  void end_stage(Stage stage) { executor_.end_stage(stage); }
  void lift_limits() { executor_.fill(map_.pair_limit_m, kernels::kInfinity); }
  template <class Rule>
  void windows(const kernels::Map& m, int radius)
  {
    executor_.template for_each_window<Rule>(m, m.pairs.side, m.pairs.side, radius);
  }
  template <class Rule>
  void cells(const kernels::Map& m, const WindowRect& cells)
  {
    executor_.template for_each_cell<Rule>(m, cells);
  }

 protected:
  int points() const { return map_.points(executor_); }

  MapBuffers<Executor>& map_;
  Executor& executor_;
};

template <class Executor>
void filter_voxels(MapBuffers<Executor>& map, Executor& executor, const kernels::Map& m)
{
  using Atomics = typename Executor::Atomics;
  if (!(m.k.inverse_voxel > 0)) return;
  executor.fill(map.voxel_key, kernels::kNoVoxel);
  executor.fill(map.voxel_winner, kernels::kNoVoxel);
  executor.template for_each<kernels::EnterVoxel<Atomics>>(m, map.points(executor));
  executor.template for_each<kernels::KeepVoxel<Atomics>>(m, map.points(executor));
}

/** Finds how high ground can be near to what the robot gets to. */
template <class On>
void open_ground(On& on, const kernels::Map& m)
{
  on.template windows<kernels::ErodeGround>(m, m.k.object_radius);
  on.template windows<kernels::OpenGround>(m, kernels::dilation_radius(m.k));
}
/** Finds what the robot gets to, in rounds of four sweeps, and how high ground can be. */
template <class On>
void find_limits(On& on, const kernels::Map& m, int rounds)
{
  on.pool(m);
  for (int round = 0; round < rounds; round++) on.spread(m);
  open_ground(on, m);
}

inline WindowRect window_of(const kernels::Map& m) { return {0, 0, m.k.cells, m.k.cells}; }

/** Estimates the variance where it depends on some cells. */
template <class On, class Rects>
void estimate_variance(On& on, const kernels::Map& m, const Rects& cells)
{
  on.template cells<kernels::LayOutGround>(m, window_of(m));
  for (const WindowRect& rect : cells)
    on.template cells<kernels::EstimateVariance>(m, within(kernels::kAskedCells, rect, m.k.cells));
}

template <class On>
void fill(On& on, const kernels::Map& m)
{
  on.fill(m);  // FillCell, PutSurface
  if (!m.out.variance) return;
  estimate_variance(on, m, std::array{window_of(m)});
  on.deliver_variance();
}

/** In the first frame nothing is known to be passable yet. All is judged as if it were ground,
 * before it is judged with what the robot gets to over that. */
template <class On>
void reach_first(On& on, const kernels::Map& m)
{
  using namespace kernels;
  on.lift_limits();
  on.template settle<StandOnCell<typename On::Atomics>, PresumeStart, ClassifyCell>(m);
  fill(on, m);
  on.judge(m);
  on.template cells<StartReach>(m, window_of(m));
  find_limits(on, m, kFirstReach_rounds);
  on.template cells<ForgetFill>(m, window_of(m));
}

template <class On>
void run_stages(On& on, const kernels::Map& m, bool starts_map)
{
  using namespace kernels;
  using Atomics = typename On::Atomics;
  // 1: AcceptPoint, NoteRay, NoteReach, CountOffset, FindGroundHits, FollowPoses. 2: the cells.
  on.template accept<ForgetHits, RollCell>(m);
  on.end_stage(Stage::Accept);
  on.update(m);  // 3: SortPoint, UpdateCell. 5: FindPassingRays
  on.end_stage(Stage::Update);
  on.find_reach(m);  // 4: PoolReach, PoolCells, SpreadReach
  if (starts_map)
    reach_first(on, m);
  else
    open_ground(on, m);
  on.end_stage(Stage::Classify);
  // 4 and 5 on each cell, then TakeSample.
  on.template settle<StandOnCell<Atomics>, PresumeStart, ClassifyCell, LowerObject, CleanUpCell>(m);
  on.end_stage(Stage::CleanUp);
  fill(on, m);
  on.end_stage(Stage::Fill);
  if (m.channels.size > 0) on.fuse_channels(m);  // ForgetChannels, AssignPoint, SettlePoint
  on.judge(m);  // 7: ComputeFeatures, CompleteObstacles, NotePassable, TakeClassScores
  on.end_stage(Stage::Traversability);
  on.end();
}

}  // namespace talus
