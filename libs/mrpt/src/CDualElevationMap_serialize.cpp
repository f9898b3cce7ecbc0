#include <mrpt/serialization/CArchive.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/parameters_ini.h>

#include <stdexcept>

#include "warn_once.h"

namespace talus
{
namespace
{
constexpr std::uint64_t kMaxStateBytes = 1ULL
                                         << 36;  // far above any window; catches a broken stream

/** By name, so that a table with more parameters reads what one with fewer wrote. */
void write_parameters(mrpt::serialization::CArchive& out, const Parameters& p)
{
  out << static_cast<std::uint32_t>(parameter_table().size());
  for (const auto& info : parameter_table()) out << std::string(info.name) << info.get(p);
}

void read_parameters(mrpt::serialization::CArchive& in, Parameters& p)
{
  std::uint32_t count = 0;
  in >> count;
  for (std::uint32_t i = 0; i < count; i++)
  {
    std::string name;
    double value = 0;
    in >> name >> value;
    if (const ParameterInfo* info = find_parameter(name)) info->set(p, value);
  }
}

void write_bytes(mrpt::serialization::CArchive& out, const std::vector<std::uint8_t>& bytes)
{
  out << static_cast<std::uint64_t>(bytes.size());
  if (!bytes.empty()) out.WriteBuffer(bytes.data(), bytes.size());
}

std::vector<std::uint8_t> read_bytes(mrpt::serialization::CArchive& in)
{
  std::uint64_t size = 0;
  in >> size;
  if (size > kMaxStateBytes)
    throw std::runtime_error("talus::CDualElevationMap: the stream is damaged (size of the state)");
  std::vector<std::uint8_t> bytes(size);
  if (size > 0) in.ReadBuffer(bytes.data(), bytes.size());
  return bytes;
}

}  // namespace

std::uint8_t CDualElevationMap::serializeGetVersion() const { return 0; }

void CDualElevationMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  out << genericMapParams << backend_text(m_backend) << static_cast<std::int32_t>(m_threads);
  write_parameters(out, insertionOptions);
  out << likelihoodOptions.sigma_m << likelihoodOptions.outlierRatio
      << static_cast<std::int32_t>(likelihoodOptions.decimation);
  out << renderOptions.showGround << renderOptions.showElevation
      << renderOptions.colorByTraversability << static_cast<std::int32_t>(renderOptions.colormap)
      << static_cast<std::int32_t>(renderOptions.maxCells);
  out << m_T_map_base;
  out << isEmpty();
  if (isEmpty()) return;
  write_parameters(out, m_mapper->parameters());  // may lag behind insertionOptions
  write_bytes(out, m_mapper->save());
}

void CDualElevationMap::serializeFrom(mrpt::serialization::CArchive& in, std::uint8_t version)
{
  switch (version)
  {
    case 0:
    {
      std::string backend;
      std::int32_t threads = 0, decimation = 0, colormap = 0, maxCells = 0;
      in >> genericMapParams >> backend >> threads;
      m_backend = backend_from_text(backend);
      m_threads = threads;
      read_parameters(in, insertionOptions);
      in >> likelihoodOptions.sigma_m >> likelihoodOptions.outlierRatio >> decimation;
      likelihoodOptions.decimation = decimation;
      in >> renderOptions.showGround >> renderOptions.showElevation >>
          renderOptions.colorByTraversability >> colormap >> maxCells;
      renderOptions.colormap = static_cast<mrpt::img::TColormap>(colormap);
      renderOptions.maxCells = maxCells;
      in >> m_T_map_base;
      readState(in);
    }
    break;
    default:
      MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  }
}

void CDualElevationMap::readState(mrpt::serialization::CArchive& in)
{
  m_lastReport = {};
  forgetDerived();
  m_mapper.reset();
  bool empty = true;
  in >> empty;
  if (empty) return;
  Parameters p;
  read_parameters(in, p);
  const auto state = read_bytes(in);
  try
  {
    m_mapper = std::make_unique<ElevationMapper>(p, m_backend, m_threads);
  }
  catch (const std::runtime_error& e)
  {
    // A map written on a machine with a GPU: every backend goes on with the same bits.
    detail::warn_once(std::string(e.what()) + "; the map read goes on with backend auto");
    m_backend = Backend::Auto;
    m_mapper = std::make_unique<ElevationMapper>(p, m_backend, m_threads);
  }
  m_mapper->restore(state);
}

}  // namespace talus
