#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/core/format.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <array>
#include <ostream>
#include <stdexcept>

#include "ini_sections.h"
#include "warn_once.h"

namespace talus
{
namespace
{
constexpr int kMax = 1000000;  // of what is counted

// What is allowed, for files, streams and code alike.
constexpr int kMinDecimation = 1, kMinMaxCells = 2;
constexpr const char* kSigmas = "a number above 0 and at most 10 m";
constexpr const char* kRatios = "a number between 0 and 1, both excluded";
bool is_sigma(double v) { return v > 0 && v <= 10; }  // not NaN
bool is_ratio(double v) { return v > 0 && v < 1; }
std::string counts(int min)
{
  return "a whole number from " + std::to_string(min) + " to " + std::to_string(kMax);
}

constexpr std::array<const char*, 3> kColormaps{"cmGRAYSCALE", "cmJET", "cmHOT"};  // by value
constexpr const char* kColormapChoices = "cmGRAYSCALE, cmJET or cmHOT";

/** The name, or the number where there is none. */
std::string colormap_text(mrpt::img::TColormap colormap)
{
  const int i = colormap;
  return i >= 0 && i < static_cast<int>(kColormaps.size()) ? kColormaps[i] : std::to_string(i);
}

mrpt::img::TColormap colormap_from(
    const mrpt::config::CConfigFileBase& c, const std::string& section, const std::string& key)
{
  const std::string text = ini_value(c, section, key);
  for (std::size_t i = 0; i < kColormaps.size(); i++)
    if (text == kColormaps[i] || text == std::to_string(i))
      return static_cast<mrpt::img::TColormap>(i);
  detail::refuse_value(c, section, key, kColormapChoices);
}

void require(bool ok, const char* name, const std::string& value, const std::string& allowed)
{
  if (!ok) throw std::invalid_argument(name + (" = " + value) + ": must be " + allowed);
}

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
  if (!is_sigma(sigma)) detail::refuse_value(c, s, "sigma_m", kSigmas);
  const double ratio = detail::ini_number(c, s, "outlierRatio", outlierRatio);
  if (!is_ratio(ratio)) detail::refuse_value(c, s, "outlierRatio", kRatios);
  decimation = detail::ini_whole_number(c, s, "decimation", decimation, kMinDecimation, kMax);
  sigma_m = sigma;
  outlierRatio = ratio;
}

void CDualElevationMap::TLikelihoodOptions::validate() const
{
  require(is_sigma(sigma_m), "sigma_m", number_text(sigma_m), kSigmas);
  require(is_ratio(outlierRatio), "outlierRatio", number_text(outlierRatio), kRatios);
  require(
      decimation >= kMinDecimation && decimation <= kMax, "decimation", std::to_string(decimation),
      counts(kMinDecimation));
}

void CDualElevationMap::TLikelihoodOptions::saveToConfigFile(
    mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  write(c, s, "sigma_m", number_text(sigma_m), "[m] standard deviation of a point");
  write(
      c, s, "outlierRatio", number_text(outlierRatio),
      "part of the points that may fit nothing, (0,1)");
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
  if (c.keyExists(s, "colormap")) colormap = colormap_from(c, s, "colormap");
  maxCells = detail::ini_whole_number(c, s, "maxCells", maxCells, kMinMaxCells, kMax);
}

void CDualElevationMap::TRenderOptions::validate() const
{
  const bool is_colormap = colormap >= mrpt::img::cmGRAYSCALE && colormap <= mrpt::img::cmHOT;
  require(is_colormap, "colormap", colormap_text(colormap), kColormapChoices);
  require(
      maxCells >= kMinMaxCells && maxCells <= kMax, "maxCells", std::to_string(maxCells),
      counts(kMinMaxCells));
}

void CDualElevationMap::TRenderOptions::saveToConfigFile(
    mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  write(c, s, "showGround", showGround, "");
  write(c, s, "showElevation", showElevation, "with the ground shown: only what stands on it");
  write(c, s, "colorByTraversability", colorByTraversability, "red 0 to green 1; false: by height");
  write(c, s, "colormap", colormap_text(colormap), "of heights: cmGRAYSCALE, cmJET, cmHOT");
  write(c, s, "maxCells", maxCells, "along a side; larger windows are thinned");
}

}  // namespace talus
