#pragma once
#include "backend.h"
#include "kernels/1_accept.h"
#include "kernels/1_buried_rays.h"
#include "kernels/1_voxel_filter.h"
#include "kernels/2_uncertainty.h"
#include "kernels/3_roll.h"
#include "kernels/4_update.h"
#include "kernels/5_refill.h"
#include "kernels/6_cleanup.h"
#include "kernels/7_fill_search.h"
#include "kernels/8_traversability.h"
#include "kernels/9_sparsity.h"
#include "kernels/tidy.h"

#include <algorithm>
#include <cstring>

namespace talus
{
/** The nine stages, once, for every executor: what runs in which order on which memory. The
 * executor supplies buffers and loops, the kernels the rule for one point, cell or line. */
template <class Executor>
class Pipeline final : public BackendInterface
{
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;
  using Atomics = typename Executor::Atomics;

 public:
  Pipeline(const kernels::Config& config, Executor executor)
      : host_config_(config), executor_(std::move(executor))
  {
    allocate_cells();
    executor_.upload(&host_config_, 1, config_.data());
    if (!Executor::kWalksLines)
      executor_.for_each_cell(
          line_grid().side, line_grid().side,
          kernels::FillLineTables{config_.data(), line_grid(), line_tables()});
  }

  void start(int slot, const Frame& frame, const kernels::FrameContext& context) override
  {
    use(slot);
    begin(frame, context);
    executor_.start_frame([this] { stages(); });
  }
  FrameReport finish(int slot) override
  {
    use(shown_ = slot);
    executor_.finish_frame([this] { stages(); });
    now_->parts_known = parts_wanted();
    return end();
  }

  PointArrays point_arrays(int slot, std::size_t size) override
  {
    use(slot);
    reserve_points(size);
    return executor_.point_arrays(point_cell_.size());
  }
  void read_layer(Layer layer, float* out) override;
  std::array<bool, kLayerCount> set_outputs(int slot, const OutputPointers& host) override;
  MapBytes read_all() override;
  void write_all(const MapBytes& bytes, const kernels::FrameContext& window) override;
  std::string name() const override { return executor_.name(); }

 private:
  // ---- stages ----
  void stages()
  {
    executor_.fetch(context_);
    accept_and_weigh();  // stages 1 and 2, and beside them 3
    executor_.lap(0);
    update();  // stage 4, on cores the end of stage 1, and beside it the rays of stage 6
    executor_.lap(3);
    refill();  // stage 5
    executor_.lap(4);
    clean_up();  // stage 6
    executor_.lap(5);
    fill();  // stage 7
    executor_.lap(6);
    judge();  // stages 8 and 9
    executor_.lap(7);
    executor_.join();  // with the layers that are copied
  }

  void accept_and_weigh()
  {
    const std::uint8_t* kept = host_config_.inverse_voxel > 0 ? filter_voxels() : nullptr;
    const kernels::AcceptPoint<Atomics> accept{
        config_.data(), context_.data(),  now_->in, points_out(),
        rays_.data(),   counters_.data(), kept};
    const kernels::RollCell roll{config_.data(), context_.data(), store(), top_hit_.data()};
    const kernels::FindGroundHits ground{config_.data(), context_.data(), store()};
    const int bins = kernels::bin_count(host_config_);
    if constexpr (Executor::kWalksLines)
    {
      executor_.locate_points(points(), accept);
      executor_.for_each_point_by_parts(
          points(),
          kernels::NoteRayAndReach<kernels::SerialAtomics>{
              {config_.data(), points_out(), rays_.data()}, {points_out(), reach_.data()}});
      executor_.for_another_stage(
          2, [&] { for_each_row([&](const auto& row) { row.each_concerned(roll); }); });
      executor_.for_each_stretch(
          bins, kernels::SweepRays{ground, rays_.data(), lowest_slope_.data(), doubted_.data()});
    }
    else
    {
      for_each_point_and_cell(
          kernels::AcceptAndCountPoint<Atomics>{accept, cell_count_.data()}, 2,
          kernels::RollCellAndReach{roll, reach_.data(), static_cast<int>(reach_.size())});
      executor_.for_each_direction_beside(
          bins, kernels::ring_count(host_config_),
          kernels::SettleRays{ground, rays_.data(), lowest_slope_.data()}, points(), reserve());
    }
  }

  const std::uint8_t* filter_voxels()
  {
    executor_.fill(voxel_key_, kernels::kNoVoxel);
    executor_.fill(voxel_winner_, kernels::kNoVoxel);
    const auto mask = static_cast<std::uint32_t>(voxel_key_.size() - 1);
    const kernels::EnterVoxel<Atomics> enter{
        config_.data(),
        context_.data(),
        now_->in,
        {voxel_key_.data(), voxel_winner_.data(), mask},
        voxel_slot_.data()};
    for_each_point(enter);
    for_each_point(kernels::KeepVoxel<Atomics>{enter, voxel_kept_.data()});
    return voxel_kept_.data();
  }

  void update()
  {
    const kernels::SortPoint sort{
        config_.data(), context_.data(), points_out(), rays_.data(), sorting()};
    const kernels::FindRise rise{config_.data(), context_.data(), store()};
    const kernels::UpdateCell cell{config_.data(), context_.data(), store(),
                                   points_out(),   sorting(),       top_hit_.data()};
    if constexpr (Executor::kWalksLines)
      executor_.update_cells_beside(
          points(),
          kernels::BinPoint<Atomics>{
              config_.data(), context_.data(), points_out(), lowest_slope_.data(),
              cell_count_.data(), counters_.data()},
          rise, sort, cell, 5, side(), look());
    else
    {
      for_each_point_and_cell(
          kernels::SortUnburiedPoint<Atomics>{
              sort,
              rise,
              {points_out(), reach_.data()},
              lowest_slope_.data(),
              kept_count_.data(),
              counters_.data()},
          5, look());
      executor_.for_each_and_team(points(), most_crowded(points()), cell);
    }
  }

  void refill()
  {
    const kernels::SupportGrid grid = support();
    const int radius = host_config_.object_radius, wide = kernels::dilation_radius(host_config_);
    const kernels::PoolSupport pool{config_.data(), context_.data(), store(), grid};
    const kernels::ErodeSupport erode{config_.data(), grid};
    const kernels::OpenSupport open{config_.data(), grid};
    if constexpr (Executor::kWalksLines)
    {
      executor_.for_each_pair_of_rows(grid.side, side(), context_.data(), pool);
      executor_.for_each_window(grid.side, grid.side, radius, erode);
      executor_.for_each_window(grid.side, grid.side, wide, open);
    }
    else
    {
      // The rays and the counts have been used.
      executor_.for_each_beside(
          workers(), tidy_up(static_cast<int>(rays_.size()), cells()), 5, grid.side, grid.side,
          pool);
      executor_.for_each_opening(grid.side, grid.side, radius, wide, erode, open);
    }
  }

  void clean_up()
  {
    const kernels::CleanUpCell clean{side(),  config_.data(),  store(),     passing(),
                                     reach(), top_hit_.data(), role_.data()};
    if constexpr (Executor::kWalksLines)
    {
      const kernels::ChooseRole choose = choose_role();
      const kernels::TakeSample take{config_.data(), store(),     role_.data(),
                                     passing(),      line_grid(), samples()};
      for_each_row(
          [&](const auto& row)
          {
            row.each_concerned(choose);
            row.each_concerned(clean);
            row.each(take);
          });
      // A core fills memory faster than a loop.
      executor_.fill(rays_, kernels::kNoRay);
      executor_.fill(reach_, std::int32_t{0});
      executor_.for_each(workers(), tidy_up(0, 0));
    }
    else
      executor_.mark_cells(
          side(), kernels::SettleCell{choose_role(), clean, line_grid(), samples()},
          unguarded(axis_marks_, 2 * side()));
  }

  int workers() const { return executor_.workers(cells()); }
  kernels::TidyUp tidy_up(int rays, int counts)
  {
    return {
        rays_.data(),
        rays,
        cell_count_.data(),
        kept_count_.data(),
        counts,
        static_cast<int>(kept_count_.size()),
        counters_.data(),
        executor_.reported(),
        kernels::kRejectCodes,
        cursor_.data(),
        workers()};
  }

  void fill()
  {
    const kernels::FillCell cell{side(),         config_.data(), context_.data(),
                                 store(),        role_.data(),   passing(),
                                 planes_.data(), surfaces(),     surface_layers()};
    if constexpr (Executor::kWalksLines)
      walk_lines(cell);
    else if (host_config_.fill_rule == kernels::kFillLines)
      search_lines<true>(cell);
    else
      search_lines<false>(cell);
  }

  void walk_lines(const kernels::FillCell& cell)
  {
    const kernels::LineGrid grid = line_grid();
    find_planes()(kernels::LoneTeam{});
    const kernels::FillWalkedCell fill{cell, grid, inferred()};
    const kernels::DropHanging drop{store()};
    const kernels::PutSurface put{config_.data(), store(), cell.out};
    executor_.walk_lines(
        host_config_, grid, planes_.data(), samples(), inferred(), context_.data(),
        [&](const auto& row)
        {
          row.each(fill);
          row.each_concerned(drop);
          if (cell.out.any()) row.each(put);
        });
  }

  template <bool kAlongLines>
  void search_lines(const kernels::FillCell& cell)
  {
    const int lines = kernels::line_count(host_config_), axes = 2 * side();
    executor_.pack_bits(
        lines, kernels::line_rings(host_config_) + 1,
        kernels::FindSamples{unguarded(axis_marks_, axes), side(), tracks_.data()},
        unguarded(marks_, lines), find_planes());
    const kernels::SearchAndFillCell<kAlongLines> search{
        cell,
        host_config_,
        samples(),
        unguarded(marks_, lines),
        unguarded(axis_marks_, axes),
        line_tables(),
        planes_.data(),
        across_.data(),
        line_grid(),
        kernels::places_in(host_config_.fill_search_m, host_config_.resolution_m, side() - 1)};
    executor_.in_bands(
        side(), copied_surfaces(), 0,
        [&](int first, int end, bool beside_last)
        {
          executor_.for_each_cell_by_lines(side(), first, end, search, beside_last);
          executor_.aside([&] { deliver_surfaces(first, end); });
        });
  }

  void judge()
  {
    if (parts_wanted())
      judge_with<true>();
    else
      judge_with<false>();
  }

  template <bool kParts>
  void judge_with()
  {
    if constexpr (Executor::kWalksLines)
      judge_rows<kParts>(0, side(), false);
    else
      executor_.in_bands(
          side(), copied_features(), copied_surfaces(),
          [&](int first, int end, bool beside_last)
          {
            judge_rows<kParts>(first, end, beside_last);
            executor_.aside([&] { deliver_features(first, end); });
          });
  }

  template <bool kParts>
  void judge_rows(int first, int end, bool beside_last)
  {
    const int n = side(), radius = host_config_.feature_radius_cells;
    const kernels::ComputeFeatures<kParts> compute{n,           config_.data(), surfaces(),
                                                   line_grid(), across_.data(), feature_layers()};
    const kernels::CompleteObstacles complete{
        n, config_.data(), surfaces(), judged(), feature(Layer::Traversability)};
    if constexpr (Executor::kWalksLines)
    {
      executor_.for_each_window(n, n, radius, compute);
      for_each_row([&](const auto& row) { row.each_concerned(complete); });
    }
    else
      executor_.for_each_judged_cell_of_rows(
          n, n, first, end, radius, compute, complete, beside_last);
  }

  // ---- around them ----
  void begin(const Frame& frame, const kernels::FrameContext& context);
  FrameReport end();
  void complete_parts();
  void allocate_parts();
  bool is_copied(Layer layer) const;
  int copied_surfaces() const { return copied(Layer::Elevation, Layer::State); }
  int copied_features() const { return copied(Layer::Slope, Layer::Traversability); }
  int copied(Layer first, Layer last) const;
  void deliver_surfaces(int first_row, int end_row)
  {
    deliver(Layer::Elevation, Layer::State, first_row, end_row);
  }
  void deliver_features(int first_row, int end_row)
  {
    deliver(Layer::Slope, Layer::Traversability, first_row, end_row);
  }
  void deliver(Layer first, Layer last, int first_row, int end_row);
  void deliver(Layer layer, int first_row, int end_row);
  void export_surface(Layer layer, float* to);
  void allocate_cells();
  void allocate_for_search();
  void reserve_points(std::size_t points);

  int side() const { return host_config_.cells; }
  int cells() const { return side() * side(); }
  /** How many cells of so many points can be crowded; or all cells, found and ordered. */
  static int most_crowded(int points)
  {
    if constexpr (Executor::kCrowd > 0)
      return points / Executor::kCrowd;
    else
      return 2 * points;
  }
  int points() const { return executor_.loop_size(now_->n_points, point_cell_.size()); }
  template <class F>
  void for_each_point(const F& f)
  {
    executor_.for_each(points(), f);
  }
  /** f of the points; beside it, for another stage, g of the cells. */
  template <class F, class G>
  void for_each_point_and_cell(const F& f, int stage, const G& g)
  {
    executor_.for_each_beside(points(), f, stage, side(), side(), g);
  }
  template <class F>
  void for_each_cell(const F& f)
  {
    executor_.for_each_cell(side(), side(), f);
  }
  /** f(row) of the rows of the window and where they are stored. */
  template <class F>
  void for_each_row(const F& f)
  {
    executor_.for_each_stored_row(side(), context_.data(), f);
  }

  // ---- views ----
  kernels::CellStore store()
  {
    return {ground_.data(), ground_var_.data(), elevation_.data(), elevation_var_.data(),
            state_.data(),  misses_.data(),     passed_.data(),    extent_.data()};
  }
  kernels::PointsOut points_out()
  {
    return {point_cell_.data(),   point_ray_.data(),     point_slope_.data(),
            point_reach_.data(),  point_rank_.data(),    point_in_cell_.data(),
            point_height_.data(), point_variance_.data()};
  }
  kernels::Sorting sorting()
  {
    return {cell_count_.data(), Executor::kWalksLines ? cell_count_.data() : kept_count_.data(),
            cell_begin_.data(), sorted_.data(),
            rise_.data(),       crowded_.data(),
            cursor_.data(),     static_cast<std::uint32_t>(Executor::kCrowd)};
  }
  kernels::ReserveStretch<Atomics> reserve() { return {context_.data(), points_out(), sorting()}; }
  kernels::SupportGrid support()
  {
    const int side = kernels::support_side(host_config_);
    const int pad = kernels::dilation_radius(host_config_);
    const auto n = static_cast<std::size_t>(side) * static_cast<std::size_t>(side + 2 * pad);
    float* p = support_.data();
    return {side,      kernels::support_margin(host_config_),
            pad,       p,
            p + n,     p + 2 * n,
            p + 3 * n, p + 4 * n,
            p + 5 * n, p + 6 * n};
  }
  kernels::LookThrough look()
  {
    return {side(), config_.data(), context_.data(), rays_.data(), passing()};
  }
  kernels::Reach reach() { return {context_.data(), reach_.data()}; }
  kernels::ChooseRole choose_role()
  {
    return {config_.data(),  context_.data(), store(),     support(),
            top_hit_.data(), reach(),         role_.data()};
  }
  kernels::PassingRays passing()
  {
    return {passing_.data(), passing_.data() + static_cast<std::size_t>(cells()), in_open_.data()};
  }
  kernels::FindPlanes find_planes()
  {
    return {config_.data(), context_.data(), line_grid(), samples().height_m, planes_.data()};
  }
  kernels::LineTables line_tables() { return {line_of_cell_.data(), tracks_.data()}; }
  kernels::LineGrid line_grid() const { return kernels::line_grid(host_config_); }
  std::size_t grid_size() const
  {
    return static_cast<std::size_t>(line_grid().side) * static_cast<std::size_t>(line_grid().pitch);
  }
  kernels::Samples samples()
  {
    float* p = samples_.data();
    return {p, p + grid_size()};
  }
  /** The first word of marks of so many lines, see kernels::LineMarks. */
  static std::uint32_t* unguarded(Buffer<std::uint32_t>& marks, int lines)
  {
    return marks.data() + kernels::LineMarks::kGuardWords * lines;
  }
  kernels::InferenceGrid inferred() { return {inferred_.data(), across_.data()}; }
  kernels::Surfaces surfaces()
  {
    const int pad = host_config_.feature_radius_cells;
    return {surfaces_.data(), side() + 2 * pad, pad};
  }
  /** Where stage 7 puts a layer that is wanted: into the caller's memory if kernels reach it. */
  float* surface(Layer layer)
  {
    const auto l = static_cast<std::size_t>(layer);
    if (!now_->wanted[l]) return nullptr;
    float* direct = now_->outputs[l].direct;
    return direct ? direct : now_->delivered.data() + l * static_cast<std::size_t>(cells());
  }
  kernels::SurfaceLayers surface_layers()
  {
    return {
        surface(Layer::Elevation), surface(Layer::GroundElevation), surface(Layer::Variance),
        surface(Layer::State)};
  }
  /** Whether each frame leaves what traversability is made of: slope, step, roughness, sparsity. */
  bool parts_wanted() const
  {
    const auto first = now_->wanted.begin() + static_cast<int>(Layer::Slope);
    return std::any_of(first, first + kParts, [](const float* to) { return to; });
  }
  /** Where a layer of stages 8 and 9 lives: in the caller's memory if kernels reach it. Null:
   * nobody wants it. */
  float* feature(Layer layer)
  {
    const auto l = static_cast<std::size_t>(layer);
    if (float* direct = now_->outputs[l].direct) return direct;
    if (layer == Layer::Traversability) return now_->traversability.data();
    const std::size_t index = l - static_cast<std::size_t>(Layer::Slope);
    float* const parts = now_->parts.data();
    return now_->parts.size() ? parts + index * static_cast<std::size_t>(cells()) : nullptr;
  }
  kernels::FeatureLayers feature_layers()
  {
    return {feature(Layer::Slope),    feature(Layer::Step),           feature(Layer::Roughness),
            feature(Layer::Sparsity), feature(Layer::Traversability), judged()};
  }

  float* judged() { return Executor::kWalksLines ? judged_.data() + side() + 1 : nullptr; }

  static constexpr int kParts = 4, kFeatureLayers = kParts + 1, kSupportArrays = 7;

  /** What a frame does not share with the one that is in flight beside it. */
  struct Slot
  {
    double stamp_s = 0;
    int n_points = 0;
    kernels::PointsIn in{};
    OutputPointers wanted{};
    std::array<OutputMemory, kLayerCount> outputs{};
    // derived layers, window order
    Buffer<float> traversability, parts, delivered;
    bool parts_known = false;  //!< `parts` belong to the map as it is
  };
  void use(int slot)
  {
    now_ = &slots_[static_cast<std::size_t>(slot)];
    executor_.use(slot);
  }

  kernels::Config host_config_;
  std::array<Slot, kSlots> slots_;
  Slot* now_ = slots_.data();  //!< of the frame that is dealt with
  int shown_ = 0;  //!< the slot of the frame that was finished last

  Buffer<kernels::Config> config_;
  Buffer<kernels::FrameContext> context_;
  // persistent, storage order
  Buffer<float> ground_, ground_var_, elevation_, elevation_var_;
  Buffer<std::uint8_t> state_, passed_, extent_;
  Buffer<std::int8_t> misses_;
  // of one frame
  Buffer<std::int32_t> point_cell_, point_ray_, point_reach_, point_in_cell_, crowded_;
  Buffer<std::uint64_t> cursor_;
  Buffer<std::uint32_t> point_rank_, cell_count_, kept_count_, cell_begin_, counters_;
  Buffer<float> point_slope_, point_height_, point_variance_, lowest_slope_;
  Buffer<kernels::HeightPoint> sorted_;
  Buffer<kernels::GroundRise> rise_;
  Buffer<std::uint64_t> voxel_key_, voxel_winner_;
  Buffer<std::uint32_t> voxel_slot_;
  Buffer<std::uint8_t> voxel_kept_, role_, in_open_, doubted_;
  Buffer<std::int32_t> rays_, reach_;
  Buffer<kernels::Surface> surfaces_;
  Buffer<std::uint32_t> marks_, axis_marks_;
  Buffer<std::int32_t> line_of_cell_;
  Buffer<kernels::Track> tracks_;
  Buffer<kernels::Planes> planes_;
  Buffer<float> top_hit_, support_, passing_, samples_, across_;
  Buffer<kernels::Inference> inferred_;
  Buffer<float> judged_;

  Executor executor_;  //!< the last member: what it does ends before the memory goes
};

template <class Executor>
void Pipeline<Executor>::begin(const Frame& frame, const kernels::FrameContext& context)
{
  reserve_points(frame.size);
  now_->stamp_s = frame.stamp_s;
  now_->n_points = context.n_points;
  now_->in = executor_.stage(frame, context, point_cell_.size());
}

template <class Executor>
FrameReport Pipeline<Executor>::end()
{
  FrameReport report;
  report.stamp_s = now_->stamp_s;
  report.points_in = static_cast<std::uint32_t>(now_->n_points);
  std::copy_n(executor_.reported(), kRejectCount, report.rejected.data());
  report.points_accepted = report.points_in;
  for (const auto r : report.rejected) report.points_accepted -= r;
  report.stage_ms = executor_.stage_ms();
  report.total_ms = executor_.total_ms();
  return report;
}

}  // namespace talus

#include "pipeline_layers.h"
#include "pipeline_memory.h"
