#include <mrpt/serialization/CArchive.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/parameters_ini.h>

#include <cstring>
#include <stdexcept>
#include <utility>

#include "stream_reader.h"
#include "warn_once.h"
#include "whole_map.h"

namespace talus
{
namespace
{
using detail::StreamReader;

constexpr std::uint32_t kMaxParameters = 1000;  // of any version
constexpr std::size_t kLongestName = 100;
constexpr std::size_t kLongestText = 10000;  // of a parameter
constexpr std::size_t kLongestLabel = 10000;  // of a sensor
constexpr const char* kParameters = "parameters";

/** By name, so that a table with more parameters reads what one with fewer wrote. */
void write_parameters(mrpt::serialization::CArchive& out, const Parameters& p)
{
  out << static_cast<std::uint32_t>(parameter_table().size());
  for (const auto& info : parameter_table())
  {
    out << std::string(info.name) << info.is_text();
    if (info.is_text())
      out << info.get_text(p);
    else
      out << info.get(p);
  }
}

/** A parameter that only another version knows is skipped. */
void read_number(StreamReader& in, const std::string& name, Parameters& p)
{
  const auto value = in.number<double>(kParameters);
  if (const ParameterInfo* info = find_parameter(name)) set_parameter(p, *info, value);
}

void read_text(StreamReader& in, const std::string& name, Parameters& p)
{
  const auto text = in.text(kLongestText, kParameters);
  const ParameterInfo* info = find_parameter(name);
  if (info && !info->is_text()) in.fail(name);
  if (info) info->set_text(p, text);
}

Parameters read_parameters(StreamReader& in)
{
  Parameters p;
  const auto count = in.number<std::uint32_t>(kParameters);
  if (count > kMaxParameters) in.fail(kParameters);
  for (std::uint32_t i = 0; i < count; i++)
  {
    const auto name = in.text(kLongestName, kParameters);
    if (in.flag(kParameters))
      read_text(in, name, p);
    else
      read_number(in, name, p);
  }
  p.validate();
  return p;
}

void write_bytes(mrpt::serialization::CArchive& out, const std::vector<std::uint8_t>& bytes)
{
  out << static_cast<std::uint64_t>(bytes.size());
  if (!bytes.empty()) out.WriteBuffer(bytes.data(), bytes.size());
}

/** Its flags may have any bytes: MRPT copies them as they come. */
mrpt::maps::TMapGenericParams read_generic(
    mrpt::serialization::CArchive& archive, const StreamReader& in)
{
  mrpt::maps::TMapGenericParams p;
  archive >> p;
  for (const bool* flag :
       {&p.enableSaveAs3DObject, &p.enableObservationLikelihood, &p.enableObservationInsertion})
  {
    std::uint8_t byte;
    std::memcpy(&byte, flag, 1);
    if (byte > 1) in.fail("flags of the map");
  }
  return p;
}

CDualElevationMap::TLikelihoodOptions read_likelihood_options(StreamReader& in)
{
  constexpr const char* what = "likelihoodOptions";
  CDualElevationMap::TLikelihoodOptions o;
  o.sigma_m = in.number<double>(what);
  o.outlierRatio = in.number<double>(what);
  o.decimation = in.number<std::int32_t>(what);
  o.validate();
  return o;
}

CDualElevationMap::TRenderOptions read_render_options(StreamReader& in)
{
  constexpr const char* what = "renderOptions";
  CDualElevationMap::TRenderOptions o;
  o.showGround = in.flag(what);
  o.showElevation = in.flag(what);
  o.colorByTraversability = in.flag(what);
  const auto colormap = in.number<std::int32_t>(what);
  if (colormap < mrpt::img::cmGRAYSCALE || colormap > mrpt::img::cmHOT)
    in.fail("colormap = " + std::to_string(colormap));
  o.colormap = static_cast<mrpt::img::TColormap>(colormap);
  o.maxCells = in.number<std::int32_t>(what);
  o.validate();
  return o;
}

SensorNumbers read_sensors(StreamReader& in)
{
  constexpr const char* what = "labels of the sensors";
  const auto count = in.number<std::uint32_t>(what);
  if (count > kMaxSensors) in.fail(what);
  std::vector<std::string> labels;
  for (std::uint32_t i = 0; i < count; i++) labels.push_back(in.text(kLongestLabel, what));
  return SensorNumbers(std::move(labels));
}

/** The map behind it; none for an empty one. The state is looked at before memory is taken for the
 * window that the parameters say. */
std::unique_ptr<ElevationMapper> read_mapper(
    StreamReader& in, Backend& backend, int threads, int device)
{
  if (in.flag("whether it is empty")) return nullptr;
  const Parameters p = read_parameters(in);
  const auto size = in.number<std::uint64_t>("size of the state");
  if (!ElevationMapper::is_size_of_state(size, p))
    in.fail("size of the state: not that of " + std::to_string(p.cells()) + " cells a side");
  const auto state = in.bytes(size, "state");
  try
  {
    return std::make_unique<ElevationMapper>(p, state, backend, threads, device);
  }
  catch (const std::runtime_error& e)
  {
    // A map written on a machine with a GPU: every backend goes on with the same bits.
    detail::warn_once(std::string(e.what()) + "; the map read goes on with backend auto");
    backend = Backend::Auto;
    return std::make_unique<ElevationMapper>(p, state, backend, threads, device);
  }
}

}  // namespace

std::uint8_t CDualElevationMap::serializeGetVersion() const { return 0; }

void CDualElevationMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  // What is written can be read.
  insertionOptions.validate();
  likelihoodOptions.validate();
  renderOptions.validate();
  out << genericMapParams << backend_text(m_backend) << static_cast<std::int32_t>(m_threads);
  write_parameters(out, insertionOptions);
  out << likelihoodOptions.sigma_m << likelihoodOptions.outlierRatio
      << static_cast<std::int32_t>(likelihoodOptions.decimation);
  out << renderOptions.showGround << renderOptions.showElevation
      << renderOptions.colorByTraversability << static_cast<std::int32_t>(renderOptions.colormap)
      << static_cast<std::int32_t>(renderOptions.maxCells);
  out << m_T_map_base;
  out << static_cast<std::uint32_t>(m_sensors.labels().size());
  for (const std::string& label : m_sensors.labels()) out << label;
  out << m_keep_whole << isEmpty();
  if (isEmpty()) return;
  write_parameters(out, m_mapper->parameters());  // may lag behind insertionOptions
  write_bytes(out, m_mapper->save());
  if (m_keep_whole) whole().write(*m_mapper, out);
}

void CDualElevationMap::serializeFrom(mrpt::serialization::CArchive& in, std::uint8_t version)
{
  switch (version)
  {
    case 0:
      readVersion0(in);
      break;
    default:
      MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  }
}

/** Nothing changes before everything has been read. */
void CDualElevationMap::readVersion0(mrpt::serialization::CArchive& archive)
{
  StreamReader in(archive, "talus::CDualElevationMap");
  CDualElevationMap read;
  try
  {
    read.genericMapParams = read_generic(archive, in);
    read.m_backend = backend_from_text(in.text(kLongestName, "backend"));
    read.m_threads = in.number<std::int32_t>("threads");
    static_cast<Parameters&>(read.insertionOptions) = read_parameters(in);
    read.likelihoodOptions = read_likelihood_options(in);
    read.renderOptions = read_render_options(in);
    read.m_T_map_base = in.pose("pose of the robot");
    read.m_sensors = read_sensors(in);
    read.m_keep_whole = in.flag("whether it keeps the whole");
    read.m_mapper = read_mapper(in, read.m_backend, read.m_threads, m_device);
    if (read.m_mapper && read.m_keep_whole) read.whole().read(in);
  }
  catch (const std::invalid_argument& e)
  {
    in.fail(e.what());
  }
  takeSettings(read);
  m_mapper = std::move(read.m_mapper);
  m_whole = std::move(read.m_whole);
  m_lastReport = {};
  forgetDerived();
}

}  // namespace talus
