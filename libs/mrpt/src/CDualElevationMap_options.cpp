#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/core/format.h>
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
constexpr int kMost = 1000000;  // of what is counted

void check_keys(
    const mrpt::config::CConfigFileBase& c, const std::string& s,
    const std::vector<std::string>& known)
{
  require_sound_ini(c, {s});
  std::vector<std::string> warnings;
  warn_unknown_keys(c, s, known, warnings);
  for (const auto& w : warnings) detail::warn_once(w);
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
    throw std::runtime_error(e.what() + detail::in_section(source, section));
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
  check_keys(c, s, {"sigma_m", "outlierRatio", "decimation"});
  const double sigma = detail::ini_number(c, s, "sigma_m", sigma_m);
  if (!(sigma > 0 && sigma <= 10))
    detail::refuse_value(c, s, "sigma_m", "a number above 0 and at most 10 m");
  const double ratio = detail::ini_number(c, s, "outlierRatio", outlierRatio);
  if (!(ratio > 0 && ratio < 1))
    detail::refuse_value(c, s, "outlierRatio", "a number between 0 and 1, both excluded");
  decimation = detail::ini_whole_number(c, s, "decimation", decimation, 1, kMost);
  sigma_m = sigma;
  outlierRatio = ratio;
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
  check_keys(
      c, s, {"showGround", "showElevation", "colorByTraversability", "colormap", "maxCells"});
  showGround = detail::ini_flag(c, s, "showGround", showGround);
  showElevation = detail::ini_flag(c, s, "showElevation", showElevation);
  colorByTraversability = detail::ini_flag(c, s, "colorByTraversability", colorByTraversability);
  colormap = c.read_enum<mrpt::img::TColormap>(s, "colormap", colormap);
  maxCells = detail::ini_whole_number(c, s, "maxCells", maxCells, 2, kMost);
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
