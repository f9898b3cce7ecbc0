#pragma once
#include "cpu/cells.h"
#include "cpu/executor.h"
#include "cpu/lines.h"
#include "cpu/points.h"
#include "cpu/sweep_rays.h"
#include "map_buffers.h"
#include "stages.h"

namespace talus
{
/** The loops of the stages on cores: rows while they are in the cache; fills sweep along lines. */
template <class Threads>
class Cores : public StageLoops<CpuExecutor<Threads>>
{
  using Map = kernels::Map;
  using Loops = StageLoops<CpuExecutor<Threads>>;
  using Loops::executor_, Loops::map_, Loops::points;

 public:
  using Loops::Loops;
  using typename Loops::Atomics;

  void prepare(const Map&) {}

  /** Stages 1 and 2, up to the buried rays and the datum. */
  template <class... OfCells>
  void accept(const Map& m)
  {
    executor_.for_another_stage(
        Stage::Roll, [&] { executor_.template for_each_cell<OfCells...>(m); });
    executor_.fill(map_.reach, std::int32_t{0});
    filter_voxels(map_, executor_, m);
    executor_.template locate_points<kernels::AcceptPoint<Atomics>>(m, points());
    executor_.template for_each_point_by_parts<kernels::NoteRayAndHit<Atomics>>(m, points());
    executor_.template for_each_stretch<kernels::SweepRays>(m, kernels::bin_count(m.k));
    kernels::FollowPoses{m}(kernels::SerialGroup{});
  }

  /** Bins the points that are not buried, sorts them into their cells, and updates these. */
  void update(const Map& m)
  {
    const int n = points(), side = m.k.cells;
    const auto over_rows = [&m](int begin, int end)
    {
      RowOfRays<kernels::FindPassingRays> row;
      for (int y = begin; y < end; y++) row.run(m, y);
    };
    cells::Order order(m, executor_.threads());
    const auto sort = [&m](int begin, int end) { sort_points<kernels::SortPoint>(m, begin, end); };
    using Bin = kernels::BinPoint<Atomics>;
    if (executor_.is_small(n))
      executor_.run_beside(
          [&]
          {
            executor_.template one_by_one<Bin>(m, n);
            order.find(n);
            sort(0, n);
          },
          side, executor_.rows_at_once(side), over_rows);
    else
    {
      executor_.for_another_stage(
          Stage::Accept, [&] { executor_.template for_each_point_by_parts<Bin>(m, n); });
      executor_.for_another_stage(
          Stage::CleanUp, [&] { executor_.run(side, executor_.rows_at_once(side), over_rows); });
      order.find(n);
      executor_.run(n, 1024, sort);
    }
    executor_.run(order.batches(), 8, [&order](int begin, int end) { order.update(begin, end); });
    executor_.run(
        order.cells(), 4096, [&order](int begin, int end) { order.forget_points(begin, end); });
  }

  /** The sweeps of a frame, and its table of rays for the next one. */
  void find_reach(const Map& m)
  {
    pool(m);
    spread(m);
    executor_.fill(map_.rays, kernels::kNoRay);
    executor_.report(map_.counts);
  }
  void pool(const Map& m)
  {
    executor_.for_each_row(
        2 * m.pairs.side, m.pairs.side,
        [&m](int py)
        {
          PairOfRows<kernels::PoolReach> reach;
          PairOfRows<kernels::PoolCells> cells;
          reach.pool(m, py), cells.pool(m, py);
        });
  }
  void spread(const Map& m)
  {
    executor_.template for_each_stretch<kernels::SpreadReach<true>>(m, m.pairs.side);
    executor_.template for_each_stretch<kernels::SpreadReach<false>>(m, m.pairs.side);
  }

  /** Rules on each cell, the last of which takes samples. */
  template <class... Rules>
  void settle(const Map& m)
  {
    executor_.template for_each_cell<Rules..., kernels::TakeSample>(m);
  }

  void fill(const Map& m)
  {
    executor_.fill(map_.fill_marks, std::uint16_t{0});
    const lines::Walk walk{m};
    const bool shows = m.out.elevation || m.out.ground || m.out.state || m.out.reached;
    executor_.for_each_part(walk.parts_of_rays(), [&walk](int part) { walk.rays(part); });
    executor_.for_each_part(walk.parts_of_axis(), [&walk](int part) { walk.columns(part); });
    executor_.for_each_part(
        walk.parts_of_axis(),
        [&](int part)
        {
          walk.rows(part);
          for (int y = walk.first_of(part); y < walk.first_of(part + 1); y++)
          {
            const StoredRow row(m, y);
            row.run<lines::FillSwept>();
            if (shows) row.run<kernels::PutSurface>();
          }
        });
  }

  void judge(const Map& m)
  {
    judge_all(m);
    if (map_.has_class_scores()) executor_.template for_each_cell<kernels::TakeClassScores>(m);
  }
  void judge_all(const Map& m)
  {
    if (m.with_features)
      judge_all<true>(m);
    else
      judge_all<false>(m);
  }

  void fuse_channels(const Map& m)
  {
    executor_.template for_each_cell<kernels::ForgetChannels>(m);
    executor_.template for_each<kernels::AssignPoint<Atomics>>(m, points());
    executor_.template for_each<kernels::SettlePoint>(m, points());
  }

  void deliver_variance() {}
  void end() {}

 private:
  template <bool kWithFeatureLayers>
  void judge_all(const Map& m)
  {
    executor_.template for_each_window<kernels::ComputeFeatures<kWithFeatureLayers>>(
        m, m.k.cells, m.k.cells, m.k.feature_radius_cells);
    if (m.keeps)
      executor_.template for_each_cell<kernels::CompleteObstacles, kernels::NotePassable>(m);
    else
      executor_.template for_each_cell<kernels::CompleteObstacles>(m);
  }
};

}  // namespace talus
