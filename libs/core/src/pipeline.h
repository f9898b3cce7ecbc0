#pragma once
#include "backend.h"
#include "kernels/1_accept.h"
#include "kernels/2_uncertainty.h"
#include "kernels/3_roll.h"
#include "kernels/4_update.h"
#include "kernels/5_refill.h"
#include "kernels/6_cleanup.h"
#include "kernels/7_fill.h"
#include "kernels/8_traversability.h"
#include "kernels/9_sparsity.h"

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
      : executor_(std::move(executor)), host_config_(config)
  {
    allocate_cells();
    executor_.upload(&host_config_, 1, config_);
  }

  FrameReport run(const Frame& frame, const kernels::FrameContext& context) override
  {
    begin(frame, context);
    accept_and_weigh();  // stages 1 and 2
    lap(0);
    roll_and_update();  // stages 3 and 4
    lap(3);
    refill();  // stage 5
    lap(4);
    clean_up();  // stage 6
    lap(5);
    fill();  // stage 7
    lap(6);
    judge();  // stages 8 and 9
    lap(7);
    return end(frame);
  }

  void read_layer(Layer layer, float* out) override;
  MapBytes read_all() override;
  void write_all(const MapBytes& bytes, const kernels::FrameContext& window) override;
  std::string name() const override { return executor_.name(); }

 private:
  // ---- stages ----
  void accept_and_weigh()
  {
    executor_.fill(rays_, kernels::kNoRay);
    executor_.fill(counters_, std::uint32_t{0});
    const std::uint8_t* kept = host_config_.inverse_voxel > 0 ? filter_voxels() : nullptr;
    executor_.for_each(
        n_points_, kernels::AcceptPoint<Atomics>{
                       config_.data(), context_.data(), in_, points_out(), cell_count_.data(),
                       rays_.data(), counters_.data(), kept});
  }

  const std::uint8_t* filter_voxels()
  {
    executor_.fill(voxel_key_, kernels::kNoVoxel);
    executor_.fill(voxel_winner_, kernels::kNoVoxel);
    const auto mask = static_cast<std::uint32_t>(voxel_key_.size() - 1);
    const kernels::EnterVoxel<Atomics> enter{
        config_.data(),
        context_.data(),
        in_,
        {voxel_key_.data(), voxel_winner_.data(), mask},
        voxel_slot_.data()};
    executor_.for_each(n_points_, enter);
    executor_.for_each(n_points_, kernels::KeepVoxel<Atomics>{enter, voxel_kept_.data()});
    return voxel_kept_.data();
  }

  void roll_and_update()
  {
    executor_.for_each(
        cells(), kernels::ReserveCellPoints<Atomics>{
                     cell_count_.data(), cell_begin_.data(), counters_.data() + kCursor});
    executor_.for_each(
        n_points_,
        kernels::SortPoint{context_.data(), points_out(), cell_begin_.data(), sorted_.data()});
    for_each_cell(kernels::UpdateCell{
        config_.data(), context_.data(), store(), cell_count_.data(), cell_begin_.data(),
        sorted_.data(), top_hit_.data()});
  }

  void refill()
  {
    const kernels::SupportGrid grid = support();
    const auto pooled = [&](const auto& f) { executor_.for_each_cell(grid.side, grid.side, f); };
    pooled(kernels::PoolSupport{config_.data(), context_.data(), store(), grid});
    pooled(kernels::ErodeSupportRow{config_.data(), grid});
    pooled(kernels::ErodeSupportColumn{config_.data(), grid});
    pooled(kernels::OpenSupportRow{config_.data(), grid});
    for_each_cell(
        kernels::ChooseRole{config_.data(), context_.data(), store(), grid, role_.data()});
  }

  void clean_up()
  {
    executor_.for_each(
        kernels::bin_count(host_config_), kernels::SweepRays{config_.data(), rays_.data()});
    for_each_cell(kernels::CleanUpCell{
        config_.data(), context_.data(), store(), rays_.data(), top_hit_.data(), role_.data(),
        ray_bound_.data()});
  }

  void fill()
  {
    executor_.for_each_cell(
        kernels::line_count(host_config_), kernels::words_per_line(host_config_),
        kernels::MarkLineWord{
            config_.data(), context_.data(), store(), role_.data(), marks_.data()});
    for_each_cell(kernels::FillCell{
        config_.data(), context_.data(), store(), role_.data(), marks_.data(), ray_bound_.data(),
        surfaces()});
  }

  void judge()
  {
    for_each_cell(
        kernels::SumRow{config_.data(), context_.data(), store(), surfaces(), row_sums()});
    for_each_cell(kernels::ComputeFeatures{
        config_.data(), context_.data(), store(), surfaces(), row_sums(), marks_.data(),
        feature_layers()});
  }

  // ---- around them ----
  void begin(const Frame& frame, const kernels::FrameContext& context);
  FrameReport end(const Frame& frame);
  void lap(int stage);
  void allocate_cells();
  void reserve_points(std::size_t points);

  int side() const { return host_config_.cells; }
  int cells() const { return side() * side(); }
  template <class F>
  void for_each_cell(const F& f)
  {
    executor_.for_each_cell(side(), side(), f);
  }

  // ---- views ----
  kernels::CellStore store()
  {
    return {ground_.data(),        ground_var_.data(), elevation_.data(),
            elevation_var_.data(), state_.data(),      misses_.data()};
  }
  kernels::PointsOut points_out()
  {
    return {point_cell_.data(), point_rank_.data(), point_height_.data(), point_variance_.data()};
  }
  kernels::SupportGrid support()
  {
    const int side = kernels::support_side(host_config_);
    const auto n = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    float* p = support_.data();
    return {side, p, p + n, p + 2 * n, p + 3 * n, p + 4 * n, p + 5 * n, p + 6 * n};
  }
  kernels::Surfaces surfaces()
  {
    const int pad = host_config_.feature_radius_cells;
    return {surface_ground_.data(), surface_height_.data(), side() + 2 * pad, pad};
  }
  kernels::RowSumArrays row_sums()
  {
    std::int32_t* p = row_sums_.data();
    const auto n = static_cast<std::size_t>(cells());
    return {p, p + n, p + 2 * n, p + 3 * n, p + 4 * n, p + 5 * n, p + 6 * n, p + 7 * n};
  }
  kernels::FeatureLayers feature_layers()
  {
    float* p = features_.data();
    const auto n = static_cast<std::size_t>(cells());
    return {p, p + n, p + 2 * n, p + 3 * n, p + 4 * n};
  }

  static constexpr int kRowSumArrays = 8, kFeatureLayers = 5, kSupportArrays = 7;
  static constexpr int kCursor = kernels::kRejectCodes;  //!< place in counters_ after the reasons

  Executor executor_;
  kernels::Config host_config_;
  FrameReport report_;
  int n_points_ = 0;
  kernels::PointsIn in_{};

  Buffer<kernels::Config> config_;
  Buffer<kernels::FrameContext> context_;
  // persistent, storage order
  Buffer<float> ground_, ground_var_, elevation_, elevation_var_;
  Buffer<std::uint8_t> state_, misses_;
  // of one frame
  Buffer<std::int32_t> point_cell_;
  Buffer<std::uint32_t> point_rank_, cell_count_, cell_begin_, counters_;
  Buffer<float> point_height_, point_variance_;
  Buffer<kernels::HeightPoint> sorted_;
  Buffer<std::uint64_t> voxel_key_, voxel_winner_;
  Buffer<std::uint32_t> voxel_slot_;
  Buffer<std::uint8_t> voxel_kept_, role_;
  Buffer<std::int32_t> rays_, surface_ground_, surface_height_, row_sums_;
  Buffer<std::uint32_t> marks_;
  Buffer<float> top_hit_, support_, ray_bound_;
  // derived layers, window order
  Buffer<float> features_, exported_;
};

template <class Executor>
void Pipeline<Executor>::begin(const Frame& frame, const kernels::FrameContext& context)
{
  executor_.start_clock();
  report_ = {};
  report_.stamp_s = frame.stamp_s;
  report_.points_in = static_cast<std::uint32_t>(frame.size);
  n_points_ = context.n_points;
  reserve_points(frame.size);
  executor_.upload(&context, 1, context_);
  in_ = executor_.upload_points(frame);
}

template <class Executor>
FrameReport Pipeline<Executor>::end(const Frame& frame)
{
  executor_.download(counters_, report_.rejected.data(), kRejectCount);
  report_.points_accepted = static_cast<std::uint32_t>(frame.size);
  for (const auto r : report_.rejected) report_.points_accepted -= r;
  report_.total_ms = executor_.total_ms();
  return report_;
}

template <class Executor>
void Pipeline<Executor>::lap(int stage)
{
  report_.stage_ms[static_cast<std::size_t>(stage)] = executor_.lap_ms();
}

template <class Executor>
void Pipeline<Executor>::allocate_cells()
{
  const auto n = static_cast<std::size_t>(cells());
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
    executor_.allocate(*b, n, kernels::kNan);
  for (auto* b : {&state_, &misses_, &role_}) executor_.allocate(*b, n, std::uint8_t{0});
  for (auto* b : {&cell_count_, &cell_begin_}) executor_.allocate(*b, n, std::uint32_t{0});
  for (auto* b : {&top_hit_, &ray_bound_, &exported_}) executor_.allocate(*b, n, 0.0f);
  const auto pooled = static_cast<std::size_t>(kernels::support_side(host_config_));
  executor_.allocate(support_, kSupportArrays * pooled * pooled, 0.0f);
  executor_.allocate(counters_, kCursor + 1, std::uint32_t{0});
  executor_.allocate(features_, kFeatureLayers * n, kernels::kNan);
  executor_.allocate(row_sums_, kRowSumArrays * n, std::int32_t{0});
  const auto padded = static_cast<std::size_t>(surfaces().pitch) * static_cast<std::size_t>(side());
  for (auto* b : {&surface_ground_, &surface_height_})
    executor_.allocate(*b, padded, kernels::kNoHeight);
  executor_.allocate(
      rays_,
      static_cast<std::size_t>(kernels::ring_count(host_config_)) *
          static_cast<std::size_t>(kernels::bin_count(host_config_)),
      kernels::kNoRay);
  executor_.allocate(
      marks_,
      static_cast<std::size_t>(kernels::line_count(host_config_)) *
          static_cast<std::size_t>(kernels::words_per_line(host_config_)),
      std::uint32_t{0});
}

/** Grows the buffers of points; by powers of two, so that a run settles after a few frames. */
template <class Executor>
void Pipeline<Executor>::reserve_points(std::size_t points)
{
  if (points <= point_cell_.size()) return;
  std::size_t capacity = 1024;
  while (capacity < points) capacity *= 2;
  executor_.allocate(point_cell_, capacity, std::int32_t{-1});
  executor_.allocate(point_rank_, capacity, std::uint32_t{0});
  executor_.allocate(point_height_, capacity, 0.0f);
  executor_.allocate(point_variance_, capacity, 0.0f);
  executor_.allocate(sorted_, capacity, kernels::HeightPoint{0, 0});
  if (host_config_.inverse_voxel > 0)
  {
    executor_.allocate(voxel_slot_, capacity, std::uint32_t{0});
    executor_.allocate(voxel_kept_, capacity, std::uint8_t{0});
    executor_.allocate(voxel_key_, 2 * capacity, kernels::kNoVoxel);
    executor_.allocate(voxel_winner_, 2 * capacity, kernels::kNoVoxel);
  }
}

template <class Executor>
void Pipeline<Executor>::read_layer(Layer layer, float* out)
{
  const auto n = static_cast<std::size_t>(cells());
  if (layer >= Layer::Slope)
  {
    const auto index = static_cast<std::size_t>(layer) - static_cast<std::size_t>(Layer::Slope);
    executor_.download(features_, out, n, index * n);
    return;
  }
  const float* source = layer == Layer::Elevation         ? elevation_.data()
                        : layer == Layer::GroundElevation ? ground_.data()
                                                          : ground_var_.data();
  const std::uint8_t* state = layer == Layer::State ? state_.data() : nullptr;
  for_each_cell(
      kernels::ExportCell{config_.data(), context_.data(), source, state, exported_.data()});
  executor_.download(exported_, out, n);
}

template <class Executor>
MapBytes Pipeline<Executor>::read_all()
{
  const auto n = static_cast<std::size_t>(cells());
  MapBytes bytes;
  bytes.cells.resize(n * (4 * sizeof(float) + 2));
  std::uint8_t* to = bytes.cells.data();
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
  {
    executor_.download(*b, reinterpret_cast<float*>(to), n);
    to += n * sizeof(float);
  }
  for (auto* b : {&state_, &misses_}) executor_.download(*b, to, n), to += n;
  bytes.features.resize(kFeatureLayers * n);
  executor_.download(features_, bytes.features.data(), kFeatureLayers * n);
  return bytes;
}

template <class Executor>
void Pipeline<Executor>::write_all(const MapBytes& bytes, const kernels::FrameContext& window)
{
  const auto n = static_cast<std::size_t>(cells());
  const std::uint8_t* from = bytes.cells.data();
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
  {
    executor_.upload(reinterpret_cast<const float*>(from), n, *b);
    from += n * sizeof(float);
  }
  for (auto* b : {&state_, &misses_}) executor_.upload(from, n, *b), from += n;
  executor_.upload(bytes.features.data(), kFeatureLayers * n, features_);
  executor_.upload(&window, 1, context_);
}

}  // namespace talus
