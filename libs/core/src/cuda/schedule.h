#pragma once
#include "cuda/fill_search.h"
#include "cuda/points.h"
#include "cuda/settle_cell.h"
#include "cuda/settle_rays.h"
#include "cuda/reset_frame.h"
#include "cuda/reach_lines.h"
#include "map_buffers.h"
#include "voxel_filter.h"

namespace talus
{
/** The seven stages on a device, in their order. There are few launches, each thread has a point, a
 * cell or a direction, and each cell searches the lines through it. Independent loops share a
 * launch. `Executor` may be a stand-in for a device. */
template <class ExecutorType>
class DeviceSchedule
{
 public:
  using Executor = ExecutorType;
  DeviceSchedule(MapBuffers<Executor>& map, Executor& executor) : map_(map), executor_(executor) {}

  void allocate();
  void reserve_points(std::size_t capacity)
  {
    executor_.allocate(
        crowded_, static_cast<std::size_t>(most_crowded(static_cast<int>(capacity))) + 1,
        std::int32_t{0});
  }

  void stages()
  {
    executor_.fetch(map_.context);
    accept_and_weigh();  // stage 1 and stage 2
    find_buried();  // stage 1, and the ranges for sorting
    executor_.end_stage(Stage::Accept);
    sort_points();  // end of stage 1, stage 3, rays of stage 5
    update();
    executor_.end_stage(Stage::Update);
    find_limits();  // stage 4, and the rays and counts of the next frame
    executor_.end_stage(Stage::Classify);
    clean_up();  // stage 5, and the decisions of stage 4
    executor_.end_stage(Stage::CleanUp);
    fill();  // stage 6
    executor_.end_stage(Stage::Fill);
    if (!map_.channels.empty()) fuse_channels();
    judge();  // stage 7
    executor_.end_stage(Stage::Traversability);
    executor_.join();  // waits for the copies of layers
  }
  /** Finds what the robot gets to, in rounds of four sweeps, and how high ground can be. */
  void find_limits(const kernels::FrameContext* frame, int rounds = 1)
  {
    const int pairs = map_.coarse_grid().side;
    executor_.for_each(pairs * pairs, pool_reach(frame));
    for (int round = 0; round < rounds; round++)
    {
      executor_.for_each(threads_of_lines(), along_columns());
      executor_.for_each(threads_of_lines(), along_rows());
    }
    executor_.for_each_cell(pairs, pairs, map_.template pool<kernels::PoolCells>(frame));
    open_ground();
  }
  /** Lays out the ground, and tells the variance of all cells in window order. */
  void tell_variance(float* to)
  {
    lay_out_ground();
    tell_variance(to, {0, 0, side(), side()});
  }
  void lay_out_ground() { executor_.for_each_cell(side(), side(), map_.lay_out_ground()); }
  /** Tells the variance of some cells, after lay_out_ground(). */
  void tell_variance(float* to, const WindowRect& cells)
  {
    executor_.for_each_cell(
        cells.width, cells.height, OfRect<kernels::TellVariance>{map_.tell_variance(to), cells});
  }
  /** Repeats stage 7 for slope, step, roughness and sparsity. */
  void judge_parts() { judge_rows<true>(0, side(), false, false); }

 private:
  using Atomics = typename Executor::Atomics;
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;

  int side() const { return map_.side(); }
  int points() const { return map_.points(executor_); }
  /** The most cells that can be crowded. */
  static int most_crowded(int points) { return points / Executor::kCrowd; }

  void accept_and_weigh()
  {
    executor_.for_each_beside(
        points(),
        kernels::AcceptAndCountPoint<Atomics>{
            map_.accept(filter_voxels(map_, executor_)), map_.count_offset(),
            map_.cell_count.data()},
        side(), side(),
        kernels::RollCellAndReach{
            map_.forget_hits(), map_.roll(), datum_before_.data(), map_.reach.data(),
            static_cast<int>(map_.reach.size())});
  }

  /** Finds the buried rays by the datum before, and how far it follows the poses. */
  void find_buried()
  {
    kernels::FindGroundHits ground = map_.ground_hits();
    ground.datum = datum_before_.data();
    const int pairs = map_.coarse_grid().side;
    executor_.for_each_direction_beside(
        kernels::bin_count(map_.host_config),
        kernels::SettleRays{ground, map_.rays.data(), map_.lowest_slope.data()},
        pairs * pairs + points(),
        kernels::Before<kernels::PoolReachOfPair, kernels::ReserveStretch<Atomics>>{
            pairs * pairs,
            pool_reach(map_.context.data()),
            {map_.context.data(), map_.points_out(), sorting()}},
        map_.follow());
  }

  void sort_points()
  {
    const kernels::SortUnburiedPoint<Atomics> sort{
        map_.sort_point(sorting()),
        {map_.points_out(), map_.reach.data()},
        map_.lowest_slope.data(),
        kept_count_.data(),
        map_.counters.data()};
    executor_.for_each_beside(
        threads_of_lines() + points(), after_lines(along_columns(), sort), side(), side(),
        map_.find_passing_rays());
  }

  void update()
  {
    executor_.for_each_and_group(points(), most_crowded(points()), map_.update_cell(sorting()));
  }

  void find_limits()
  {
    const int pairs = map_.coarse_grid().side;
    // The rays and the counts are no longer needed.
    executor_.for_each_beside(
        threads_of_lines() + workers(), after_lines(along_rows(), reset_frame()), pairs, pairs,
        map_.template pool<kernels::PoolCells>(map_.context.data()));
    if (map_.now->starts_map)
      reach_first();
    else
      open_ground();
  }
  kernels::PoolReachOfPair pool_reach(const kernels::FrameContext* frame)
  {
    return kernels::PoolReachOfPair{map_.template pool<kernels::PoolReach>(frame)};
  }
  int threads_of_lines() { return kernels::SpreadAlongLine::kThreads * map_.coarse_grid().side; }
  kernels::SpreadAlongLine along_rows() { return {map_.coarse_grid(), false}; }
  kernels::SpreadAlongLine along_columns() { return {map_.coarse_grid(), true}; }
  template <class Then>
  kernels::Before<kernels::SpreadAlongLine, Then> after_lines(
      const kernels::SpreadAlongLine& lines, const Then& then)
  {
    return {threads_of_lines(), lines, then};
  }
  void open_ground()
  {
    const kernels::CoarseGrid grid = map_.coarse_grid();
    executor_.for_each_window(
        grid.side, grid.side, map_.host_config.object_radius,
        kernels::ErodeGround{map_.config.data(), grid});
    executor_.for_each_window(
        grid.side, grid.side, kernels::dilation_radius(map_.host_config),
        kernels::OpenGround{map_.config.data(), grid});
  }
  /** In the first frame nothing is known to be passable yet. All is judged as if it were ground,
   * before it is judged with what the robot gets to over that. */
  void reach_first()
  {
    executor_.fill(map_.ground_limit, kernels::kInfinity);
    mark_cells(kernels::SettleFirst<Atomics>{
        map_.stand_on(), map_.presume_start(), map_.classify(), map_.line_grid(), map_.samples()});
    fill();
    judge();
    executor_.for_each_cell(side(), side(), map_.start_reach());
    find_limits(map_.context.data(), kernels::kFirstReach_rounds);
    executor_.for_each_cell(side(), side(), map_.forget_fill());
  }

  void clean_up()
  {
    mark_cells(kernels::SettleCell<Atomics>{
        map_.stand_on(), map_.presume_start(), map_.classify(),
        map_.template classify<kernels::LowerObject>(), map_.clean_up(), map_.line_grid(),
        map_.samples()});
  }
  template <class Settle>
  void mark_cells(const Settle& settle)
  {
    executor_.mark_cells(side(), settle, unguarded(axis_marks_, 2 * side()));
  }

  void fill()
  {
    const kernels::Config& k = map_.host_config;
    const int lines = kernels::line_count(k), axes = 2 * side();
    executor_.pack_bits(
        lines, kernels::line_rings(k) + 1,
        kernels::FindSamples{unguarded(axis_marks_, axes), side(), tracks_.data()},
        unguarded(marks_, lines));
    kernels::SearchAndFillCell search{};
    search.fill = map_.fill_cell();
    search.k = k;
    search.samples = map_.samples();
    search.marks = unguarded(marks_, lines);
    search.axis_marks = unguarded(axis_marks_, axes);
    search.tables = line_tables();
    search.fall_m = map_.fall.data();
    search.grid = map_.line_grid();
    search.axis_places = kernels::places_in(k.fill_search_m, k.resolution_m, side() - 1);
    executor_.in_bands(
        side(), map_.copied_surfaces(), 0,
        [&](int first, int end, bool beside_last)
        {
          executor_.for_each_cell_by_lines(side(), first, end, search, beside_last);
          executor_.aside([&] { map_.deliver_surfaces(executor_, first, end); });
        });
    if (float* const to = map_.surface(Layer::Variance))
    {
      tell_variance(to);
      executor_.aside([&] { map_.deliver_variance(executor_); });
    }
  }

  void judge()
  {
    if (map_.parts_wanted())
      judge<true>();
    else
      judge<false>();
  }
  template <bool kParts>
  void judge()
  {
    executor_.in_bands(
        side(), map_.copied_features(), map_.copied_surfaces(),
        [&](int first, int end, bool beside_last)
        {
          judge_rows<kParts>(first, end, beside_last);
          if (map_.has_class_scores())
            executor_.for_each_cell_of_rows(side(), first, end, map_.take_class_scores(), false);
          executor_.aside([&] { map_.deliver_features(executor_, first, end); });
        });
  }

  template <bool kParts>
  void judge_rows(int first, int end, bool beside_last, bool notes = true)
  {
    executor_.for_each_judged_cell_of_rows(
        side(), side(), first, end, map_.host_config.feature_radius_cells,
        map_.template compute_features<kParts>(nullptr), map_.complete_obstacles(nullptr, notes),
        beside_last);
  }

  /** A cell that entered is not settled while it is cleared: sums are apart from what is known. */
  void fuse_channels()
  {
    const kernels::Channels channels = map_.channels_view();
    executor_.for_each_beside(
        points(),
        kernels::PlaceAndAddPoint<Atomics>{map_.place_point(), channels, map_.point_begins.data()},
        side(), side(), map_.forget_channels());
    executor_.for_each(
        points(), kernels::SettlePoint{
                      map_.settle_channel(channels.each[0]), channels, map_.point_surface.data(),
                      map_.point_begins.data()});
  }

  int workers() const { return executor_.workers(map_.cells()); }
  kernels::ResetFrame reset_frame()
  {
    kernels::ResetFrame v{};
    v.rays = map_.rays.data();
    v.n_rays = static_cast<int>(map_.rays.size());
    v.cell_count = map_.cell_count.data();
    v.n_cells = map_.cells();
    v.kept_count = kept_count_.data();
    v.n_kept = static_cast<int>(kept_count_.size());
    v.counters = map_.counters.data();
    v.n_counters = kernels::kCounters;
    v.reported = executor_.reported();
    v.cursor = cursor_.data();
    v.workers = workers();
    return v;
  }

  kernels::Sorting sorting()
  {
    kernels::Sorting v{};
    v.cell_count = map_.cell_count.data();
    v.kept_count = kept_count_.data();
    v.cell_begin = map_.cell_begin.data();
    v.sorted = map_.sorted.data();
    v.crowded = crowded_.data();
    v.cursor = cursor_.data();
    v.crowd = Executor::kCrowd;
    return v;
  }
  kernels::LineTables line_tables() { return {line_of_cell_.data(), tracks_.data()}; }
  /** The first word of the marks of so many lines, see kernels::LineMarks. */
  static std::uint32_t* unguarded(Buffer<std::uint32_t>& marks, int lines)
  {
    return marks.data() + kernels::LineMarks::kGuardWords * lines;
  }

  MapBuffers<Executor>& map_;
  Executor& executor_;
  Buffer<std::uint32_t> kept_count_;
  Buffer<std::uint64_t> cursor_;
  Buffer<kernels::Datum> datum_before_;  //!< of the frame before
  Buffer<std::int32_t> crowded_;
  Buffer<std::int32_t> line_of_cell_;
  Buffer<kernels::Track> tracks_;
  Buffer<std::uint32_t> marks_, axis_marks_;
};

template <class Executor>
void DeviceSchedule<Executor>::allocate()
{
  const kernels::Config& k = map_.host_config;
  const auto lines = static_cast<std::size_t>(kernels::line_count(k));
  executor_.allocate(kept_count_, static_cast<std::size_t>(map_.cells()), std::uint32_t{0});
  executor_.allocate(cursor_, 1, std::uint64_t{0});
  executor_.allocate(datum_before_, 1, kernels::Datum{});
  executor_.allocate(line_of_cell_, map_.grid_size(), std::int32_t{0});
  executor_.allocate(tracks_, lines, kernels::Track{});
  const auto guarded = [](int words)
  { return static_cast<std::size_t>(words + 2 * kernels::LineMarks::kGuardWords); };
  executor_.allocate(
      axis_marks_, 2 * static_cast<std::size_t>(side()) * guarded(kernels::words_per_axis(k)),
      std::uint32_t{0});
  executor_.allocate(marks_, lines * guarded(kernels::words_per_line(k)), std::uint32_t{0});
  const kernels::LineGrid grid = map_.line_grid();
  executor_.for_each_cell(
      grid.side, grid.side, kernels::FillLineTables{map_.config.data(), grid, line_tables()});
}

}  // namespace talus
