#pragma once
#include "cuda/cells.h"
#include "cuda/fill_search.h"
#include "cuda/points.h"
#include "cuda/settle_rays.h"
#include "map_buffers.h"
#include "stages.h"

namespace talus
{
/** The loops of the stages on a device. A thread has a point, a cell or a direction; each cell
 * searches its lines. Independent loops share a launch. `Executor` may be a stand-in. */
template <class Executor>
class Device : public StageLoops<Executor>
{
  using Map = kernels::Map;
  using Loops = StageLoops<Executor>;
  using Loops::executor_, Loops::map_, Loops::points;

 public:
  using Loops::Loops;
  using typename Loops::Atomics;

  /** Makes the tables of the lines. */
  void prepare(const Map& m)
  {
    const int side = m.lines.side;
    executor_.template for_each_cell<kernels::FillLineTables>(m, {0, 0, side, side});
  }

  /** Stages 1 and 2, up to the buried rays, the datum and the ranges for sorting. */
  template <class... OfCells>
  void accept(const Map& m)
  {
    filter_voxels(map_, executor_, m);
    executor_.template for_each_beside<
        kernels::Nothing, kernels::AcceptAndCountPoint<Atomics>,
        kernels::InTurn<OfCells..., kernels::ForgetReach>>(m, 0, points(), m.k.cells, m.k.cells);
    executor_.template for_each_direction_beside<
        kernels::SettleRays, kernels::PoolReachOfPair, kernels::ReserveRange<Atomics>,
        kernels::FollowPoses>(m, kernels::bin_count(m.k), pairs(m), pairs(m) + points());
  }

  /** Stage 3 and the rays of stage 5. */
  void update(const Map& m)
  {
    executor_.template for_each_beside<
        kernels::SpreadAlongLine<true>, kernels::SortUnburiedPoint<Atomics>,
        kernels::FindPassingRays>(m, lines(m), lines(m) + points(), m.k.cells, m.k.cells);
    executor_.template for_each_and_group<kernels::UpdateCell>(
        m, points(), points() / static_cast<int>(kernels::kCrowd));
  }

  /** The end of the sweeps of a frame; resets its rays and counts for the next one. */
  void find_reach(const Map& m)
  {
    executor_.template for_each_beside<
        kernels::SpreadAlongLine<false>, kernels::ResetFrame, kernels::PoolCells>(
        m, lines(m), lines(m) + kernels::ResetFrame::workers(m.k), m.pairs.side, m.pairs.side);
  }
  void pool(const Map& m)
  {
    executor_.template for_each<kernels::PoolReachOfPair>(m, pairs(m));
    executor_.template for_each_cell<kernels::PoolCells>(m, {0, 0, m.pairs.side, m.pairs.side});
  }
  void spread(const Map& m)
  {
    executor_.template for_each<kernels::SpreadAlongLine<true>>(m, lines(m));
    executor_.template for_each<kernels::SpreadAlongLine<false>>(m, lines(m));
  }

  /** Rules on each cell, before samples are taken. */
  template <class... Rules>
  void settle(const Map& m)
  {
    executor_.template mark_cells<kernels::SettleCell<Rules...>>(m, m.axis_marks);
  }

  void fill(const Map& m)
  {
    executor_.template pack_bits<kernels::SamplesOfLine>(
        m, kernels::line_count(m.k), m.lines.half + 1, m.marks);
    executor_.in_bands(
        m.k.cells, map_.copied_surfaces(), 0,
        [&](int first, int end, bool beside_last)
        {
          executor_.template for_each_cell_by_lines<kernels::SearchAndFillCell>(
              m, first, end, beside_last);
          executor_.aside([&] { map_.deliver_surfaces(executor_, first, end); });
        });
  }
  void deliver_variance()
  {
    executor_.aside([&] { map_.deliver_variance(executor_); });
  }

  void judge(const Map& m)
  {
    executor_.in_bands(
        m.k.cells, map_.copied_features(), map_.copied_surfaces(),
        [&](int first, int end, bool beside_last)
        {
          judge_rows(m, first, end, beside_last);
          if (map_.has_class_scores())
            executor_.template for_each_cell<kernels::TakeClassScores>(
                m, {0, first, m.k.cells, end - first});
          executor_.aside([&] { map_.deliver_features(executor_, first, end); });
        });
  }
  void judge_all(const Map& m) { judge_rows(m, 0, m.k.cells, false); }

  /** A cell that entered is not settled while it is cleared: sums are apart from what is known. */
  void fuse_channels(const Map& m)
  {
    executor_.template for_each_beside<
        kernels::Nothing, kernels::AssignPoint<Atomics>, kernels::ForgetChannels>(
        m, 0, points(), m.k.cells, m.k.cells);
    executor_.template for_each<kernels::SettlePoint>(m, points());
  }
  /** Waits for the copies of layers. */
  void end() { executor_.join(); }

 private:
  static int pairs(const Map& m) { return m.pairs.side * m.pairs.side; }
  /** The threads of the sweeps along lines of pairs. */
  static int lines(const Map& m) { return kernels::SpreadAlongLine<true>::kThreads * m.pairs.side; }

  void judge_rows(const Map& m, int first, int end, bool beside_last)
  {
    if (m.with_features)
      judge_rows<true>(m, first, end, beside_last);
    else
      judge_rows<false>(m, first, end, beside_last);
  }
  template <bool kWithFeatureLayers>
  void judge_rows(const Map& m, int first, int end, bool beside_last)
  {
    executor_.template for_each_judged_cell_of_rows<
        kernels::ComputeFeatures<kWithFeatureLayers>, kernels::CompleteObstacles>(
        m, m.k.cells, m.k.cells, first, end, m.k.feature_radius_cells, beside_last);
  }
};

}  // namespace talus
