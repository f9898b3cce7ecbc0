#pragma once
#include "backend.h"
#include "cuda/fill_search.h"
#include "hand_over.h"
#include "kernels/1_voxel_filter.h"
#include "kernels/2_follow.h"
#include "kernels/3_update.h"
#include "kernels/6_variance.h"
#include "kernels/map.h"

#include <algorithm>
#include <array>

namespace talus
{
/** The size of an array of a map, and how much of it lies before its first element. */
struct Extent
{
  std::size_t size = 0, before = 0;
};

struct MapSizes
{
  MapSizes(const kernels::Config& k, bool on_device);
  void set_points(const kernels::Config& k, std::size_t capacity, std::size_t step, bool channels);

  Extent one{1}, cells, pairs, grid, samples, surfaces, rays, slopes;
  Extent points, crowded, surface_points, voxel_points, voxels, class_scores;
  Extent core_bins, core_grid, core_window;
  Extent device, device_cells, device_grid, device_lines, marks, axis_marks;
  bool on_device;
};

inline MapSizes::MapSizes(const kernels::Config& k, bool device_too) : on_device(device_too)
{
  const auto size = [](int n) { return static_cast<std::size_t>(n); };
  const kernels::LineGrid lines = kernels::line_grid(k);
  const kernels::PairGrid pair = kernels::pair_grid(k);
  const std::size_t n = size(k.cells), bins = size(kernels::bin_count(k));
  // Rows beyond the window that EstimateVariance reads, and one more for the cell before the last.
  const std::size_t margin = size((kernels::kAskedCells + 1) * lines.pitch);
  cells = {n * n};
  pairs = {size(pair.side) * size(pair.side + 2 * pair.pad)};
  grid = {size(lines.side) * size(lines.pitch)};
  samples = {grid.size + 2 * margin, margin};
  surfaces = {n * size(k.cells + 2 * k.feature_radius_cells)};
  rays = {bins * size(kernels::most_rings(k.cells))};
  slopes = {bins * kernels::kSlopeBins};
  if (on_device)
  {
    constexpr std::size_t guard = kernels::LineMarks::kGuardWords;
    const std::size_t n_lines = size(kernels::line_count(k));
    device = one, device_cells = cells, device_grid = grid, device_lines = {n_lines};
    marks = {n_lines * (size(kernels::words_per_line(k)) + 2 * guard), guard * n_lines};
    axis_marks = {2 * n * (size(kernels::words_per_axis(k)) + 2 * guard), 2 * guard * n};
  }
  else
    core_bins = {bins}, core_grid = grid, core_window = {n * n + 2 * (n + 1), n + 1};
}

inline void MapSizes::set_points(
    const kernels::Config& k, std::size_t capacity, std::size_t step, bool channels)
{
  const bool filters = k.inverse_voxel > 0;
  points = {capacity};
  crowded = {on_device ? capacity / kernels::kCrowd + 1 : 2 * capacity + 1};
  surface_points = {channels ? capacity : 0};
  voxel_points = {filters ? capacity : 0};
  voxels = {filters ? 16 * step : 0};
}

namespace kernels
{
template <template <class> class Buffer>
struct MapArrays
{
  struct Cells
  {
#define TALUS_BUFFER(type, name, unknown) Buffer<type> name;
    TALUS_CELL_FIELDS(TALUS_BUFFER)
#undef TALUS_BUFFER
  } cell;
#define TALUS_BUFFER(type, name, of, first) Buffer<type> name;
  TALUS_MAP_ARRAYS(TALUS_BUFFER)
#undef TALUS_BUFFER

  /** f(buffer, value for unknown) for each field of the cells. */
  template <class F>
  void for_each_field(const F& f)
  {
#define TALUS_EACH(type, name, unknown) f(cell.name, static_cast<type>(unknown));
    TALUS_CELL_FIELDS(TALUS_EACH)
#undef TALUS_EACH
  }
  /** f(buffer, its extent, value at first) for each other array. */
  template <class F>
  void for_each_array(const MapSizes& sizes, const F& f)
  {
#define TALUS_EACH(type, name, of, first) f(name, sizes.of, static_cast<type>(first));
    TALUS_MAP_ARRAYS(TALUS_EACH)
#undef TALUS_EACH
  }
  void view(const MapSizes& sizes, Map& m)
  {
#define TALUS_VIEW(type, name, unknown) m.cell.name = cell.name.data();
    TALUS_CELL_FIELDS(TALUS_VIEW)
#undef TALUS_VIEW
#define TALUS_VIEW(type, name, of, first) m.name = name.data() + sizes.of.before;
    TALUS_MAP_ARRAYS(TALUS_VIEW)
#undef TALUS_VIEW
  }
};
}  // namespace kernels

/** The memory of a map, and the view of it that rules get. */
template <class ExecutorType>
struct MapBuffers : kernels::MapArrays<ExecutorType::template Buffer>
{
  using Executor = ExecutorType;
  using Atomics = typename Executor::Atomics;
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;

  explicit MapBuffers(const MapConfig& c)
      : host_config(c.config),
        host_body(c.body),
        channels(c.channels.begin(), c.channels.end()),
        host_class_scores(c.class_scores),
        sizes(c.config, Executor::kIsDevice)
  {
  }

  // ---- memory: by the size of the map once, by its largest frame so far ----
  void allocate(Executor& executor)
  {
    const auto n = static_cast<std::size_t>(cells());
    this->for_each_field([&](auto& array, auto unknown) { executor.allocate(array, n, unknown); });
    sizes.class_scores = {host_class_scores.size()};
    allocate_arrays(executor);
    for (ChannelBuffers& c : channels)
    {
      executor.allocate(c.sums, kernels::kPointSurfaces * n, kernels::ChannelSum{});
      executor.allocate(c.values, kernels::kPointSurfaces * n, kernels::ChannelValue{});
      const bool votes = c.rule == kernels::kVote;
      executor.allocate(c.votes, votes ? kernels::kPointSurfaces * n : 0, kernels::ChannelVotes{});
    }
    executor.transfer(
        host_class_scores.data(), host_class_scores.size(), this->class_scores.data());
    executor.transfer(&host_body, 1, this->body.data());
  }
  /** Grows the buffers of points by an eighth at least, so that a run soon stops growing. */
  void reserve_points(Executor& executor, std::size_t points)
  {
    if (points <= this->point_cell.size() && this->point_cell.size() != 0) return;
    std::size_t step = 1024;
    while (8 * step < points) step *= 2;
    const std::size_t capacity = std::max<std::size_t>(1, (points + step - 1) / step) * step;
    sizes.set_points(host_config, capacity, step, !channels.empty());
    // The size of the last buffer stands for all: if memory ends half-way it must be zero.
    executor.allocate(this->point_cell, 0, std::int32_t{-1});
    allocate_arrays(executor);
  }
  /** Makes room for slope, step, roughness and sparsity. */
  void allocate_features(Executor& executor)
  {
    const std::size_t size = kFeatures * static_cast<std::size_t>(cells());
    if (now->features.size() != size) executor.allocate(now->features, size, kernels::kNan);
  }

  int side() const { return host_config.cells; }
  int cells() const { return side() * side(); }
  int points(const Executor& executor) const
  {
    return executor.loop_size(now->n_points, this->point_cell.size());
  }

  kernels::Map view()
  {
    kernels::Map m{};
    m.k = host_config;
    m.lines = kernels::line_grid(host_config);
    m.pairs = kernels::pair_grid(host_config);
    kernels::MapArrays<ExecutorType::template Buffer>::view(sizes, m);
    if (!Executor::kIsDevice) m.kept_count = m.cell_count, m.datum_before = m.datum;
    m.in = now->in;
    m.with_features = features_wanted(), m.keeps = true;
    m.out = layers_at([this](Layer l) { return memory_of(l); });
    for (ChannelBuffers& c : channels)
    {
      kernels::Channel& channel = m.channels.each[m.channels.size];
      channel.rule = c.rule;
      channel.of_points = now->channels[static_cast<std::size_t>(m.channels.size++)];
      channel.sums = c.sums.data();
      channel.values = c.values.data();
      channel.votes = c.votes.size() ? c.votes.data() : nullptr;
    }
    m.voxel_mask = static_cast<std::uint32_t>(this->voxel_key.size() - 1);
    return m;
  }
  /** where(layer) for all layers. */
  template <class Where>
  static kernels::Layers layers_at(const Where& where)
  {
    return {where(Layer::Elevation),     where(Layer::GroundElevation), where(Layer::Variance),
            where(Layer::State),         where(Layer::Reached),         where(Layer::Slope),
            where(Layer::Step),          where(Layer::Roughness),       where(Layer::Sparsity),
            where(Layer::Traversability)};
  }

  /** The memory of a layer: the caller's if kernels reach it; null: not wanted. */
  float* memory_of(Layer layer)
  {
    const auto l = static_cast<std::size_t>(layer), n = static_cast<std::size_t>(cells());
    if (now->outputs[l].direct) return now->outputs[l].mapped;
    if (layer < Layer::Slope) return now->wanted[l] ? now->delivered.data() + l * n : nullptr;
    if (layer == Layer::Traversability) return now->traversability.data();
    const std::size_t part = l - static_cast<std::size_t>(Layer::Slope);
    return now->features.size() ? now->features.data() + part * n : nullptr;
  }
  bool has_class_scores() const { return !host_class_scores.empty(); }
  /** Whether each frame leaves slope, step, roughness or sparsity. */
  bool features_wanted() const
  {
    const auto first = now->wanted.begin() + static_cast<int>(Layer::Slope);
    return std::any_of(first, first + kFeatures, [](const float* to) { return to; });
  }
  /** Whether a wanted layer is computed elsewhere and then copied. */
  bool is_copied(Layer layer) const
  {
    const auto l = static_cast<std::size_t>(layer);
    return now->wanted[l] && !now->outputs[l].direct;
  }
  int copied_surfaces() const { return copied(kFirstSurface, kFirstFeature); }
  int copied_features() const { return copied(kFirstFeature, kLayerCount); }
  /** Copies rows of such layers; the variance follows when the ground of all cells is known. */
  void deliver_surfaces(Executor& executor, int first_row, int end_row)
  {
    for (int l = kFirstSurface; l < kFirstFeature; l++)
      if (const auto layer = static_cast<Layer>(l); layer != Layer::Variance)
        deliver(executor, layer, first_row, end_row);
  }
  void deliver_variance(Executor& executor) { deliver(executor, Layer::Variance, 0, side()); }
  void deliver_features(Executor& executor, int first_row, int end_row)
  {
    for (int l = kFirstFeature; l < kLayerCount; l++)
      deliver(executor, static_cast<Layer>(l), first_row, end_row);
  }
  /** Surface layers come first, then the layers of stage 7. */
  static constexpr int kFirstSurface = static_cast<int>(Layer::Elevation);
  static constexpr int kFirstFeature = static_cast<int>(Layer::Slope);
  static constexpr int kJudgedLayers = kLayerCount - kFirstFeature, kFeatures = kJudgedLayers - 1;

  /** The parts of a frame that another frame in flight does not share. */
  struct Slot
  {
    double stamp_s = 0;
    int n_points = 0;
    bool starts_map = false;
    kernels::PointsIn in{};
    ChannelArrays channels{};
    OutputPointers wanted{};
    std::array<OutputMemory, kLayerCount> outputs{};
    // Derived layers, window order.
    Buffer<float> traversability, features, delivered;
    bool features_known = false;  //!< `features` belong to the current map
  };

  kernels::Config host_config;
  kernels::Body host_body;
  /** Of a channel: two surfaces a cell, storage order. */
  struct ChannelBuffers
  {
    explicit ChannelBuffers(ChannelRule r) : rule(static_cast<std::int32_t>(r)) {}
    std::int32_t rule;
    Buffer<kernels::ChannelSum> sums;
    Buffer<kernels::ChannelValue> values;
    Buffer<kernels::ChannelVotes> votes;
  };
  std::vector<ChannelBuffers> channels;
  std::vector<float> host_class_scores;  //!< see MapConfig
  std::array<Slot, kSlots> slots;
  Slot* now = slots.data();  //!< of the current frame

  MapSizes sizes;

 private:
  void allocate_arrays(Executor& executor)
  {
    this->for_each_array(
        sizes,
        [&executor](auto& array, const Extent& of, auto first)
        {
          if (array.size() != of.size) executor.allocate(array, of.size, first);
        });
  }
  int copied(int first, int end) const
  {
    int n = 0;
    for (int l = first; l < end; l++) n += is_copied(static_cast<Layer>(l));
    return n;
  }
  void deliver(Executor& executor, Layer layer, int first_row, int end_row)
  {
    if (!is_copied(layer)) return;
    const auto first = static_cast<std::size_t>(first_row) * static_cast<std::size_t>(side());
    const auto end = static_cast<std::size_t>(end_row) * static_cast<std::size_t>(side());
    float* const to = now->wanted[static_cast<std::size_t>(layer)];
    executor.copy(to + first, memory_of(layer) + first, end - first);
  }
};

}  // namespace talus
