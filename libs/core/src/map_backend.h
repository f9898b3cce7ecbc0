#pragma once
#include "map_buffers.h"

#include <algorithm>

namespace talus
{
/** A map whose frames run through a schedule of the nine stages: what is around them. How frames
 * come and go, and how layers leave and come back. */
template <class Schedule>
class MapBackend final : public BackendInterface
{
  using Executor = typename Schedule::Executor;
  using Map = MapBuffers<Executor>;

 public:
  MapBackend(const MapConfig& config, Executor executor)
      : map_(config), schedule_(map_, executor_), executor_(std::move(executor))
  {
    map_.allocate(executor_);
    schedule_.allocate();
  }

  void start(int slot, const Frame& frame, const kernels::FrameContext& context) override
  {
    use(slot);
    reserve_points(frame.size);
    map_.now->stamp_s = frame.stamp_s;
    map_.now->n_points = context.n_points;
    map_.now->in = executor_.stage(frame, context, map_.point_cell.size());
    executor_.start_frame([this] { schedule_.stages(); });
  }
  FrameReport finish(int slot) override
  {
    use(shown_ = slot);
    executor_.finish_frame([this] { schedule_.stages(); });
    map_.now->parts_known = map_.parts_wanted();
    return report();
  }

  PointArrays point_arrays(int slot, std::size_t size) override
  {
    use(slot);
    reserve_points(size);
    return executor_.point_arrays(map_.point_cell.size());
  }
  std::array<bool, kLayerCount> set_outputs(int slot, const OutputPointers& host) override;
  void read_layer(Layer layer, float* out) override;
  void read_cells(const std::vector<WindowRect>& rects, std::vector<CellRecord>& to) override;
  void write_cells(
      const std::vector<WindowRect>& rects, const std::vector<CellRecord>& from) override;
  MapBytes read_all() override;
  void write_all(const MapBytes& bytes, const kernels::FrameContext& window) override;
  std::string name() const override { return executor_.name(); }

 private:
  void use(int slot)
  {
    map_.now = &map_.slots[static_cast<std::size_t>(slot)];
    executor_.use(slot);
  }
  void reserve_points(std::size_t points)
  {
    map_.reserve_points(
        executor_, points, [this](std::size_t capacity) { schedule_.reserve_points(capacity); });
  }
  FrameReport report();
  void complete_parts();
  void export_surface(Layer layer, float* to)
  {
    executor_.for_each_cell(map_.side(), map_.side(), map_.export_surface(layer, to));
  }
  /** Loops over the cells of rectangles, as `How` does with a HandOver. */
  template <class How>
  void hand_over(const std::vector<WindowRect>& rects)
  {
    CellRecord* records = records_.data();
    for (const WindowRect& rect : rects)
    {
      executor_.for_each_cell(rect.width, rect.height, How{map_.hand_over(rect, records)});
      records += rect.width * rect.height;
    }
  }
  static Layer feature_layer(std::size_t i)
  {
    return static_cast<Layer>(static_cast<std::size_t>(Layer::Slope) + i);
  }

  Map map_;
  Schedule schedule_;
  int shown_ = 0;  //!< the slot of the frame that was finished last
  typename Executor::template HostBuffer<CellRecord> records_;  //!< that are handed over
  Executor executor_;  //!< the last member: what it does ends before the memory goes
};

template <class Schedule>
FrameReport MapBackend<Schedule>::report()
{
  FrameReport report;
  report.stamp_s = map_.now->stamp_s;
  report.points_in = static_cast<std::uint32_t>(map_.now->n_points);
  std::copy_n(executor_.reported(), kRejectCount, report.rejected.data());
  report.leaves_floor = executor_.reported()[kernels::kLeavesFloor] != 0;
  report.points_accepted = report.points_in;
  for (const auto r : report.rejected) report.points_accepted -= r;
  report.stage_ms = executor_.stage_ms();
  report.total_ms = executor_.total_ms();
  return report;
}

template <class Schedule>
std::array<bool, kLayerCount> MapBackend<Schedule>::set_outputs(
    int slot, const OutputPointers& host)
{
  use(slot);
  auto& now = *map_.now;
  std::array<bool, kLayerCount> delivered{};
  executor_.forget_outputs();
  const auto n = static_cast<std::size_t>(map_.cells());
  for (std::size_t l = 0; l < host.size(); l++)
  {
    now.outputs[l] = host[l] ? executor_.map_output(host[l], n) : OutputMemory{false, nullptr};
    delivered[l] = now.outputs[l].reachable;
    now.wanted[l] = delivered[l] ? host[l] : nullptr;
  }
  constexpr auto surfaces = static_cast<std::size_t>(Layer::Slope);
  executor_.allocate(now.delivered, map_.copied_surfaces() ? surfaces * n : 0, 0.0f);
  executor_.allocate(now.traversability, n, kernels::kNan);
  if (map_.parts_wanted()) map_.allocate_parts(executor_);
  return delivered;
}

/** What traversability is made of, if the last frame did not leave it: judges once more, with the
 * same result. */
template <class Schedule>
void MapBackend<Schedule>::complete_parts()
{
  if (map_.now->parts_known) return;
  map_.allocate_parts(executor_);
  schedule_.judge_parts();
  map_.now->parts_known = true;
}

template <class Schedule>
void MapBackend<Schedule>::read_layer(Layer layer, float* out)
{
  use(shown_);
  const float* from = map_.top_hit.data();  // free between frames
  if (layer < Layer::Slope)
    export_surface(layer, map_.top_hit.data());
  else
  {
    if (layer != Layer::Traversability) complete_parts();
    from = map_.feature(layer);
  }
  if (from != out) executor_.download(from, static_cast<std::size_t>(map_.cells()), out);
}

template <class Schedule>
void MapBackend<Schedule>::read_cells(
    const std::vector<WindowRect>& rects, std::vector<CellRecord>& to)
{
  use(shown_);
  executor_.make_room(records_, to.size());
  hand_over<ReadCell>(rects);
  executor_.synchronize();
  std::copy_n(records_.data(), to.size(), to.data());
}

template <class Schedule>
void MapBackend<Schedule>::write_cells(
    const std::vector<WindowRect>& rects, const std::vector<CellRecord>& from)
{
  use(shown_);
  executor_.make_room(records_, from.size());
  std::copy_n(from.data(), from.size(), records_.data());
  hand_over<WriteCell>(rects);
  executor_.synchronize();
}

template <class Schedule>
MapBytes MapBackend<Schedule>::read_all()
{
  const auto n = static_cast<std::size_t>(map_.cells());
  use(shown_);
  MapBytes bytes;
  bytes.cells.resize(n * kBytesPerCell);
  std::uint8_t* to = bytes.cells.data();
  for (auto* b : {&map_.ground, &map_.ground_var, &map_.elevation, &map_.elevation_var})
  {
    executor_.download(b->data(), n, reinterpret_cast<float*>(to));
    to += n * sizeof(float);
  }
  for (auto* b : {&map_.state, &map_.ray_evidence}) executor_.download(b->data(), n, to), to += n;
  executor_.download(map_.persistence.data(), n, reinterpret_cast<std::int8_t*>(to));
  to += n;
  for (auto* b : {&map_.extent, &map_.footing}) executor_.download(b->data(), n, to), to += n;
  executor_.download(map_.datum.data(), 1, &bytes.datum);
  complete_parts();
  bytes.features.resize(Map::kFeatureLayers * n);
  for (std::size_t i = 0; i < Map::kFeatureLayers; i++)
    executor_.download(map_.feature(feature_layer(i)), n, bytes.features.data() + i * n);
  return bytes;
}

template <class Schedule>
void MapBackend<Schedule>::write_all(const MapBytes& bytes, const kernels::FrameContext& window)
{
  use(shown_);
  const auto n = static_cast<std::size_t>(map_.cells());
  const std::uint8_t* from = bytes.cells.data();
  for (auto* b : {&map_.ground, &map_.ground_var, &map_.elevation, &map_.elevation_var})
  {
    executor_.upload(reinterpret_cast<const float*>(from), n, b->data());
    from += n * sizeof(float);
  }
  for (auto* b : {&map_.state, &map_.ray_evidence}) executor_.upload(from, n, b->data()), from += n;
  executor_.upload(reinterpret_cast<const std::int8_t*>(from), n, map_.persistence.data());
  from += n;
  for (auto* b : {&map_.extent, &map_.footing}) executor_.upload(from, n, b->data()), from += n;
  executor_.upload(&bytes.datum, 1, map_.datum.data());
  map_.allocate_parts(executor_);
  map_.now->parts_known = true;
  for (std::size_t i = 0; i < Map::kFeatureLayers; i++)
    executor_.upload(bytes.features.data() + i * n, n, map_.feature(feature_layer(i)));
  executor_.upload(&window, 1, map_.context.data());
  for (int i = Map::kFirstSurface; i < Map::kFirstFeature; i++)
    if (float* const to = map_.surface(static_cast<Layer>(i)))
      export_surface(static_cast<Layer>(i), to);
  map_.deliver_surfaces(executor_, 0, map_.side());
  map_.deliver_features(executor_, 0, map_.side());
  executor_.synchronize();
}

}  // namespace talus
