#include <talus/elevation_mapper.h>
#include "backend.h"
#include "kernels/math.h"

#include <cstring>
#include <iostream>
#include <limits>
#include <stdexcept>

namespace talus
{
namespace
{
constexpr char kMagic[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '2'};

/** What save() writes before the layers. */
struct SavedHeader
{
  char magic[8];
  std::int32_t cells;
  std::int32_t started;
  std::int64_t min_cell_x, min_cell_y;
  double last_z_axis[3];
  double resolution_m;
  float reference_z_m;
  std::uint32_t reserved;
};

/** Says once in a process which backend `auto` took, and why not the other. */
void say_once(const std::string& text)
{
  static const bool said = [&text]
  {
    std::clog << "[talus] backend: " << text << "\n";
    return true;
  }();
  static_cast<void>(said);
}

std::unique_ptr<BackendInterface> make_backend(
    const kernels::Config& config, Backend backend, int threads)
{
  if (backend == Backend::Cpu) return make_cpu_backend(config, threads);
  try
  {
    auto cuda = make_cuda_backend(config);
    if (backend == Backend::Auto) say_once(cuda->name() + " (it answers, so not the cpu)");
    return cuda;
  }
  catch (const std::runtime_error& e)
  {
    if (backend == Backend::Cuda) throw;
    say_once(std::string("cpu (") + e.what() + ")");
    return make_cpu_backend(config, threads);
  }
}

/** Keeps a layer away from the pages of its neighbours in memory, so that a device can have it
 * alone. */
constexpr std::size_t kPageFloats = 4096 / sizeof(float);

float unknown(Layer l) { return l == Layer::State ? 0.0f : kernels::kNan; }

}  // namespace

struct ElevationMapper::Impl
{
  Impl(const Parameters& p, Backend b, int t) : parameters(p), wanted(b), threads(t) { reset(); }

  void reset()
  {
    backend = make_backend(make_config(parameters), wanted, threads);
    tracker = {};
    context = {};
    connect_outputs();
  }

  std::size_t cells() const
  {
    const auto n = static_cast<std::size_t>(parameters.cells());
    return n * n;
  }

  /** Gives the memory of the output layers to the backend. */
  void connect_outputs()
  {
    OutputPointers memory{};
    for (std::size_t l = 0; l < outputs.size(); l++)
    {
      if (!outputs[l]) continue;
      layers[l].reserve(cells() + kPageFloats);
      layers[l].assign(cells(), unknown(static_cast<Layer>(l)));
      memory[l] = layers[l].data();
    }
    delivered = backend->set_outputs(memory);
    layer_read = {};
  }

  Parameters parameters;
  Backend wanted;
  int threads;
  WindowTracker tracker;
  kernels::FrameContext context{};  //!< of the last frame
  std::array<std::vector<float>, kLayerCount> layers;
  std::array<bool, kLayerCount> outputs{};  //!< set_output_layers()
  std::array<bool, kLayerCount> delivered{};  //!< the backend puts them into `layers` by itself
  std::array<bool, kLayerCount> layer_read{};  //!< `layers` is up to date
  std::unique_ptr<BackendInterface> backend;  //!< the last member: it refers to `layers`
};

ElevationMapper::ElevationMapper(const Parameters& parameters, Backend backend, int threads)
{
  parameters.validate();
  impl_ = std::make_unique<Impl>(parameters, backend, threads);
}
ElevationMapper::~ElevationMapper() = default;
ElevationMapper::ElevationMapper(ElevationMapper&&) noexcept = default;
ElevationMapper& ElevationMapper::operator=(ElevationMapper&&) noexcept = default;

FrameReport ElevationMapper::update(const Frame& frame)
{
  if (frame.size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 4))
    throw std::invalid_argument("a frame of more than 536,870,911 points");
  Impl& m = *impl_;
  m.context = m.tracker.advance(frame, m.parameters);
  m.layer_read = {};
  const FrameReport report = m.backend->run(frame, m.context);
  m.layer_read = m.delivered;
  return report;
}

PointArrays ElevationMapper::point_arrays(std::size_t size)
{
  return impl_->backend->point_arrays(size);
}

void ElevationMapper::set_output_layers(const std::vector<Layer>& layers)
{
  Impl& m = *impl_;
  std::array<bool, kLayerCount> outputs{};
  for (const Layer l : layers) outputs[static_cast<std::size_t>(l)] = true;
  if (outputs == m.outputs) return;
  const std::vector<std::uint8_t> state = save();
  m.outputs = outputs;
  restore(state);
}

std::vector<Layer> ElevationMapper::output_layers() const
{
  std::vector<Layer> named;
  for (std::size_t l = 0; l < impl_->outputs.size(); l++)
    if (impl_->outputs[l]) named.push_back(static_cast<Layer>(l));
  return named;
}

void ElevationMapper::clear() { impl_->reset(); }

bool ElevationMapper::empty() const { return !impl_->tracker.started; }

const std::vector<float>& ElevationMapper::layer(Layer l) const
{
  const auto i = static_cast<std::size_t>(l);
  auto& values = impl_->layers[i];
  if (impl_->layer_read[i]) return values;
  values.assign(impl_->cells(), unknown(l));
  if (!empty()) impl_->backend->read_layer(l, values.data());
  impl_->layer_read[i] = true;
  return values;
}

Window ElevationMapper::window() const
{
  return {
      impl_->parameters.cells(), impl_->parameters.resolution_m, impl_->tracker.min_cell_x,
      impl_->tracker.min_cell_y};
}

const Parameters& ElevationMapper::parameters() const { return impl_->parameters; }
std::string ElevationMapper::backend_name() const { return impl_->backend->name(); }

std::vector<std::uint8_t> ElevationMapper::save() const
{
  const Impl& m = *impl_;
  SavedHeader header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.cells = m.parameters.cells();
  header.started = m.tracker.started;
  header.min_cell_x = m.tracker.min_cell_x;
  header.min_cell_y = m.tracker.min_cell_y;
  std::copy(m.tracker.last_z_axis.begin(), m.tracker.last_z_axis.end(), header.last_z_axis);
  header.resolution_m = m.parameters.resolution_m;
  header.reference_z_m = m.context.sensor_z_m;
  const auto* head = reinterpret_cast<const std::uint8_t*>(&header);
  std::vector<std::uint8_t> bytes(head, head + sizeof header);
  if (empty()) return bytes;
  const MapBytes all = m.backend->read_all();
  bytes.insert(bytes.end(), all.cells.begin(), all.cells.end());
  const auto* features = reinterpret_cast<const std::uint8_t*>(all.features.data());
  bytes.insert(bytes.end(), features, features + all.features.size() * sizeof(float));
  return bytes;
}

void ElevationMapper::restore(const std::vector<std::uint8_t>& bytes)
{
  Impl& m = *impl_;
  SavedHeader header;
  if (bytes.size() < sizeof header) throw std::invalid_argument("saved map: cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  const int n = m.parameters.cells();
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
    throw std::invalid_argument("saved map: not a state of talus");
  if (header.cells != n || header.resolution_m != m.parameters.resolution_m)
    throw std::invalid_argument("saved map: another window size or resolution");
  const auto cells = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  const std::size_t cell_bytes = cells * kBytesPerCell;
  const std::size_t feature_bytes = cells * 5 * sizeof(float);
  const std::size_t expected = sizeof header + (header.started ? cell_bytes + feature_bytes : 0);
  if (bytes.size() != expected) throw std::invalid_argument("saved map: wrong length");

  m.reset();
  if (!header.started) return;
  m.tracker = {
      true,
      header.min_cell_x,
      header.min_cell_y,
      {header.last_z_axis[0], header.last_z_axis[1], header.last_z_axis[2]}};
  const auto storage = [n](std::int64_t cell) { return static_cast<int>(((cell % n) + n) % n); };
  m.context.storage_x = storage(header.min_cell_x);
  m.context.storage_y = storage(header.min_cell_y);
  m.context.sensor_z_m = header.reference_z_m;
  const auto* from = bytes.data() + sizeof header;
  MapBytes all;
  all.cells.assign(from, from + cell_bytes);
  all.features.resize(cells * 5);
  std::memcpy(all.features.data(), from + cell_bytes, feature_bytes);
  m.backend->write_all(all, m.context);
  m.layer_read = m.delivered;
}

}  // namespace talus
