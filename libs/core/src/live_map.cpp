#include <talus/live_map.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

namespace talus
{
const std::vector<float>& MapSnapshot::layer(Layer l) const
{
  const auto& values = layers[static_cast<std::size_t>(l)];
  if (values.empty())
    throw std::invalid_argument(
        std::string("this snapshot has no layer ") + layer_name(l) +
        ": name it when the live map is made");
  return values;
}

const std::vector<float>& MapSnapshot::channel(const std::string& name) const
{
  const std::size_t i = channel_layer(parameters.channels, name, "snapshot");
  if (i < channels.size()) return channels[i];
  throw std::invalid_argument("this snapshot was made without its channels");
}

namespace
{
/** A snapshot and the number of its readers. Written only without any, while not the newest. */
struct Slot
{
  MapSnapshot map;
  std::atomic<int> readers{0};
};
}  // namespace

struct LiveMap::Impl
{
  Impl(
      const Parameters& parameters, const std::vector<Layer>& wanted, Backend backend, int threads,
      double late_s, int device)
      : mapper(parameters, backend, threads, device),
        layers(wanted),
        max_late_s(late_s),
        sequence(late_s)
  {
    mapper.set_output_layers(layers);
  }

  /** A slot without readers, made when all are in use. */
  std::shared_ptr<Slot> free_slot()
  {
    const auto found = std::find_if(
        slots.begin(), slots.end(),
        [this](const auto& s)
        { return s != newest && s->readers.load(std::memory_order_acquire) == 0; });
    if (found != slots.end()) return *found;
    slots.push_back(std::make_shared<Slot>());
    slots.back()->map.parameters = mapper.parameters();
    return slots.back();
  }

  void publish(const Frame& frame, const FrameReport& report)
  {
    const std::shared_ptr<Slot> slot = free_slot();
    MapSnapshot& map = slot->map;
    map.frame = ++frames;
    map.T_map_sensor = frame.T_map_sensor;
    map.report = report;
    map.window = mapper.window();
    for (const Layer l : layers) map.layers[static_cast<std::size_t>(l)] = mapper.layer(l);
    const std::vector<std::string> names = channel_layer_names(map.parameters.channels);
    map.channels.resize(names.size());
    for (std::size_t i = 0; i < names.size(); i++) map.channels[i] = mapper.channel(names[i]);
    const std::lock_guard<std::mutex> lock(exchange);
    newest = slot;
  }

  void count(FrameOrder order)
  {
    const std::lock_guard<std::mutex> lock(exchange);
    if (order == FrameOrder::Duplicate) counts.duplicate++;
    if (order == FrameOrder::Late) counts.late++;
    if (order == FrameOrder::ClockSetBack) counts.clock_set_back++;
    if (order == FrameOrder::Newest || order == FrameOrder::ClockSetBack) counts.mapped++;
  }

  // ---- for the thread that ingests ----
  std::mutex turn;  //!< held for a whole frame
  ElevationMapper mapper;
  std::vector<Layer> layers;
  double max_late_s;
  FrameSequence sequence, sequence_then;  //!< before the frame, and after it
  FrameGatherer gatherer;
  std::uint64_t frames = 0;
  std::vector<std::shared_ptr<Slot>> slots;

  // ---- shared; only the thread that ingests changes `newest` ----
  std::mutex exchange;  //!< held for a few instructions only
  std::shared_ptr<Slot> newest;
  LiveCounts counts;
};

LiveMap::LiveMap(
    const Parameters& parameters, const std::vector<Layer>& layers, Backend backend, int threads,
    double max_late_s, int device)
    : impl_(std::make_unique<Impl>(parameters, layers, backend, threads, max_late_s, device))
{
}
LiveMap::~LiveMap() = default;

FrameOrder LiveMap::ingest(const Frame& frame)
{
  Impl& m = *impl_;
  const std::lock_guard<std::mutex> lock(m.turn);
  m.sequence_then = m.sequence;
  const FrameOrder order = m.sequence_then.next(frame.stamp_s, frame.sensor);
  if (order == FrameOrder::Newest || order == FrameOrder::ClockSetBack)
  {
    m.mapper.window_after(frame);  // throws for a pose that is none
    m.gatherer.add(frame, [&m](const Frame& scan) { m.publish(scan, m.mapper.update(scan)); });
  }
  std::swap(m.sequence, m.sequence_then);
  m.count(order);
  return order;
}

std::shared_ptr<const MapSnapshot> LiveMap::snapshot() const
{
  std::shared_ptr<Slot> slot;
  {
    const std::lock_guard<std::mutex> lock(impl_->exchange);
    slot = impl_->newest;
    if (!slot) return nullptr;
    slot->readers.fetch_add(1, std::memory_order_relaxed);
  }
  const MapSnapshot* map = &slot->map;
  return {
      map, [slot](const MapSnapshot*) { slot->readers.fetch_sub(1, std::memory_order_release); }};
}

LiveCounts LiveMap::counts() const
{
  const std::lock_guard<std::mutex> lock(impl_->exchange);
  return impl_->counts;
}

void LiveMap::clear()
{
  Impl& m = *impl_;
  const std::lock_guard<std::mutex> turn(m.turn);
  m.mapper.clear();
  m.gatherer = {};
  m.sequence = FrameSequence(m.max_late_s);
  const std::lock_guard<std::mutex> lock(m.exchange);
  m.newest = nullptr;
}

}  // namespace talus
