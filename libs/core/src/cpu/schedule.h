#pragma once
#include "cpu/executor.h"
#include "cpu/cells.h"
#include "cpu/lines.h"
#include "cpu/points.h"
#include "cpu/sweep_rays.h"
#include "map_buffers.h"
#include "voxel_filter.h"

#include <array>

namespace talus
{
/** The seven stages on cores, in their order. Rows of the window are done while their cells are in
 * the cache; fills sweep along lines. */
template <class Threads>
class CpuSchedule
{
 public:
  using Executor = CpuExecutor<Threads>;
  CpuSchedule(MapBuffers<Executor>& map, Executor& executor) : map_(map), executor_(executor) {}

  void allocate()
  {
    const auto n = static_cast<std::size_t>(map_.cells());
    for (auto& values : inferred_) executor_.allocate(values, map_.grid_size(), kernels::kNan);
    executor_.allocate(fill_marks_, map_.grid_size(), std::uint16_t{0});
    executor_.allocate(
        passability_, n + 2 * static_cast<std::size_t>(map_.side() + 1), std::uint8_t{0});
    const int directions = kernels::bin_count(map_.host_config);
    executor_.allocate(doubted_, static_cast<std::size_t>(directions), std::uint8_t{0});
  }
  void reserve_points(std::size_t capacity)
  {
    executor_.allocate(hit_cells_, 2 * capacity + 1, std::int32_t{0});
  }

  void stages()
  {
    executor_.fetch(map_.context);
    executor_.for_another_stage(Stage::Roll, [this] { roll(); });
    accept_and_weigh();  // stage 1
    find_buried();  // stage 1
    executor_.end_stage(Stage::Accept);
    update();  // end of stage 1, stage 3, rays of stage 5
    executor_.end_stage(Stage::Update);
    if (map_.now->starts_map)  // stage 4
      reach_first();
    else
      find_limits(map_.context.data(), 1);
    executor_.end_stage(Stage::Classify);
    clean_up();  // stage 5, and the decisions of stage 4
    executor_.end_stage(Stage::CleanUp);
    fill();  // stage 6
    executor_.end_stage(Stage::Fill);
    if (!map_.channels.empty()) fuse_channels();
    judge();  // stage 7
    if (map_.has_class_scores()) executor_.for_each_cell(side(), side(), map_.take_class_scores());
    executor_.end_stage(Stage::Traversability);
  }
  /** Finds what the robot gets to, in rounds of four sweeps, and how high ground can be. */
  void find_limits(const kernels::FrameContext* frame, int rounds = 1)
  {
    const kernels::CoarseGrid grid = map_.coarse_grid();
    const auto pool_reach = map_.template pool<kernels::PoolReach>(frame);
    const auto pool_cells = map_.template pool<kernels::PoolCells>(frame);
    executor_.for_each_row(
        2 * grid.side, grid.side,
        [&](int py)
        {
          PairOfRows<kernels::PoolReach>(pool_reach).pool(py, side(), *frame);
          PairOfRows<kernels::PoolCells>(pool_cells).pool(py, side(), *frame);
        });
    for (int round = 0; round < rounds; round++)
      for (const bool columns : {true, false})
        executor_.for_each_stretch(grid.side, kernels::SpreadReach{grid, columns});
    executor_.for_each_window(
        grid.side, grid.side, map_.host_config.object_radius,
        kernels::ErodeGround{map_.config.data(), grid});
    executor_.for_each_window(
        grid.side, grid.side, kernels::dilation_radius(map_.host_config),
        kernels::OpenGround{map_.config.data(), grid});
  }

  /** Lays out the ground, and tells the variance of all cells in window order. */
  void tell_variance(float* to)
  {
    lay_out_ground();
    tell_variance(to, {0, 0, side(), side()});
  }
  void lay_out_ground()
  {
    const kernels::LayOutGround lay_out = map_.lay_out_ground();
    for_each_row([&](const StoredRow& row) { row.each(lay_out); });
  }
  /** Tells the variance of some cells, after lay_out_ground(). */
  void tell_variance(float* to, const WindowRect& cells)
  {
    const kernels::TellVariance tell = map_.tell_variance(to);
    const kernels::FrameContext& frame = *map_.context.data();
    executor_.for_each_row(
        cells.width, cells.height,
        [&](int y)
        {
          const StoredRow row(side(), frame, cells.first_y + y);
          row.each_of(cells.first_x, cells.first_x + cells.width, tell);
        });
  }

  /** Repeats stage 7 for slope, step, roughness and sparsity. */
  void judge_parts() { judge<true>(false); }

 private:
  int side() const { return map_.side(); }
  int points() const { return map_.points(executor_); }

  void accept_and_weigh()
  {
    executor_.locate_points(points(), map_.accept(filter_voxels(map_, executor_)));
    executor_.for_each_point_by_parts(
        points(), kernels::NoteRayAndHit<Atomics>{
                      {map_.config.data(), map_.points_out(), map_.rays.data()},
                      {map_.points_out(), map_.reach.data()},
                      map_.count_offset()});
  }

  void roll()
  {
    const kernels::ForgetHits forget = map_.forget_hits();
    const kernels::RollCell roll = map_.roll();
    for_each_row(
        [&](const StoredRow& row)
        {
          row.each(forget);
          row.each_but(roll.stays(row.y()), roll);
        });
  }

  /** Finds the buried rays, and how far the datum follows the poses. */
  void find_buried()
  {
    executor_.for_each_stretch(
        kernels::bin_count(map_.host_config),
        kernels::SweepRays{
            map_.ground_hits(), map_.rays.data(), map_.lowest_slope.data(), doubted_.data()});
    map_.follow()(kernels::SerialGroup{});
  }

  /** Bins the points that are not buried, sorts them into their cells, and updates these. */
  void update()
  {
    const int n = points();
    kernels::BinPoint<Atomics> bin{};
    bin.config = map_.config.data();
    bin.frame = map_.context.data();
    bin.points = map_.points_out();
    bin.lowest_slope = map_.lowest_slope.data();
    bin.cell_count = map_.cell_count.data();
    bin.rejected = map_.counters.data();
    const kernels::SortPoint sort = map_.sort_point(sorting());
    const kernels::UpdateCell update = map_.update_cell(sorting());
    const kernels::FindPassingRays passing = map_.find_passing_rays();
    const auto over_rows = [&passing, cells = side()](int begin, int end)
    {
      for (int y = begin; y < end; y++) SteppedRow<kernels::FindPassingRays>(passing).run(cells, y);
    };
    cells::Order order(update, executor_.threads());
    if (executor_.is_for_one(n))
      executor_.run_beside(
          [&]
          {
            executor_.one_by_one(bin, n);
            order.find(n);
            sort_points(sort, 0, n);
          },
          side(), executor_.rows_at_once(side()), over_rows);
    else
    {
      executor_.for_another_stage(
          Stage::Accept, [&] { executor_.for_each_point_by_parts(n, bin); });
      executor_.for_another_stage(
          Stage::CleanUp,
          [&] { executor_.run(side(), executor_.rows_at_once(side()), over_rows); });
      order.find(n);
      executor_.run(n, 1024, [&sort](int begin, int end) { sort_points(sort, begin, end); });
    }
    executor_.run(order.batches(), 8, [&order](int begin, int end) { order.update(begin, end); });
    executor_.run(
        order.cells(), 4096, [&order](int begin, int end) { order.forget_points(begin, end); });
  }

  void clean_up()
  {
    const kernels::StandOnCell<Atomics> stand = map_.stand_on();
    const kernels::PresumeStart presume = map_.presume_start();
    const bool starts = presume.applies_to_frame();
    const kernels::ClassifyCell classify = map_.classify();
    const auto lower = map_.template classify<kernels::LowerObject>();
    const kernels::CleanUpCell clean = map_.clean_up();
    const lines::TakeSample take = take_sample();
    for_each_row(
        [&](const StoredRow& row)
        {
          if (!stand.leaves_out(row.y())) row.each_applicable(stand);
          if (starts) row.each_applicable(presume);
          row.each(classify);
          row.each_applicable(lower);
          row.each_applicable(clean);
          row.each(take);
        });
    executor_.fill(map_.rays, kernels::kNoRay);
    executor_.fill(map_.reach, std::int32_t{0});
    executor_.report(map_.counters);
  }

  lines::TakeSample take_sample()
  {
    return {map_.classify(), map_.line_grid(), map_.samples(), inferred().marks};
  }
  /** In the first frame nothing is known to be passable yet. All is judged as if it were ground,
   * before it is judged with what the robot gets to over that. */
  void reach_first()
  {
    const kernels::StandOnCell<Atomics> stand = map_.stand_on();
    const kernels::PresumeStart presume = map_.presume_start();
    const kernels::ClassifyCell classify = map_.classify();
    const lines::TakeSample take = take_sample();
    const bool starts = presume.applies_to_frame();
    executor_.fill(map_.ground_limit, kernels::kInfinity);
    for_each_row(
        [&](const StoredRow& row)
        {
          if (!stand.leaves_out(row.y())) row.each_applicable(stand);
          if (starts) row.each_applicable(presume);
          row.each(classify);
          row.each(take);
        });
    fill();
    judge();
    const kernels::StartReach start = map_.start_reach();
    for_each_row([&](const StoredRow& row) { row.each(start); });
    find_limits(map_.context.data(), kernels::kFirstReach_rounds);
    const kernels::ForgetFill forget = map_.forget_fill();
    for_each_row([&](const StoredRow& row) { row.each(forget); });
  }

  void fill()
  {
    const kernels::FillCell cell = map_.fill_cell();
    const auto fill = [cell, grid = map_.line_grid(), from = inferred()](int x, int y, int i)
    { cell(x, y, i, from.lines(grid.at(x, y)), from.marks[grid.at(x, y)]); };
    const kernels::PutSurface put{map_.config.data(), map_.context.data(), map_.store(), cell.out};
    const auto fill_row = [&](const StoredRow& row)
    {
      row.each(fill);
      if (cell.out.any()) row.each(put);
    };
    const lines::Walk walk{map_.host_config, map_.line_grid(), map_.samples(), inferred()};
    executor_.for_each_part(walk.parts_of_rays(), [&walk](int part) { walk.rays(part); });
    executor_.for_each_part(walk.parts_of_axis(), [&walk](int part) { walk.columns(part); });
    executor_.for_each_part(
        walk.parts_of_axis(),
        [&](int part)
        {
          walk.rows(part);
          for (int y = walk.first_of(part); y < walk.first_of(part + 1); y++)
            fill_row(StoredRow(side(), *map_.context.data(), y));
        });
    if (float* const to = map_.surface(Layer::Variance)) tell_variance(to);
  }

  void judge()
  {
    if (map_.parts_wanted())
      judge<true>(true);
    else
      judge<false>(true);
  }
  template <bool kParts>
  void judge(bool notes)
  {
    std::uint8_t* const passability = passability_.data() + side() + 1;
    executor_.for_each_window(
        side(), side(), map_.host_config.feature_radius_cells,
        map_.template compute_features<kParts>(passability));
    const kernels::CompleteObstacles complete = map_.complete_obstacles(passability, notes);
    for_each_row(
        [&](const StoredRow& row)
        {
          row.each_applicable(complete);
          if (notes) row.each(complete.passable);
        });
  }

  void fuse_channels()
  {
    const kernels::ForgetChannels forget = map_.forget_channels();
    for_each_row([&](const StoredRow& row) { row.each_but(forget.stays(row.y()), forget); });
    const kernels::PlacePoint place = map_.place_point();
    executor_.run(points(), 1024, [&place](int begin, int end) { over_range(place, begin, end); });
    const kernels::Channels channels = map_.channels_view();
    for (int c = 0; c < channels.size; c++) fuse_channel(channels.each[c]);
  }
  void fuse_channel(const kernels::Channel& channel)
  {
    if (!channel.of_points) return;
    const std::int32_t* const surface = map_.point_surface.data();
    std::uint8_t* const begins = map_.point_begins.data();
    executor_.run(
        points(), 1024,
        [=](int begin, int end) { add_to<Atomics>(channel, surface, begins, begin, end); });
    const kernels::SettleChannel settle = map_.settle_channel(channel);
    executor_.run(
        points(), 1024,
        [=](int begin, int end)
        {
          for (int i = begin; i < end; i++)
            if (begins[i]) settle(surface[i]);
        });
  }

  /** f(row) for the rows of the window. */
  template <class F>
  void for_each_row(const F& f)
  {
    executor_.for_each_row(
        side(), side(), [&](int y) { f(StoredRow(side(), *map_.context.data(), y)); });
  }

  kernels::Sorting sorting()
  {
    kernels::Sorting v{};
    v.cell_count = v.kept_count = map_.cell_count.data();
    v.cell_begin = map_.cell_begin.data();
    v.sorted = map_.sorted.data();
    v.crowded = hit_cells_.data();
    return v;
  }
  lines::InferenceGrid inferred()
  {
    auto& [information, weighted, lowest_m] = inferred_;
    return {
        information.data(), weighted.data(), lowest_m.data(), fill_marks_.data(), map_.fall.data()};
  }

  using Atomics = typename Executor::Atomics;
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;

  MapBuffers<Executor>& map_;
  Executor& executor_;
  Buffer<std::int32_t> hit_cells_;  //!< as found, then in order
  Buffer<std::uint8_t> doubted_, passability_;
  std::array<Buffer<float>, 3> inferred_;  //!< see lines::InferenceGrid
  Buffer<std::uint16_t> fill_marks_;
};

}  // namespace talus
