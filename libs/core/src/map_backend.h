#pragma once
#include "map_buffers.h"
#include "stages.h"

#include <algorithm>

namespace talus
{
/** A map whose frames run through the stages: it starts and finishes frames, delivers layers and
 * writes them back. `On` runs the stages. */
template <class On>
class MapBackend final : public BackendInterface
{
  using Executor = typename On::Executor;
  using Map = MapBuffers<Executor>;

 public:
  MapBackend(const MapConfig& config, Executor executor)
      : map_(config), on_(map_, executor_), executor_(std::move(executor))
  {
    map_.allocate(executor_);
    on_.prepare(map_.view());
  }

  CellRecord* start(
      int slot, const Frame& frame, const kernels::FrameContext& context,
      const FrameRects& cells) override
  {
    const bool hands_over = !cells.before.empty() || !cells.after.empty();
    if (hands_over) read_before(slot, cells);
    use(slot);
    map_.reserve_points(executor_, frame.size);
    map_.now->stamp_s = frame.stamp_s;
    map_.now->n_points = context.n_points;
    map_.now->starts_map = context.starts_map != 0;
    map_.now->in = executor_.stage(frame, context, map_.point_cell.size());
    map_.now->channels =
        executor_.stage_channels(frame, map_.channels.size(), map_.point_cell.size());
    executor_.start_frame([this] { run_stages(); }, context.starts_map != 0);
    if (hands_over) executor_.wait_for_mark();
    return records_.data();
  }
  FrameReport finish(int slot, const FrameRects& cells) override
  {
    use(shown_ = slot);
    executor_.finish_frame(
        [this] { run_stages(); },
        [&] { read<ReadCell>(cells.after, records_.data() + size_of(cells.before)); });
    map_.now->features_known = map_.features_wanted();
    return report();
  }

  PointArrays point_arrays(int slot, std::size_t size) override
  {
    use(slot);
    map_.reserve_points(executor_, size);
    return executor_.point_arrays(map_.point_cell.size());
  }
  std::array<bool, kLayerCount> set_outputs(int slot, const OutputPointers& host) override
  {
    use(slot);
    auto& now = *map_.now;
    std::array<bool, kLayerCount> delivered{};
    executor_.forget_outputs();
    const auto n = cells();
    for (std::size_t l = 0; l < host.size(); l++)
    {
      now.outputs[l] = host[l] ? executor_.map_output(host[l], n) : OutputMemory{};
      delivered[l] = now.outputs[l].mapped;
      now.wanted[l] = delivered[l] ? host[l] : nullptr;
    }
    constexpr auto surfaces = static_cast<std::size_t>(Layer::Slope);
    executor_.allocate(now.delivered, map_.copied_surfaces() ? surfaces * n : 0, 0.0f);
    executor_.allocate(now.traversability, n, kernels::kNan);
    if (map_.features_wanted()) map_.allocate_features(executor_);
    return delivered;
  }
  void read_layer(Layer layer, float* out) override
  {
    use(shown_);
    const float* from = map_.top_hit_m.data();  // free between frames
    if (layer < Layer::Slope)
      export_surface(layer, map_.top_hit_m.data());
    else
    {
      if (layer != Layer::Traversability) complete_features();
      from = map_.memory_of(layer);
    }
    if (from != out) executor_.transfer(from, cells(), out);
  }
  CellRecord* read_cells(const std::vector<WindowRect>& rects) override
  {
    return read_all_of<ReadCell>(rects, records_);
  }
  void write_cells(const std::vector<WindowRect>& rects, const CellRecord* from) override
  {
    use(shown_);
    const auto shown = Map::layers_at(
        [this](Layer l) { return map_.now->outputs[static_cast<std::size_t>(l)].mapped; });
    hand_over(
        rects, within_reach(records_, from, static_cast<std::size_t>(size_of(rects))),
        [&](const WindowRects& some, int size, const CellRecord* records) {
          executor_.for_each_from_host(size, WriteCell{{map_.view(), some}, shown}, records);
        });
    kernels::Map m = map_.view();
    m.out = shown;
    if (shown.variance) estimate_variance(on_, m, rects);
    executor_.synchronize();
  }
  std::vector<PointLabel> label_points(
      const Frame& frame, const kernels::FrameContext& context) override
  {
    use(shown_);
    if (label_context_.size() == 0)
    {
      executor_.allocate(label_context_, 1, kernels::FrameContext{});
      executor_.allocate(moved_, cells(), std::int32_t{0});
    }
    executor_.fill(moved_, std::int32_t{0});
    executor_.transfer(&context, 1, label_context_.data());
    map_.reserve_points(executor_, frame.size);
    const auto points = static_cast<int>(frame.size);
    kernels::Map m = map_.view();
    m.frame = label_context_.data(), m.notes_moved = moved_.data();
    m.in = executor_.stage(frame, context, map_.point_cell.size());
    find_limits(on_, m, 1);
    executor_.template for_each<kernels::NoteMoved<typename Executor::Atomics>>(m, points);
    m.moved = moved_.data();
    executor_.make_room(labels_, frame.size);
    executor_.for_each_to_host(points, ReadLabel{m}, labels_.data());
    executor_.synchronize();
    return {labels_.data(), labels_.data() + frame.size};
  }
  void read_channel(std::size_t channel, int surface, float* out) override
  {
    use(shown_);
    kernels::Map m = map_.view();
    m.put = {static_cast<int>(channel), surface, m.top_hit_m};  // free between frames
    on_.template cells<kernels::PutChannel>(m, window_of(m));
    executor_.transfer(m.top_hit_m, cells(), out);
  }
  const ChannelRecord* read_channels(const std::vector<WindowRect>& rects) override
  {
    return read_all_of<ReadChannels>(rects, channel_records_);
  }
  void write_channels(const std::vector<WindowRect>& rects, const ChannelRecord* from) override
  {
    use(shown_);
    hand_over(
        rects, within_reach(channel_records_, from, static_cast<std::size_t>(size_of(rects))),
        [this](const WindowRects& some, int n, const ChannelRecord* records) {
          executor_.for_each_from_host(n, WriteChannels{{map_.view(), some}}, records);
        });
    executor_.synchronize();
  }
  MapBytes read_all() override
  {
    use(shown_);
    complete_features();
    MapBytes bytes;
    bytes.cells.resize(cells() * kernels::kBytesPerCell);
    bytes.features.resize(Map::kJudgedLayers * cells());
    for (auto& channel : map_.channels)
    {
      bytes.values.resize(bytes.values.size() + channel.values.size());
      bytes.votes.resize(bytes.votes.size() + channel.votes.size());
    }
    for_each_part(
        bytes,
        [this](auto* of_map, std::size_t n, auto* to) { executor_.transfer(of_map, n, to); });
    return bytes;
  }
  void write_all(MapBytes bytes, const kernels::FrameContext& window) override
  {
    use(shown_);
    map_.allocate_features(executor_);
    map_.now->features_known = true;
    for_each_part(
        bytes,
        [this](auto* of_map, std::size_t n, auto* from) { executor_.transfer(from, n, of_map); });
    executor_.transfer(&window, 1, map_.frame.data());
    for (int i = Map::kFirstSurface; i < Map::kFirstFeature; i++)
      if (float* const to = map_.memory_of(static_cast<Layer>(i)))
        export_surface(static_cast<Layer>(i), to);
    map_.deliver_surfaces(executor_, 0, map_.side());
    map_.deliver_variance(executor_);
    map_.deliver_features(executor_, 0, map_.side());
    executor_.synchronize();
  }
  std::string name() const override { return executor_.name(); }

 private:
  void use(int slot)
  {
    map_.now = &map_.slots[static_cast<std::size_t>(slot)];
    executor_.use(slot);
  }
  std::size_t cells() const { return static_cast<std::size_t>(map_.cells()); }
  /** f(memory of the map, its size, its place in `bytes`) for all persistent state. */
  template <class F>
  void for_each_part(MapBytes& bytes, const F& f)
  {
    std::uint8_t* cell = bytes.cells.data();
    map_.for_each_field(
        [&](auto& array, auto unknown)
        {
          f(array.data(), cells(), reinterpret_cast<decltype(unknown)*>(cell));
          cell += cells() * sizeof unknown;
        });
    f(map_.datum.data(), 1, &bytes.datum);
    for (std::size_t i = 0; i < Map::kJudgedLayers; i++)
      f(map_.memory_of(feature_layer(i)), cells(), bytes.features.data() + i * cells());
    auto* value = bytes.values.data();
    auto* votes = bytes.votes.data();
    for (auto& channel : map_.channels)
    {
      if (bytes.values.empty()) break;
      f(channel.values.data(), channel.values.size(), value);
      f(channel.votes.data(), channel.votes.size(), votes);
      value += channel.values.size(), votes += channel.votes.size();
    }
  }
  void run_stages()
  {
    executor_.fetch(map_.frame);
    talus::run_stages(on_, view(), map_.now->starts_map);
  }
  kernels::Map view()
  {
    kernels::Map m = map_.view();
    m.reported = executor_.reported();
    return m;
  }
  FrameReport report()
  {
    FrameReport report;
    report.stamp_s = map_.now->stamp_s;
    report.points_in = static_cast<std::uint32_t>(map_.now->n_points);
    std::copy_n(executor_.reported()->rejected, kRejectCount, report.rejected.data());
    report.leaves_floor = executor_.reported()->leaves_floor != 0;
    report.points_accepted = report.points_in;
    for (const auto r : report.rejected) report.points_accepted -= r;
    report.stage_ms = executor_.stage_ms();
    report.total_ms = executor_.total_ms();
    return report;
  }
  /** Makes the features if the last frame did not: judges again, the same but for written cells. */
  void complete_features()
  {
    if (map_.now->features_known) return;
    map_.allocate_features(executor_);
    float* const judged = map_.memory_of(Layer::Traversability);
    float* const kept = map_.top_hit_m.data();  // free between frames
    executor_.copy(kept, judged, cells());
    kernels::Map m = map_.view();
    m.with_features = true, m.keeps = false;
    on_.judge_all(m);
    executor_.copy(judged, kept, cells());
    map_.now->features_known = true;
  }
  void export_surface(Layer layer, float* to)
  {
    kernels::Map m = map_.view();
    m.out = Map::layers_at([=](Layer l) { return l == layer ? to : nullptr; });
    if (layer == Layer::Variance)
      estimate_variance(on_, m, std::array{window_of(m)});
    else
      on_.template cells<kernels::PutSurface>(m, window_of(m));
  }
  static int size_of(const std::vector<WindowRect>& rects)
  {
    int size = 0;
    for (const WindowRect& rect : rects) size += rect.size();
    return size;
  }
  /** loop(cells, their number, their first record) for all rectangles, usually once. */
  template <class Record, class Loop>
  static void hand_over(const std::vector<WindowRect>& rects, Record* records, const Loop& loop)
  {
    for (std::size_t first = 0; first < rects.size(); first += WindowRects::kMax)
    {
      WindowRects some{};
      int size = 0;
      for (std::size_t r = first; r < std::min(first + WindowRects::kMax, rects.size()); r++)
        size += (some.rects[r - first] = rects[r]).size();
      loop(some, size, records);
      records += size;
    }
  }
  template <class Read, class Record>
  void read(const std::vector<WindowRect>& rects, Record* to)
  {
    hand_over(
        rects, to,
        [this](const WindowRects& some, int size, Record* records) {
          executor_.for_each_to_host(size, Read{{map_.view(), some}}, records);
        });
  }
  /** The records of cells, of the frame that was finished last. */
  template <class Read, class Records>
  auto* read_all_of(const std::vector<WindowRect>& rects, Records& records)
  {
    use(shown_);
    executor_.make_room(records, static_cast<std::size_t>(size_of(rects)));
    read<Read>(rects, records.data());
    executor_.synchronize();
    return records.data();
  }
  /** Reads cells before the frame in `slot`, up to a mark, without waiting. */
  void read_before(int slot, const FrameRects& cells)
  {
    use(shown_);
    executor_.use(slot);
    executor_.make_room(
        records_, static_cast<std::size_t>(size_of(cells.before) + size_of(cells.after)));
    read<ReadCell>(cells.before, records_.data());
    executor_.mark();
  }
  /** The records in memory that kernels reach: those that were read are there. */
  template <class Records, class Record>
  const Record* within_reach(Records& own, const Record* from, std::size_t size)
  {
    const std::less_equal<> is_not_behind;
    const bool is_own =
        is_not_behind(own.data(), from) && is_not_behind(from + size, own.data() + own.size());
    if (is_own) return from;
    executor_.make_room(own, size);
    std::copy_n(from, size, own.data());
    return own.data();
  }
  static Layer feature_layer(std::size_t i)
  {
    return static_cast<Layer>(static_cast<std::size_t>(Layer::Slope) + i);
  }

  Map map_;
  On on_;
  int shown_ = 0;  //!< slot of the frame that was finished last
  typename Executor::template HostBuffer<CellRecord> records_;  //!< the records handed over
  typename Executor::template HostBuffer<ChannelRecord> channel_records_;  //!< the same of channels
  typename Executor::template Buffer<kernels::FrameContext> label_context_;
  typename Executor::template Buffer<std::int32_t> moved_;  //!< see kernels::NoteMoved
  typename Executor::template HostBuffer<PointLabel> labels_;
  Executor executor_;  //!< last member: its work ends before the memory is freed
};

}  // namespace talus
