#include <mrpt/config/CConfigFileBase.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/parameters_ini.h>

#include <ostream>
#include <stdexcept>

#include "ini_sections.h"
#include "warn_once.h"

namespace talus
{
namespace
{
void warn_keys(
    const mrpt::config::CConfigFileBase& c, const std::string& s,
    const std::vector<std::string>& known)
{
  std::vector<std::string> warnings;
  warn_unknown_keys(c, s, known, warnings);
  for (const auto& w : warnings) detail::warn_once(w);
}

void require(
    bool ok, const mrpt::config::CConfigFileBase& c, const std::string& section,
    const std::string& what)
{
  if (!ok) throw std::runtime_error(what + detail::in_section(c, section));
}

/** No padding of the name as MRPT's macros have it: an unsaved configuration would keep it as part
 * of the key. */
template <typename Value>
void write(
    mrpt::config::CConfigFileBase& c, const std::string& section, const char* key,
    const Value& value, const char* comment)
{
  c.write(section, key, value, -1, 12, comment);
}
}  // namespace

void CDualElevationMap::TInsertionOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& source, const std::string& section)
{
  std::vector<std::string> warnings;
  Parameters loaded = *this;
  load_parameter_section(source, section, loaded, warnings);
  try
  {
    loaded.validate();
  }
  catch (const std::invalid_argument& e)
  {
    require(false, source, section, e.what());
  }
  static_cast<Parameters&>(*this) = loaded;
  for (const auto& w : warnings) detail::warn_once(w);
}

void CDualElevationMap::TInsertionOptions::saveToConfigFile(
    mrpt::config::CConfigFileBase& target, const std::string& section) const
{
  save_parameters(target, section, *this);
}

void CDualElevationMap::TInsertionOptions::dumpToTextStream(std::ostream& out) const
{
  out << "\n----------- [talus::CDualElevationMap::TInsertionOptions] ------------ \n\n";
  for (const auto& info : parameter_table())
    out << mrpt::format(
        "%-40s= %s %s\n", info.name, parameter_text(*this, info).c_str(), info.unit);
  out << "\n";
}

void CDualElevationMap::TLikelihoodOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& c, const std::string& s)
{
  warn_keys(c, s, {"sigma_m", "outlierRatio", "decimation"});
  MRPT_LOAD_CONFIG_VAR_CS(sigma_m, double);
  MRPT_LOAD_CONFIG_VAR_CS(outlierRatio, double);
  MRPT_LOAD_CONFIG_VAR_CS(decimation, int);
  const auto text = [&](const char* key)
  { return std::string(key) + " = '" + ini_value(c, s, key) + "': "; };
  require(sigma_m > 0 && sigma_m <= 10, c, s, text("sigma_m") + "must be above 0 and at most 10 m");
  require(
      outlierRatio > 0 && outlierRatio < 1, c, s,
      text("outlierRatio") + "must lie between 0 and 1, both excluded");
  require(decimation >= 1, c, s, text("decimation") + "must be 1 or more");
}

void CDualElevationMap::TLikelihoodOptions::saveToConfigFile(
    mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  write(c, s, "sigma_m", sigma_m, "[m] standard deviation of a point");
  write(c, s, "outlierRatio", outlierRatio, "part of the points that may fit nothing, (0,1)");
  write(c, s, "decimation", decimation, "takes one point of this many");
}

void CDualElevationMap::TRenderOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& c, const std::string& s)
{
  warn_keys(c, s, {"showGround", "showElevation", "colorByTraversability", "colormap", "maxCells"});
  MRPT_LOAD_CONFIG_VAR_CS(showGround, bool);
  MRPT_LOAD_CONFIG_VAR_CS(showElevation, bool);
  MRPT_LOAD_CONFIG_VAR_CS(colorByTraversability, bool);
  colormap = c.read_enum<mrpt::img::TColormap>(s, "colormap", colormap);
  MRPT_LOAD_CONFIG_VAR_CS(maxCells, int);
  require(
      maxCells >= 2, c, s, "maxCells = '" + ini_value(c, s, "maxCells") + "': must be 2 or more");
}

void CDualElevationMap::TRenderOptions::saveToConfigFile(
    mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  write(c, s, "showGround", showGround, "");
  write(c, s, "showElevation", showElevation, "with the ground shown: only what stands on it");
  write(c, s, "colorByTraversability", colorByTraversability, "red 0 to green 1; false: by height");
  write(c, s, "colormap", colormap, "of heights");
  write(c, s, "maxCells", maxCells, "along a side; larger windows are thinned");
}

}  // namespace talus
