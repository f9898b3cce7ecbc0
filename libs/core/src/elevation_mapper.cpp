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
constexpr char kMagic[8] = {'t', 'a', 'l', 'u', 's', 'm', 'p', '1'};

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

std::unique_ptr<BackendInterface> make_backend(
    const kernels::Config& config, Backend backend, int threads)
{
  if (backend == Backend::Cpu) return make_cpu_backend(config, threads);
  try
  {
    return make_cuda_backend(config);
  }
  catch (const std::runtime_error& e)
  {
    if (backend == Backend::Cuda) throw;
    static const bool said = [&]
    {
      std::clog << "[talus] backend: cpu (" << e.what() << ")\n";
      return true;
    }();
    static_cast<void>(said);
    return make_cpu_backend(config, threads);
  }
}

}  // namespace

struct ElevationMapper::Impl
{
  Impl(const Parameters& p, Backend b, int t) : parameters(p), wanted(b), threads(t) { reset(); }

  void reset()
  {
    tracker = {};
    context = {};
    invalidate();
    backend = make_backend(make_config(parameters), wanted, threads);
  }
  void invalidate() { layer_read.fill(false); }

  Parameters parameters;
  Backend wanted;
  int threads;
  WindowTracker tracker;
  kernels::FrameContext context{};  //!< of the last frame
  std::unique_ptr<BackendInterface> backend;
  std::array<std::vector<float>, kLayerCount> layers;
  std::array<bool, kLayerCount> layer_read{};
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
  m.invalidate();
  return m.backend->run(frame, m.context);
}

void ElevationMapper::clear() { impl_->reset(); }

bool ElevationMapper::empty() const { return !impl_->tracker.started; }

const std::vector<float>& ElevationMapper::layer(Layer l) const
{
  const auto i = static_cast<std::size_t>(l);
  auto& values = impl_->layers[i];
  if (impl_->layer_read[i]) return values;
  const auto n = static_cast<std::size_t>(impl_->parameters.cells());
  values.assign(n * n, l == Layer::State ? 0.0f : kernels::kNan);
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
  const std::size_t cell_bytes = cells * (4 * sizeof(float) + 2);
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
}

}  // namespace talus
