#include <mrpt/core/initializer.h>
#include <mrpt/serialization/CArchive.h>
#include <talus/mrpt/CObservationTraversability.h>

#include <stdexcept>

#include "layer_codec.h"

IMPLEMENTS_SERIALIZABLE(CObservationTraversability, CObservation, talus)

MRPT_INITIALIZER(register_observation_traversability)
{
  if (!mrpt::rtti::findRegisteredClass("talus::CObservationTraversability", false))
    mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CObservationTraversability, talus));
}

namespace talus
{
using mrpt::obs::CObservation;

namespace
{
constexpr std::int32_t kMostCells = 1 << 15;  // along a side; catches a broken stream

std::vector<std::uint8_t> read_bytes(mrpt::serialization::CArchive& in, std::size_t most)
{
  std::uint32_t size = 0;
  in >> size;
  if (size > most)
    throw std::runtime_error(
        "talus::CObservationTraversability: the stream is damaged (size of a layer)");
  std::vector<std::uint8_t> bytes(size);
  if (size > 0) in.ReadBuffer(bytes.data(), bytes.size());
  return bytes;
}

/** The layer of that name, or kLayerCount: one of a later version. */
std::size_t index_of(const std::string& name)
{
  std::size_t i = 0;
  while (i < kLayerCount && name != kLayerNames[i]) ++i;
  return i;
}
}  // namespace

CObservationTraversability::CObservationTraversability(
    const ElevationMapper& map, const mrpt::poses::CPose3D& pose, const std::vector<Layer>& which)
    : T_map_base(pose), window(map.window())
{
  sensorLabel = "terrain";
  for (const Layer l : which) layers[static_cast<std::size_t>(l)] = map.layer(l);
}

const std::vector<Layer>& CObservationTraversability::default_layers()
{
  static const std::vector<Layer> all{
      Layer::Elevation, Layer::GroundElevation, Layer::State, Layer::Traversability};
  return all;
}

std::uint8_t CObservationTraversability::serializeGetVersion() const { return 0; }

void CObservationTraversability::serializeTo(mrpt::serialization::CArchive& out) const
{
  out << timestamp << sensorLabel << T_map_base << T_base_sensor;
  out << static_cast<std::int32_t>(window.cells) << window.resolution_m
      << static_cast<std::int64_t>(window.min_cell_x)
      << static_cast<std::int64_t>(window.min_cell_y);
  std::uint32_t count = 0;
  for (const auto& values : layers) count += !values.empty();
  out << count;
  for (std::size_t i = 0; i < kLayerCount; i++)
  {
    if (layers[i].empty()) continue;
    const auto packed = detail::pack_layer(static_cast<Layer>(i), layers[i]);
    out << std::string(kLayerNames[i]) << packed.offset << packed.step
        << static_cast<std::uint32_t>(packed.zlib.size());
    out.WriteBuffer(packed.zlib.data(), packed.zlib.size());
  }
}

void CObservationTraversability::serializeFrom(
    mrpt::serialization::CArchive& in, std::uint8_t version)
{
  if (version > 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  std::int32_t cells = 0;
  std::uint32_t count = 0;
  in >> timestamp >> sensorLabel >> T_map_base >> T_base_sensor;
  in >> cells >> window.resolution_m >> window.min_cell_x >> window.min_cell_y >> count;
  if (cells < 0 || cells > kMostCells)
    throw std::runtime_error(
        "talus::CObservationTraversability: the stream is damaged (number of cells)");
  window.cells = cells;
  layers = {};
  const std::size_t size = static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
  for (std::uint32_t i = 0; i < count; i++)
  {
    std::string name;
    detail::PackedLayer packed;
    in >> name >> packed.offset >> packed.step;
    packed.zlib = read_bytes(in, 3 * size + 1024);
    const std::size_t at = index_of(name);
    if (at < kLayerCount) layers[at] = detail::unpack_layer(static_cast<Layer>(at), packed, size);
  }
}

}  // namespace talus
