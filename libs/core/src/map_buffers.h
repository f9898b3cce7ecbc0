#pragma once
#include "backend.h"
#include "hand_over.h"
#include "kernels/1_buried_rays.h"
#include "kernels/1_voxel_filter.h"
#include "kernels/1_points.h"
#include "kernels/2_follow.h"
#include "kernels/2_roll.h"
#include "kernels/3_update.h"
#include "kernels/4_classify.h"
#include "kernels/4_reach.h"
#include "kernels/4_start.h"
#include "kernels/4_underfoot.h"
#include "kernels/5_cleanup.h"
#include "kernels/6_fill.h"
#include "kernels/6_variance.h"
#include "kernels/7_judge.h"
#include "kernels/8_label.h"
#include "kernels/9_channels.h"

#include <algorithm>
#include <array>

namespace talus
{
/** The memory of a map, and views of it for the kernels. Buffers of only one schedule belong to
 * that schedule. */
template <class ExecutorType>
struct MapBuffers
{
  using Executor = ExecutorType;
  using Atomics = typename Executor::Atomics;
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;

  explicit MapBuffers(const MapConfig& c)
      : host_config(c.config),
        host_body(c.body),
        channels(c.channels.begin(), c.channels.end()),
        host_class_scores(c.class_scores)
  {
  }

  // ---- memory: by the size of the map once, by its largest frame so far ----
  void allocate(Executor& executor);
  /** Grows the buffers of points in steps of at least an eighth, so that a run soon stops growing;
   * then calls more(capacity), for buffers of the schedule. */
  template <class More>
  void reserve_points(Executor& executor, std::size_t points, const More& more);
  /** Makes room for slope, step, roughness and sparsity. */
  void allocate_parts(Executor& executor)
  {
    const std::size_t size = kParts * static_cast<std::size_t>(cells());
    if (now->parts.size() != size) executor.allocate(now->parts, size, kernels::kNan);
  }

  int side() const { return host_config.cells; }
  int cells() const { return side() * side(); }
  kernels::LineGrid line_grid() const { return kernels::line_grid(host_config); }
  std::size_t grid_size() const
  {
    return static_cast<std::size_t>(line_grid().side) * static_cast<std::size_t>(line_grid().pitch);
  }
  /** Places of the rows beyond the window that TellVariance asks, on one side, and of one more: in
   * the last of them it asks a place before its first. */
  std::size_t margin_size() const
  {
    return (kernels::kAskedPlaces + 1) * static_cast<std::size_t>(line_grid().pitch);
  }
  /** The number of points of a loop. */
  int points(const Executor& executor) const
  {
    return executor.loop_size(now->n_points, point_cell.size());
  }

  // ---- views: each member by its name, since two arrays of one type could change places ----
  kernels::CellStore store()
  {
    kernels::CellStore v{};
#define TALUS_VIEW(type, name, unknown) v.name = cell.name.data();
    TALUS_CELL_FIELDS(TALUS_VIEW)
#undef TALUS_VIEW
    return v;
  }
  kernels::PointsOut points_out()
  {
    kernels::PointsOut v{};
    v.cell = point_cell.data();
    v.ray = point_ray.data();
    v.slope = point_slope.data();
    v.reach = point_reach.data();
    v.reject = point_reject.data();
    v.rank = point_rank.data();
    v.height_m = point_height.data();
    v.variance_m2 = point_variance.data();
    return v;
  }
  kernels::AcceptPoint<Atomics> accept(const std::uint8_t* kept)
  {
    auto v = in_frame<kernels::AcceptPoint<Atomics>>();
    v.body = body.data();
    v.in = now->in;
    v.out = points_out();
    v.rays = rays.data();
    v.rejected = counters.data();
    v.voxel_kept = kept;
    return v;
  }
  kernels::RollCell roll()
  {
    auto v = on_cells<kernels::RollCell>();
    v.datum = datum.data();
    return v;
  }
  kernels::ForgetHits forget_hits()
  {
    kernels::ForgetHits v{};
    v.top_hit_m = top_hit.data();
    return v;
  }
  kernels::FindGroundHits ground_hits()
  {
    auto v = on_cells<kernels::FindGroundHits>();
    v.datum = datum.data();
    return v;
  }
  kernels::CountOffset<Atomics> count_offset()
  {
    return {config.data(), store(), datum.data(), points_out(), offsets.data()};
  }
  kernels::FollowPoses follow()
  {
    return {
        config.data(), context.data(), offsets.data(), datum.data(),
        counters.data() + kernels::kLeavesFloor};
  }
  kernels::SortPoint sort_point(const kernels::Sorting& sorting)
  {
    return {config.data(), context.data(), points_out(), rays.data(), sorting};
  }
  kernels::UpdateCell update_cell(const kernels::Sorting& sorting)
  {
    return {config.data(), context.data(), store(), points_out(), sorting, top_hit.data()};
  }
  kernels::FindPassingRays find_passing_rays()
  {
    return {config.data(), context.data(), rays.data(), passing()};
  }
  kernels::CoarseGrid coarse_grid()
  {
    kernels::CoarseGrid v{};
    v.side = kernels::coarse_side(host_config);
    v.pad = kernels::dilation_radius(host_config);
    v.lowest_m = lowest_ground.data();
    v.eroded_m = eroded_ground.data();
    v.cone_m = ground_cone.data();
    v.known_m = known_ground.data();
    v.column_m = column.data();
    v.apart_m = ground_apart.data();
    v.foot_m = foot.data();
    v.things_m = things.data();
    v.beside_m = beside.data();
    v.presence = presence.data();
    v.limit_m = ground_limit.data();
    v.reach = pair_reach.data();
    return v;
  }
  kernels::RayReach ray_reach() { return {context.data(), reach.data()}; }
  kernels::StandOnCell<Atomics> stand_on()
  {
    auto v = on_cells<kernels::StandOnCell<Atomics>>();
    v.datum = datum.data();
    return v;
  }
  kernels::PresumeStart presume_start()
  {
    auto v = on_cells<kernels::PresumeStart>();
    v.passing = passing();
    return v;
  }
  kernels::StartReach start_reach() { return on_cells<kernels::StartReach>(); }
  kernels::ForgetFill forget_fill() { return on_cells<kernels::ForgetFill>(); }
  /** PoolReach or PoolCells; of the frame the place of the window counts, and the base. */
  template <class Pool>
  Pool pool(const kernels::FrameContext* frame)
  {
    return {config.data(), frame, store(), coarse_grid()};
  }
  /** ClassifyCell or LowerObject. */
  template <class Rule = kernels::ClassifyCell>
  Rule classify()
  {
    auto v = on_cells<Rule>();
    v.grid = coarse_grid();
    v.surface_class = surface_class.data();
    return v;
  }
  kernels::CleanUpCell clean_up()
  {
    kernels::CleanUpCell v{};
    v.cells = side();
    v.config = config.data();
    v.store = store();
    v.passing = passing();
    v.reach = ray_reach();
    v.grid = coarse_grid();
    v.top_hit_m = top_hit.data();
    v.surface_class = surface_class.data();
    return v;
  }
  kernels::PassingRays passing()
  {
    return {line_grid(), free_above.data(), ends.data(), lowest_ray.data(), in_open.data()};
  }
  kernels::Samples samples()
  {
    kernels::Samples v{};
    v.height_m = sample_height.data() + margin_size();
    v.free_above_m = free_above.data(), v.ends_m = ends.data();
    return v;
  }
  kernels::FillCell fill_cell()
  {
    auto v = on_cells<kernels::FillCell>();
    v.cells = side();
    v.surface_class = surface_class.data();
    v.passing = passing();
    v.grid = coarse_grid();
    v.surfaces = surfaces();
    v.out = surface_layers();
    return v;
  }
  kernels::Surfaces surfaces()
  {
    const int pad = host_config.feature_radius_cells;
    return {judged_surfaces.data(), side() + 2 * pad, pad};
  }
  /** `passability`: the schedule's array; null for judge(). */
  template <bool kParts>
  kernels::ComputeFeatures<kParts> compute_features(std::uint8_t* passability)
  {
    kernels::ComputeFeatures<kParts> v{};
    v.cells = side();
    v.config = config.data();
    v.surfaces = surfaces();
    v.grid = line_grid();
    v.fall_m = fall.data();
    v.out = feature_layers();
    v.passability = passability;
    return v;
  }
  kernels::CompleteObstacles complete_obstacles(const std::uint8_t* passability, bool notes = true)
  {
    float* const scores = feature(Layer::Traversability);
    const kernels::CellStore to = notes ? store() : kernels::CellStore{};
    return {side(),      config.data(), surfaces(),
            passability, scores,        {side(), context.data(), to, scores}};
  }

  /** The memory of a wanted layer of stages 2 to 6: the caller's if kernels reach it. */
  float* surface(Layer layer)
  {
    const auto l = static_cast<std::size_t>(layer);
    if (!now->wanted[l]) return nullptr;
    const OutputMemory& output = now->outputs[l];
    return output.direct ? output.mapped
                         : now->delivered.data() + l * static_cast<std::size_t>(cells());
  }
  /** where(layer) for the layers of stages 2 to 6, in the order of SurfaceLayers. */
  template <class Where>
  static kernels::SurfaceLayers surfaces_at(const Where& where)
  {
    return {
        where(Layer::Elevation), where(Layer::GroundElevation), where(Layer::State),
        where(Layer::Reached)};
  }
  kernels::SurfaceLayers surface_layers()
  {
    return surfaces_at([this](Layer l) { return surface(l); });
  }
  /** Copies a layer of the map to window order. */
  kernels::PutSurface export_surface(Layer layer, float* to)
  {
    return {
        config.data(), context.data(), store(),
        surfaces_at([=](Layer l) { return l == layer ? to : nullptr; })};
  }
  /** The samples are no longer needed when the ground is laid out in their place. */
  kernels::LayOutGround lay_out_ground()
  {
    auto v = on_cells<kernels::LayOutGround>();
    v.grid = line_grid();
    v.ground_m = samples().height_m;
    return v;
  }
  /** Tells the variance of cells in window order, from the ground laid out. */
  kernels::TellVariance tell_variance(float* to) { return {lay_out_ground(), to}; }
  /** Reads cells of the window of the frame before. */
  ReadCell read_cell(const WindowRects& rects) { return ReadCell{hand_over(rects)}; }
  WriteCell write_cell(const WindowRects& rects)
  {
    const auto shown = [this](Layer l) { return now->outputs[static_cast<std::size_t>(l)].mapped; };
    return {hand_over(rects), surfaces_at(shown), shown(Layer::Traversability)};
  }
  /** Labels of points of any frame, given in the window of the map. */
  kernels::LabelPoint label_point(
      const kernels::FrameContext* frame, const kernels::PointsIn& in, const std::int32_t* moved)
  {
    kernels::ClassifyCell classify_cell = classify();
    classify_cell.frame = frame;
    return {config.data(), frame, body.data(), datum.data(), store(), classify_cell, in, moved};
  }
  /** The channels of the map, with the values of the current frame. */
  kernels::Channels channels_view()
  {
    kernels::Channels v{};
    for (ChannelBuffers& c : channels)
    {
      kernels::Channel& channel = v.each[v.size];
      channel.rule = c.rule;
      channel.of_points = now->channels[static_cast<std::size_t>(v.size++)];
      channel.sums = c.sums.data();
      channel.values = c.values.data();
      channel.votes = c.votes.size() ? c.votes.data() : nullptr;
    }
    return v;
  }
  kernels::ForgetChannels forget_channels()
  {
    return {config.data(), context.data(), channels_view()};
  }
  kernels::PlacePoint place_point()
  {
    return {config.data(), context.data(),       store(),
            points_out(),  surface_class.data(), point_surface.data()};
  }
  kernels::SettleChannel settle_channel(const kernels::Channel& channel)
  {
    return {config.data(), store(), channel};
  }
  kernels::ShownChannels shown_channels()
  {
    return {config.data(), store(), surface_class.data(), channels_view()};
  }
  kernels::PutChannel put_channel(std::size_t channel, int surface, float* to)
  {
    return {shown_channels(), context.data(), static_cast<int>(channel), surface, to};
  }
  bool has_class_scores() const { return !host_class_scores.empty(); }
  kernels::TakeClassScores take_class_scores()
  {
    return {shown_channels(), context.data(), class_scores.data(), feature(Layer::Traversability)};
  }
  ReadChannels read_channels(const WindowRects& rects)
  {
    return {hand_over(rects), shown_channels()};
  }
  WriteChannels write_channels(const WindowRects& rects)
  {
    return {hand_over(rects), channels_view()};
  }
  /** Whether each frame leaves slope, step, roughness or sparsity. */
  bool parts_wanted() const
  {
    const auto first = now->wanted.begin() + static_cast<int>(Layer::Slope);
    return std::any_of(first, first + kParts, [](const float* to) { return to; });
  }
  /** The memory of a layer of stage 7: the caller's if kernels reach it; null: not wanted. */
  float* feature(Layer layer)
  {
    const auto l = static_cast<std::size_t>(layer);
    if (now->outputs[l].direct) return now->outputs[l].mapped;
    if (layer == Layer::Traversability) return now->traversability.data();
    const std::size_t index = l - static_cast<std::size_t>(Layer::Slope);
    float* const parts = now->parts.data();
    return now->parts.size() ? parts + index * static_cast<std::size_t>(cells()) : nullptr;
  }
  kernels::FeatureLayers feature_layers()
  {
    kernels::FeatureLayers v{};
    v.slope = feature(Layer::Slope);
    v.step = feature(Layer::Step);
    v.roughness = feature(Layer::Roughness);
    v.sparsity = feature(Layer::Sparsity);
    v.traversability = feature(Layer::Traversability);
    return v;
  }
  /** Whether a wanted layer is computed elsewhere and then copied. */
  bool is_copied(Layer layer) const
  {
    const auto l = static_cast<std::size_t>(layer);
    return now->wanted[l] && !now->outputs[l].direct;
  }
  int copied_surfaces() const { return copied(kFirstSurface, kFirstFeature); }
  int copied_features() const { return copied(kFirstFeature, kLayerCount); }
  /** Copies the rows [first_row, end_row) of such layers. */
  void deliver_surfaces(Executor& executor, int first_row, int end_row)
  {
    for (int l = kFirstSurface; l < kFirstFeature; l++)
      if (const auto layer = static_cast<Layer>(l); layer != Layer::Variance)
        deliver(executor, layer, surface(layer), first_row, end_row);
  }
  /** It is told when the ground of all cells is known. */
  void deliver_variance(Executor& executor)
  {
    deliver(executor, Layer::Variance, surface(Layer::Variance), 0, side());
  }
  void deliver_features(Executor& executor, int first_row, int end_row)
  {
    for (int l = kFirstFeature; l < kLayerCount; l++)
      deliver(executor, static_cast<Layer>(l), feature(static_cast<Layer>(l)), first_row, end_row);
  }
  /** Surface layers come first, then the layers of stage 7. */
  static constexpr int kFirstSurface = static_cast<int>(Layer::Elevation);
  static constexpr int kFirstFeature = static_cast<int>(Layer::Slope);
  static constexpr int kFeatureLayers = kLayerCount - kFirstFeature, kParts = kFeatureLayers - 1;

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
    Buffer<float> traversability, parts, delivered;
    bool parts_known = false;  //!< `parts` belong to the current map
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
  Buffer<float> class_scores;
  std::array<Slot, kSlots> slots;
  Slot* now = slots.data();  //!< of the current frame

  Buffer<kernels::Config> config;
  Buffer<kernels::FrameContext> context;
  Buffer<kernels::Body> body;
  // Persistent, storage order: one array for each field.
  struct CellBuffers
  {
#define TALUS_BUFFER(type, name, unknown) Buffer<type> name;
    TALUS_CELL_FIELDS(TALUS_BUFFER)
#undef TALUS_BUFFER
  };
  /** f(buffer, value for unknown) for each field. */
  template <class F>
  void for_each_field(const F& f)
  {
#define TALUS_EACH(type, name, unknown) f(cell.name, static_cast<type>(unknown));
    TALUS_CELL_FIELDS(TALUS_EACH)
#undef TALUS_EACH
  }
  CellBuffers cell;
  Buffer<kernels::Datum> datum;
  // Points of one frame.
  Buffer<std::int32_t> point_cell, point_ray, point_reach, point_surface;
  Buffer<std::uint8_t> point_begins;
  Buffer<std::uint32_t> point_reject, point_rank, cell_count, cell_begin, counters;
  Buffer<float> point_slope, point_height, point_variance;
  Buffer<kernels::HeightPoint> sorted;
  Buffer<std::uint64_t> voxel_key, voxel_winner;
  Buffer<std::uint32_t> voxel_slot;
  Buffer<std::uint8_t> voxel_kept;
  // Rays, by direction and ring.
  Buffer<std::int32_t> rays, reach;
  Buffer<float> lowest_slope;
  Buffer<kernels::OffsetHistogram> offsets;
  // Cells, in window order unless noted.
  Buffer<float> top_hit;  //!< storage order
  Buffer<std::uint8_t> surface_class;  //!< storage order
  Buffer<float> lowest_ground, known_ground, eroded_ground, ground_cone, ground_apart, foot, things,
      beside, presence, column, ground_limit;  //!< coarse grid
  Buffer<std::int32_t> pair_reach;  //!< coarse grid
  Buffer<float> sample_height, fall;  //!< grid of lines; of samples with margins, see samples()
  Buffer<float> free_above, ends, lowest_ray;  //!< grid of lines, see PassingRays
  Buffer<std::uint8_t> in_open;  //!< grid of lines
  Buffer<kernels::Surface> judged_surfaces;

 private:
  /** Makes a view that begins with what all stages read. */
  template <class View>
  View in_frame()
  {
    View v{};
    v.config = config.data();
    v.frame = context.data();
    return v;
  }
  template <class View>
  View on_cells()
  {
    View v = in_frame<View>();
    v.store = store();
    return v;
  }
  HandOver hand_over(const WindowRects& rects)
  {
    return {config.data(), context.data(), store(), feature(Layer::Traversability), rects};
  }
  int copied(int first, int end) const
  {
    int n = 0;
    for (int l = first; l < end; l++) n += is_copied(static_cast<Layer>(l));
    return n;
  }
  void deliver(Executor& executor, Layer layer, const float* from, int first_row, int end_row)
  {
    if (!is_copied(layer)) return;
    const auto first = static_cast<std::size_t>(first_row) * static_cast<std::size_t>(side());
    const auto end = static_cast<std::size_t>(end_row) * static_cast<std::size_t>(side());
    executor.copy(now->wanted[static_cast<std::size_t>(layer)] + first, from + first, end - first);
  }
};

template <class Executor>
void MapBuffers<Executor>::allocate(Executor& executor)
{
  const auto n = static_cast<std::size_t>(cells());
  for_each_field([&](auto& array, auto unknown) { executor.allocate(array, n, unknown); });
  executor.allocate(surface_class, n, std::uint8_t{0});
  for (auto* b : {&cell_count, &cell_begin}) executor.allocate(*b, n, std::uint32_t{0});
  executor.allocate(top_hit, n, 0.0f);
  executor.allocate(datum, 1, kernels::Datum{});
  executor.allocate(offsets, 1, kernels::OffsetHistogram{});
  const auto pooled = static_cast<std::size_t>(kernels::coarse_side(host_config));
  const std::size_t pad = 2 * static_cast<std::size_t>(kernels::dilation_radius(host_config));
  for (auto* b :
       {&lowest_ground, &known_ground, &eroded_ground, &ground_cone, &ground_apart, &foot, &things,
        &beside, &presence, &column, &ground_limit})
    executor.allocate(*b, pooled * (pooled + pad), kernels::kInfinity);
  executor.allocate(pair_reach, pooled * (pooled + pad), std::int32_t{kernels::kOutsideWindow});
  for (auto* b : {&fall, &free_above, &ends, &lowest_ray})
    executor.allocate(*b, grid_size(), kernels::kNan);
  executor.allocate(in_open, grid_size(), std::uint8_t{0});
  executor.allocate(sample_height, grid_size() + 2 * margin_size(), kernels::kNan);
  executor.allocate(config, 1, kernels::Config{});
  executor.allocate(context, 1, kernels::FrameContext{});
  executor.allocate(counters, kernels::kCounters, std::uint32_t{0});
  const auto padded = static_cast<std::size_t>(surfaces().pitch) * static_cast<std::size_t>(side());
  executor.allocate(judged_surfaces, padded, kernels::Surface{kernels::kNoHeight, 0});
  const auto bins = static_cast<std::size_t>(kernels::bin_count(host_config));
  const std::size_t table = bins * static_cast<std::size_t>(kernels::most_rings(side()));
  executor.allocate(rays, table, kernels::kNoRay);
  executor.allocate(reach, bins * kernels::kSlopeSteps, std::int32_t{0});
  executor.allocate(lowest_slope, table, -kernels::kInfinity);
  executor.upload(&host_config, 1, config.data());
  for (ChannelBuffers& c : channels)
  {
    executor.allocate(c.sums, kernels::kPointSurfaces * n, kernels::ChannelSum{});
    executor.allocate(c.values, kernels::kPointSurfaces * n, kernels::ChannelValue{});
    const bool votes = c.rule == kernels::kVote;
    executor.allocate(c.votes, votes ? kernels::kPointSurfaces * n : 0, kernels::ChannelVotes{});
  }
  executor.allocate(class_scores, host_class_scores.size(), 0.0f);
  executor.upload(host_class_scores.data(), host_class_scores.size(), class_scores.data());
  executor.allocate(body, 1, kernels::Body{});
  executor.upload(&host_body, 1, body.data());
}

template <class Executor>
template <class More>
void MapBuffers<Executor>::reserve_points(Executor& executor, std::size_t points, const More& more)
{
  if (points <= point_cell.size() && point_cell.size() != 0) return;
  std::size_t step = 1024;
  while (8 * step < points) step *= 2;
  const std::size_t capacity = std::max<std::size_t>(1, (points + step - 1) / step) * step;
  // The size of the first buffer stands for all: if memory ends half-way it must be zero.
  executor.allocate(point_cell, 0, std::int32_t{-1});
  for (auto* b : {&point_ray, &point_reach}) executor.allocate(*b, capacity, std::int32_t{-1});
  executor.allocate(point_slope, capacity, 0.0f);
  for (auto* b : {&point_reject, &point_rank}) executor.allocate(*b, capacity, std::uint32_t{0});
  executor.allocate(point_height, capacity, 0.0f);
  executor.allocate(point_variance, capacity, 0.0f);
  executor.allocate(sorted, capacity, kernels::HeightPoint{0, 0});
  if (!channels.empty())
  {
    executor.allocate(point_surface, capacity, std::int32_t{kernels::kNoSurface});
    executor.allocate(point_begins, capacity, std::uint8_t{0});
  }
  more(capacity);
  if (host_config.inverse_voxel > 0)
  {
    executor.allocate(voxel_slot, capacity, std::uint32_t{0});
    executor.allocate(voxel_kept, capacity, std::uint8_t{0});
    executor.allocate(voxel_key, 16 * step, kernels::kNoVoxel);
    executor.allocate(voxel_winner, 16 * step, kernels::kNoVoxel);
  }
  executor.allocate(point_cell, capacity, std::int32_t{-1});
}

}  // namespace talus
