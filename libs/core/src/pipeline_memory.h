#pragma once
#include "pipeline.h"

// What a pipeline allocates: by the size of the map once, by the size of its largest frame as it
// comes.

namespace talus
{
template <class Executor>
void Pipeline<Executor>::allocate_cells()
{
  const auto n = static_cast<std::size_t>(cells());
  for (auto* b : {&ground_, &ground_var_, &elevation_, &elevation_var_})
    executor_.allocate(*b, n, kernels::kNan);
  for (auto* b : {&state_, &passed_, &extent_, &role_, &in_open_})
    executor_.allocate(*b, n, std::uint8_t{0});
  executor_.allocate(misses_, n, std::int8_t{0});
  for (auto* b : {&cell_count_, &cell_begin_}) executor_.allocate(*b, n, std::uint32_t{0});
  executor_.allocate(passing_, 2 * n, 0.0f);
  executor_.allocate(top_hit_, n, 0.0f);
  executor_.allocate(planes_, 1, kernels::Planes{});
  const auto pooled = static_cast<std::size_t>(kernels::support_side(host_config_));
  const std::size_t pad = 2 * static_cast<std::size_t>(kernels::dilation_radius(host_config_));
  executor_.allocate(support_, kSupportArrays * pooled * (pooled + pad), kernels::kInfinity);
  executor_.allocate(across_, grid_size(), kernels::kNan);
  const std::size_t walked = Executor::kWalksLines ? grid_size() : 0;
  executor_.allocate(inferred_, walked, kernels::Inference{});
  executor_.allocate(samples_, 2 * grid_size(), kernels::kNan);
  executor_.allocate(config_, 1, kernels::Config{});
  executor_.allocate(context_, 1, kernels::FrameContext{});
  executor_.allocate(cursor_, 1, std::uint64_t{0});
  executor_.allocate(counters_, kernels::kRejectCodes, std::uint32_t{0});
  if (Executor::kWalksLines)
    executor_.allocate(judged_, n + 2 * static_cast<std::size_t>(side() + 1), kernels::kNan);
  const auto padded = static_cast<std::size_t>(surfaces().pitch) * static_cast<std::size_t>(side());
  executor_.allocate(surfaces_, padded, kernels::Surface{kernels::kNoHeight, 0});
  const auto bins = static_cast<std::size_t>(kernels::bin_count(host_config_));
  const std::size_t rays = bins * static_cast<std::size_t>(kernels::ring_count(host_config_));
  executor_.allocate(rays_, rays, kernels::kNoRay);
  executor_.allocate(reach_, bins * kernels::kSlopeSteps, std::int32_t{0});
  executor_.allocate(lowest_slope_, rays, -kernels::kInfinity);
  if (Executor::kWalksLines)
    executor_.allocate(doubted_, bins, std::uint8_t{0});
  else
    allocate_for_search();
}

template <class Executor>
void Pipeline<Executor>::allocate_for_search()
{
  executor_.allocate(kept_count_, static_cast<std::size_t>(cells()), std::uint32_t{0});
  executor_.allocate(line_of_cell_, grid_size(), std::int32_t{0});
  executor_.allocate(
      tracks_, static_cast<std::size_t>(kernels::line_count(host_config_)), kernels::Track{});
  const auto guarded = [](int words)
  { return static_cast<std::size_t>(words + 2 * kernels::LineMarks::kGuardWords); };
  executor_.allocate(
      axis_marks_,
      2 * static_cast<std::size_t>(side()) * guarded(kernels::words_per_axis(host_config_)),
      std::uint32_t{0});
  executor_.allocate(
      marks_,
      static_cast<std::size_t>(kernels::line_count(host_config_)) *
          guarded(kernels::words_per_line(host_config_)),
      std::uint32_t{0});
}

template <class Executor>
void Pipeline<Executor>::allocate_parts()
{
  const std::size_t size = kParts * static_cast<std::size_t>(cells());
  if (now_->parts.size() != size) executor_.allocate(now_->parts, size, kernels::kNan);
}

/** Grows the buffers of points in steps of at least an eighth, so that a run settles after a few
 * frames. */
template <class Executor>
void Pipeline<Executor>::reserve_points(std::size_t points)
{
  if (points <= point_cell_.size() && point_cell_.size() != 0) return;
  std::size_t step = 1024;
  while (8 * step < points) step *= 2;
  const std::size_t capacity = std::max<std::size_t>(1, (points + step - 1) / step) * step;
  // The size of the first tells that of all: where memory ends half-way it must tell of none.
  executor_.allocate(point_cell_, 0, std::int32_t{-1});
  executor_.allocate(
      crowded_, static_cast<std::size_t>(most_crowded(static_cast<int>(capacity))) + 1,
      std::int32_t{0});
  for (auto* b : {&point_ray_, &point_reach_}) executor_.allocate(*b, capacity, std::int32_t{-1});
  executor_.allocate(point_slope_, capacity, 0.0f);
  executor_.allocate(point_rank_, capacity, std::uint32_t{0});
  executor_.allocate(point_in_cell_, capacity, std::int32_t{0});
  executor_.allocate(point_height_, capacity, 0.0f);
  executor_.allocate(point_variance_, capacity, 0.0f);
  executor_.allocate(sorted_, capacity, kernels::HeightPoint{0, 0});
  if constexpr (Executor::kWalksLines) executor_.allocate(rise_, capacity, kernels::GroundRise{});
  if (host_config_.inverse_voxel > 0)
  {
    executor_.allocate(voxel_slot_, capacity, std::uint32_t{0});
    executor_.allocate(voxel_kept_, capacity, std::uint8_t{0});
    executor_.allocate(voxel_key_, 16 * step, kernels::kNoVoxel);
    executor_.allocate(voxel_winner_, 16 * step, kernels::kNoVoxel);
  }
  executor_.allocate(point_cell_, capacity, std::int32_t{-1});
}

}  // namespace talus
