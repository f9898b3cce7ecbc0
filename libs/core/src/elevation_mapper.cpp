#include <talus/elevation_mapper.h>
#include "backend.h"
#include "kernels/3_update.h"
#include "kernels/group.h"
#include "kernels/math.h"
#include "hand_over.h"
#include "window_tracker.h"

#include <cmath>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <utility>

namespace talus
{
namespace
{
/** Prints once in a process which backend `auto` took, and why not the other. */
void say_once(const std::string& text)
{
  static const bool said = !(std::clog << "[talus] backend: " << text << "\n").fail();
  static_cast<void>(said);
}

void require_device(int device)
{
  const int devices = device == 0 ? 1 : cuda_devices();  // the first one's backend reports errors
  if (device < 0 || device >= devices)
    throw std::runtime_error(
        "device " + std::to_string(device) + ": there are only " + std::to_string(devices) +
        " devices" + (devices > 0 ? ", numbered from 0" : ""));
}

std::unique_ptr<BackendInterface> make_backend(
    const MapConfig& config, Backend backend, int threads, int device)
{
  if (backend == Backend::Cpu) return make_cpu_backend(config, threads);
  try
  {
    require_device(device);
    auto cuda = make_cuda_backend(config, device);
    if (backend == Backend::Auto) say_once(cuda->name() + " (it answers, so not the cpu)");
    return cuda;
  }
  catch (const std::runtime_error&)
  {
    if (backend == Backend::Cuda) throw;
    return make_cpu_backend(config, threads);
  }
}

/** Padding that keeps a layer off its neighbours' pages, so that a device can map it alone. */
constexpr std::size_t kPageFloats = 4096 / sizeof(float);

void require_points(const Frame& frame)
{
  if (frame.size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 4))
    throw std::invalid_argument("a frame of more than 536,870,911 points");
  if (frame.size && !(frame.x_m && frame.y_m && frame.z_m))
    throw std::invalid_argument("a frame with points has no x_m, y_m or z_m");
}

float unknown(Layer l) { return l == Layer::State ? 0.0f : kernels::kNan; }

}  // namespace

struct ElevationMapper::Impl
{
  Impl(const Parameters& p, Backend b, int t, int d)
      : parameters(p), wanted(b), threads(t), device(d)
  {
    reset();
  }

  void reset()
  {
    backend = make_backend(make_config(parameters), wanted, threads, device);
    slots = {};
    started = finished = {};
    reference_z_m = 0;
    shown = 0;
    connect(0);
    now_known({});
  }
  /** The layers that are up to date after the map has changed. */
  void now_known(const std::array<bool, kLayerCount>& delivered)
  {
    layer_read = delivered;
    channel_read = {};
  }

  SavedMap state() const
  {
    return {finished, reference_z_m, finished.started ? backend->read_all() : MapBytes{}};
  }
  /** Takes a state into a map that was reset. */
  void take(SavedMap saved)
  {
    if (!saved.tracker.started) return;
    started = finished = saved.tracker;
    reference_z_m = saved.reference_z_m;
    kernels::FrameContext window{};
    window.storage_x = WindowTracker::storage(finished.min_cell_x, parameters.cells());
    window.storage_y = WindowTracker::storage(finished.min_cell_y, parameters.cells());
    window.sensor_z_map_m = reference_z_m;
    window.offset_m = saved.map.datum.offset_m;
    window.sensor_z_m = reference_z_m - window.offset_m;
    backend->write_all(std::move(saved.map), window);
    now_known(shown_slot().delivered);
  }

  std::size_t cells() const
  {
    const auto n = static_cast<std::size_t>(parameters.cells());
    return n * n;
  }

  /** The parts of a frame that another frame in flight does not share. */
  struct Slot
  {
    WindowTracker tracker;  //!< after the frame
    kernels::FrameContext context{};
    std::array<std::vector<float>, kLayerCount> layers;
    std::array<bool, kLayerCount> delivered{};  //!< the backend writes them into `layers`
    bool connected = false;
  };

  /** Gives a slot's memory for the output layers to the backend. */
  void connect(int index)
  {
    Slot& slot = slots[static_cast<std::size_t>(index)];
    if (slot.connected) return;
    OutputPointers memory{};
    for (std::size_t l = 0; l < outputs.size(); l++)
    {
      if (!outputs[l]) continue;
      slot.layers[l].reserve(cells() + kPageFloats);
      slot.layers[l].assign(cells(), unknown(static_cast<Layer>(l)));
      memory[l] = slot.layers[l].data();
    }
    slot.delivered = backend->set_outputs(index, memory);
    slot.connected = true;
  }

  int free_slot(const char* call)
  {
    if (in_flight == kSlots)
      throw std::logic_error(
          std::string("ElevationMapper::") + call +
          ": two frames are in flight: finish() the first of them before");
    const int slot = in_flight ? 1 - oldest : 0;
    connect(slot);
    return slot;
  }
  void require_none_in_flight(const char* call) const
  {
    if (in_flight)
      throw std::logic_error(
          std::string("ElevationMapper::") + call +
          ": a frame is in flight: finish() what was started before");
  }
  /** It has no cells before the first frame. */
  Window finished_window() const
  {
    const int n = finished.started ? parameters.cells() : 0;
    return {n, parameters.resolution_m, finished.min_cell_x, finished.min_cell_y};
  }
  /** Finds rectangles of the global grid in a window. Returns the number of their cells. */
  static std::size_t find_in_window(
      const Window& window, const std::vector<CellRect>& rects, std::vector<WindowRect>& in_window)
  {
    std::size_t size = 0;
    in_window.clear();
    for (const CellRect& r : rects)
    {
      const std::int64_t x = r.min_cell_x - window.min_cell_x;
      const std::int64_t y = r.min_cell_y - window.min_cell_y;
      const auto inside = [n = window.cells](std::int64_t first, int length)
      { return first >= 0 && length >= 0 && length <= n && first <= n - length; };
      if (window.cells == 0 || !inside(x, r.width_cells) || !inside(y, r.height_cells))
        throw std::invalid_argument("ElevationMapper: cells that are not all in the window");
      in_window.push_back(
          {static_cast<int>(x), static_cast<int>(y), r.width_cells, r.height_cells});
      size += r.size();
    }
    return size;
  }
  /** Finds them for `call` in the window of the last frame, into rects_in_window. */
  std::size_t find_finished(const char* call, const std::vector<CellRect>& rects)
  {
    require_none_in_flight(call);
    return find_in_window(finished_window(), rects, rects_in_window);
  }
  CellRecord* start(const Frame& frame, const FrameRects& cells);
  FrameReport finish(const FrameRects& cells);
  Slot& shown_slot() { return slots[static_cast<std::size_t>(shown)]; }

  Parameters parameters;
  Backend wanted;
  int threads, device;
  std::array<Slot, kSlots> slots;
  int in_flight = 0;  //!< frames that were started and not finished
  int oldest = 0;  //!< the slot of the first of them
  int shown = 0;  //!< slot of the frame that was finished last
  WindowTracker started, finished;  //!< after the frame started, or finished, last
  float reference_z_m = 0;  //!< of the heights of the frame that was finished last
  std::array<bool, kLayerCount> outputs{};  //!< set_output_layers()
  std::array<std::vector<float>, kLayerCount> others;  //!< layers that are not delivered
  std::array<bool, kLayerCount> layer_read{};  //!< the layer of the shown frame is up to date
  static constexpr std::size_t kChannelLayers = kernels::kPointSurfaces * kMaxChannels;
  std::array<std::vector<float>, kChannelLayers> channel_layers;  //!< see channel_layer_names()
  std::array<bool, kChannelLayers> channel_read{};
  std::vector<WindowRect> rects_in_window;  //!< the cells handed over
  FrameRects with_frame;  //!< the cells handed over with a frame
  std::unique_ptr<BackendInterface> backend;  //!< last member: it refers to `slots`
};

/** Returns where the records of `cells` will be. */
CellRecord* ElevationMapper::Impl::start(const Frame& frame, const FrameRects& cells)
{
  require_points(frame);
  require_channels(frame, parameters.channels);
  const int index = free_slot("start");
  Slot& slot = slots[static_cast<std::size_t>(index)];
  slot.tracker = started;
  slot.context = slot.tracker.advance(frame, parameters);
  CellRecord* const records = backend->start(index, frame, slot.context, cells);
  now_known({});
  started = slot.tracker;
  if (in_flight++ == 0) oldest = index;
  return records;
}

FrameReport ElevationMapper::Impl::finish(const FrameRects& cells)
{
  shown = oldest;
  oldest = 1 - oldest;
  in_flight--;
  finished = shown_slot().tracker;
  reference_z_m = shown_slot().context.sensor_z_map_m;
  const FrameReport report = backend->finish(shown, cells);
  now_known(shown_slot().delivered);
  return report;
}

ElevationMapper::ElevationMapper(
    const Parameters& parameters, Backend backend, int threads, int device)
{
  parameters.validate();
  impl_ = std::make_unique<Impl>(parameters, backend, threads, device);
}
ElevationMapper::ElevationMapper(
    const Parameters& parameters, const std::vector<std::uint8_t>& state, Backend backend,
    int threads, int device)
{
  parameters.validate();
  SavedMap saved = saved_map_from(state, parameters);
  impl_ = std::make_unique<Impl>(parameters, backend, threads, device);
  impl_->take(std::move(saved));
}
ElevationMapper::~ElevationMapper() = default;
ElevationMapper::ElevationMapper(ElevationMapper&&) noexcept = default;
ElevationMapper& ElevationMapper::operator=(ElevationMapper&&) noexcept = default;

FrameReport ElevationMapper::update(const Frame& frame)
{
  impl_->require_none_in_flight("update");
  impl_->start(frame, {});
  return impl_->finish({});
}

FrameReport ElevationMapper::update(
    const Frame& frame, FrameCells& cells, const std::function<void()>& meanwhile)
{
  Impl& m = *impl_;
  m.require_none_in_flight("update");
  FrameRects& rects = m.with_frame;
  const std::size_t before = Impl::find_in_window(m.finished_window(), cells.before, rects.before);
  const std::size_t after = Impl::find_in_window(window_after(frame), cells.after, rects.after);
  CellRecord* const records = m.start(frame, rects);
  cells.records_before = {records, before};
  cells.records_after = {records + before, after};
  try
  {
    if (meanwhile) meanwhile();
  }
  catch (...)
  {
    m.finish(rects);
    throw;
  }
  return m.finish(rects);
}

void ElevationMapper::contact(double x_m, double y_m, double z_m, double sigma_m)
{
  const auto require = [](bool holds, const char* what)
  {
    if (!holds) throw std::invalid_argument(std::string("contact(): ") + what);
  };
  require(std::abs(z_m) <= kMaxHeight_m, "z is not finite or farther than 100 km");
  require(sigma_m > 0 && std::isfinite(sigma_m), "sigma must be finite and above 0");
  impl_->require_none_in_flight("contact");
  const Window w = impl_->finished_window();
  const auto i = w.index_at(x_m, y_m);
  require(i.has_value(), "x, y is not in the window of the map");
  const auto at = static_cast<std::int64_t>(*i);
  const std::vector<CellRect> cell{
      {w.min_cell_x + at % w.cells, w.min_cell_y + at / w.cells, 1, 1}};
  CellRecord& record = read_cells(cell)[0];
  const kernels::HeightPoint point{static_cast<float>(z_m), static_cast<float>(sigma_m * sigma_m)};
  kernels::OneCell<kernels::SerialGroup> here{&point, 1, {}};
  here.cells.value = cell_of(record, 0);
  here.run(make_config(impl_->parameters).config);
  record = record_of(here.cells.value, record.traversability, 0);
  write_cells(cell, &record, 1);
}

void ElevationMapper::start(const Frame& frame) { impl_->start(frame, {}); }

FrameReport ElevationMapper::finish()
{
  if (!impl_->in_flight)
    throw std::logic_error("ElevationMapper::finish: no frame is in flight: start() one before");
  return impl_->finish({});
}

int ElevationMapper::frames_in_flight() const { return impl_->in_flight; }

PointArrays ElevationMapper::point_arrays(std::size_t size)
{
  const int slot = impl_->free_slot("point_arrays");
  return impl_->backend->point_arrays(slot, size);
}

void ElevationMapper::set_output_layers(const std::vector<Layer>& layers)
{
  Impl& m = *impl_;
  m.require_none_in_flight("set_output_layers");
  std::array<bool, kLayerCount> outputs{};
  for (const Layer l : layers) outputs[static_cast<std::size_t>(l)] = true;
  if (outputs == m.outputs) return;
  SavedMap state = m.state();
  m.outputs = outputs;
  m.reset();
  m.take(std::move(state));
}

std::vector<Layer> ElevationMapper::output_layers() const
{
  std::vector<Layer> named;
  for (std::size_t l = 0; l < impl_->outputs.size(); l++)
    if (impl_->outputs[l]) named.push_back(static_cast<Layer>(l));
  return named;
}

void ElevationMapper::clear()
{
  impl_->require_none_in_flight("clear");
  impl_->reset();
}

bool ElevationMapper::empty() const { return !impl_->finished.started; }

const std::vector<float>& ElevationMapper::layer(Layer l) const
{
  const auto i = static_cast<std::size_t>(l);
  Impl& m = *impl_;
  auto& values = m.shown_slot().delivered[i] ? m.shown_slot().layers[i] : m.others[i];
  if (m.layer_read[i]) return values;
  if (m.in_flight)
    throw std::logic_error(
        std::string("ElevationMapper::layer: a frame is in flight, and the map has gone on: ") +
        layer_name(l) +
        " can be read before the next start() if it is one of set_output_layers(), else when all "
        "frames are finished");
  if (!m.shown_slot().delivered[i]) values.assign(m.cells(), unknown(l));  // else the map clears it
  if (!empty()) m.backend->read_layer(l, values.data());
  m.layer_read[i] = true;
  return values;
}

const std::vector<float>& ElevationMapper::channel(const std::string& name) const
{
  Impl& m = *impl_;
  const std::size_t i = channel_layer(m.parameters.channels, name, "map");
  std::vector<float>& values = m.channel_layers[i];
  if (m.channel_read[i]) return values;
  m.require_none_in_flight("channel");
  values.assign(m.cells(), kernels::kNan);
  if (!empty())
    m.backend->read_channel(
        i / kernels::kPointSurfaces, static_cast<int>(i % kernels::kPointSurfaces), values.data());
  m.channel_read[i] = true;
  return values;
}

Window ElevationMapper::window() const
{
  return {
      impl_->parameters.cells(), impl_->parameters.resolution_m, impl_->finished.min_cell_x,
      impl_->finished.min_cell_y};
}

const Parameters& ElevationMapper::parameters() const { return impl_->parameters; }
std::string ElevationMapper::backend_name() const { return impl_->backend->name(); }

Window ElevationMapper::window_after(const Frame& frame) const
{
  const Parameters& p = impl_->parameters;
  const auto [x, y] = WindowTracker::min_cell(WindowTracker::checked_base(frame, p), p);
  return {p.cells(), p.resolution_m, x, y};
}

CellRecords ElevationMapper::read_cells(const std::vector<CellRect>& rects) const
{
  Impl& m = *impl_;
  const std::size_t size = m.find_finished("read_cells", rects);
  if (size == 0) return {};
  return {m.backend->read_cells(m.rects_in_window), size};
}

void ElevationMapper::write_cells(
    const std::vector<CellRect>& rects, const CellRecord* records, std::size_t size)
{
  Impl& m = *impl_;
  if (m.find_finished("write_cells", rects) != size)
    throw std::invalid_argument("ElevationMapper::write_cells: a record for each cell");
  if (size == 0) return;
  m.backend->write_cells(m.rects_in_window, records);
  m.now_known(m.shown_slot().delivered);
}

const ChannelRecord* ElevationMapper::read_channels(const std::vector<CellRect>& rects) const
{
  Impl& m = *impl_;
  const std::size_t size = m.find_finished("read_channels", rects);
  if (size == 0 || m.parameters.channels.empty()) return nullptr;
  return m.backend->read_channels(m.rects_in_window);
}

void ElevationMapper::write_channels(
    const std::vector<CellRect>& rects, const ChannelRecord* records, std::size_t size)
{
  Impl& m = *impl_;
  if (m.find_finished("write_channels", rects) != size)
    throw std::invalid_argument("ElevationMapper::write_channels: a record for each cell");
  if (size == 0 || m.parameters.channels.empty()) return;
  m.backend->write_channels(m.rects_in_window, records);
  m.channel_read = {};
}

std::vector<std::uint8_t> ElevationMapper::save() const
{
  const Impl& m = *impl_;
  m.require_none_in_flight("save");
  return bytes_of(m.state(), m.parameters);
}

void ElevationMapper::restore(const std::vector<std::uint8_t>& bytes)
{
  Impl& m = *impl_;
  m.require_none_in_flight("restore");
  SavedMap saved = saved_map_from(bytes, m.parameters);
  m.reset();
  m.take(std::move(saved));
}

std::vector<PointLabel> label_points(const ElevationMapper& map, const Frame& frame)
{
  const ElevationMapper::Impl& m = *map.impl_;
  m.require_none_in_flight("label_points");
  require_points(frame);
  return m.backend->label_points(frame, m.finished.look_up(frame, m.parameters));
}

}  // namespace talus
