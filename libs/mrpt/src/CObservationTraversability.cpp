#include <mrpt/serialization/CArchive.h>
#include <talus/mrpt/CObservationTraversability.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "layer_codec.h"
#include "stream_reader.h"

IMPLEMENTS_SERIALIZABLE(CObservationTraversability, CObservation, talus)

// A variable, so that it comes after the class's own: MRPT_INITIALIZER may run before.
[[maybe_unused]] static const bool observation_traversability_is_known = []
{
  if (!mrpt::rtti::findRegisteredClass("talus::CObservationTraversability", false))
    mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CObservationTraversability, talus));
  return true;
}();

namespace talus
{
using mrpt::obs::CObservation;

namespace
{
constexpr std::uint32_t kMaxLayers = 1000;  // of any version
constexpr std::size_t kLongestName = 100, kLongestLabel = 10000;
constexpr std::int64_t kFarthestCell = 2000000000;  // beyond what a map can reach

/** The layer of that name, or kLayerCount: one of a later version. */
std::size_t index_of(const std::string& name)
{
  const LayerInfo* known = find_layer(name);
  return known ? std::min<std::size_t>(known - kLayerTable, kLayerCount) : kLayerCount;
}

/** One limit with that of a map. */
Window read_window(detail::StreamReader& in)
{
  Window w;
  w.cells = in.number<std::int32_t>("number of cells");
  w.resolution_m = in.number<double>("side of a cell");
  w.min_cell_x = in.number<std::int64_t>("place of the window");
  w.min_cell_y = in.number<std::int64_t>("place of the window");
  if (w.cells < 0 || w.cells > kMaxCellsASide) in.fail("number of cells");
  if (!(w.resolution_m >= 0 && w.resolution_m <= find_parameter("resolution_m")->max))
    in.fail("side of a cell");
  for (const std::int64_t cell : {w.min_cell_x, w.min_cell_y})
    if (cell < -kFarthestCell || cell > kFarthestCell) in.fail("place of the window");
  return w;
}

detail::PackedLayer read_layer(detail::StreamReader& in, const std::string& name, std::size_t cells)
{
  detail::PackedLayer packed;
  const std::string what = "layer " + name;
  packed.count = cells;
  packed.offset = in.number<double>(what.c_str());
  packed.step = in.number<double>(what.c_str());
  const auto size = in.number<std::uint32_t>(what.c_str());
  if (size > 3 * cells + 1024) in.fail(what);  // two bytes a cell, had zlib made them no fewer
  packed.zlib = in.bytes(size, what.c_str());
  return packed;
}
}  // namespace

CObservationTraversability::CObservationTraversability(
    const ElevationMapper& map, const mrpt::poses::CPose3D& pose, const std::vector<Layer>& which)
    : T_map_base(pose), window(map.window())
{
  sensorLabel = "terrain";
  for (const Layer l : which) m_values[static_cast<std::size_t>(l)] = map.layer(l);
}

const std::vector<Layer>& CObservationTraversability::default_layers()
{
  static const std::vector<Layer> all{
      Layer::Elevation, Layer::GroundElevation, Layer::State, Layer::Traversability};
  return all;
}

bool CObservationTraversability::has_layer(Layer l) const
{
  const auto i = static_cast<std::size_t>(l);
  return !m_values[i].empty() || m_packed[i];
}

const std::vector<float>& CObservationTraversability::layer(Layer l) const
{
  const auto i = static_cast<std::size_t>(l);
  auto& values = m_values[i];
  if (!values.empty() || !m_packed[i]) return values;
  std::vector<float> unpacked;
  unpacked.reserve(m_packed[i]->count);
  detail::unpack_layer(
      l, *m_packed[i],
      [&](const float* v, std::size_t n) { unpacked.insert(unpacked.end(), v, v + n); });
  return values = std::move(unpacked);
}

void CObservationTraversability::set_layer(Layer l, std::vector<float> values)
{
  const auto i = static_cast<std::size_t>(l);
  m_values[i] = std::move(values);
  m_packed[i].reset();
}

void CObservationTraversability::forEachValue(
    Layer l, const std::function<void(const float* values, std::size_t count)>& take) const
{
  const auto i = static_cast<std::size_t>(l);
  if (!m_values[i].empty())
    take(m_values[i].data(), m_values[i].size());
  else if (m_packed[i])
    detail::unpack_layer(l, *m_packed[i], take);
}

void CObservationTraversability::requireSound() const
{
  const auto cells = static_cast<std::int64_t>(window.cells) * window.cells;
  for (std::size_t i = 0; i < kLayerCount; i++)
  {
    if (!has_layer(static_cast<Layer>(i))) continue;
    const std::size_t count = m_packed[i] ? m_packed[i]->count : m_values[i].size();
    if (window.cells < 0 || count != static_cast<std::size_t>(cells))
      throw std::runtime_error(
          std::string("talus::CObservationTraversability: the layer ") + kLayerTable[i].name +
          " has " + std::to_string(count) + " values, the window " + std::to_string(cells) +
          " cells: set both alike");
  }
}

std::uint8_t CObservationTraversability::serializeGetVersion() const { return 0; }

void CObservationTraversability::serializeTo(mrpt::serialization::CArchive& out) const
{
  requireSound();
  out << timestamp << sensorLabel << T_map_base << T_base_sensor;
  out << static_cast<std::int32_t>(window.cells) << window.resolution_m
      << static_cast<std::int64_t>(window.min_cell_x)
      << static_cast<std::int64_t>(window.min_cell_y);
  std::uint32_t count = 0;
  for (int i = 0; i < kLayerCount; i++) count += has_layer(static_cast<Layer>(i));
  out << count;
  for (std::size_t i = 0; i < kLayerCount; i++)
  {
    const auto l = static_cast<Layer>(i);
    if (!has_layer(l)) continue;
    const auto packed = m_packed[i] ? *m_packed[i] : detail::pack_layer(l, m_values[i]);
    out << std::string(kLayerTable[i].name) << packed.offset << packed.step
        << static_cast<std::uint32_t>(packed.zlib.size());
    out.WriteBuffer(packed.zlib.data(), packed.zlib.size());
  }
}

void CObservationTraversability::serializeFrom(
    mrpt::serialization::CArchive& archive, std::uint8_t version)
{
  if (version > 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  detail::StreamReader in(archive, "talus::CObservationTraversability");
  CObservationTraversability read;
  archive >> read.timestamp;
  read.sensorLabel = in.text(kLongestLabel, "label of the sensor");
  read.T_map_base = in.pose("pose of the robot");
  read.T_base_sensor = in.pose("pose of the sensor");
  read.window = read_window(in);
  const auto count = in.number<std::uint32_t>("number of layers");
  if (count > kMaxLayers) in.fail("number of layers");
  const auto cells = static_cast<std::size_t>(read.window.cells);
  for (std::uint32_t i = 0; i < count; i++)
  {
    const auto name = in.text(kLongestName, "name of a layer");
    auto packed = read_layer(in, name, cells * cells);
    const std::size_t at = index_of(name);
    if (at == kLayerCount) continue;
    if (read.m_packed[at]) in.fail("layer " + name + " twice");
    if (!detail::is_plausible(packed)) in.fail("layer " + name);
    read.m_packed[at] = std::make_shared<const detail::PackedLayer>(std::move(packed));
  }
  *this = std::move(read);
}

}  // namespace talus
