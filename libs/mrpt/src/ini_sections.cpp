#include "ini_sections.h"

#include <mrpt/config/CConfigFile.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace talus
{
namespace detail
{
namespace
{
std::string of_file(const mrpt::config::CConfigFileBase& cfg)
{
  const std::string file = file_of(cfg);
  return file.empty() ? file : " of " + file;
}
}  // namespace

const std::vector<std::string>& section_endings()
{
  static const std::vector<std::string> endings{
      "_creationOpts", "_insertOpts", "_likelihoodOpts", "_renderOpts"};
  return endings;
}

std::string file_of(const mrpt::config::CConfigFileBase& cfg)
{
  const auto* file = dynamic_cast<const mrpt::config::CConfigFile*>(&cfg);
  return file ? file->getAssociatedFile() : std::string();
}

std::string in_section(const mrpt::config::CConfigFileBase& cfg, const std::string& section)
{
  return " (in section " + section + of_file(cfg) + ")";
}

std::string in_sections(
    const mrpt::config::CConfigFileBase& cfg, const std::string& a, const std::string& b)
{
  return " (in sections " + a + " and " + b + of_file(cfg) + ")";
}

std::size_t comment_begin(const std::string& text)
{
  std::size_t begin = text.size();
  for (const char* comment : {";", "#", "//"}) begin = std::min(begin, text.find(comment));
  return begin;
}

std::vector<std::string> keys_of(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section)
{
  std::vector<std::string> keys;
  cfg.getAllKeys(section, keys);
  const auto is_comment = [](const std::string& key) { return comment_begin(key) == 0; };
  keys.erase(std::remove_if(keys.begin(), keys.end(), is_comment), keys.end());
  return keys;
}

void refuse_value(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    const std::string& allowed)
{
  throw std::runtime_error(
      key + " = '" + ini_value(cfg, section, key) + "': must be " + allowed +
      in_section(cfg, section));
}

double ini_number(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    double fallback)
{
  if (!cfg.keyExists(section, key)) return fallback;
  const auto value = number_from(ini_value(cfg, section, key));
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

int ini_whole_number(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    int fallback, int min, int max)
{
  if (!cfg.keyExists(section, key)) return fallback;
  const double value = ini_number(cfg, section, key, fallback);
  if (!(value >= min && value <= max && value == std::floor(value)))
    refuse_value(cfg, section, key, mrpt::format("a whole number from %d to %d", min, max));
  return static_cast<int>(value);
}

bool ini_flag(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key,
    bool fallback)
{
  if (!cfg.keyExists(section, key)) return fallback;
  const std::string text = mrpt::system::lowerCase(ini_value(cfg, section, key));
  for (const char* yes : {"true", "yes", "1"})
    if (text == yes) return true;
  for (const char* no : {"false", "no", "0"})
    if (text == no) return false;
  refuse_value(cfg, section, key, "true or false");
}
}  // namespace detail

std::string ini_value(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, const std::string& key)
{
  const std::string text = cfg.read_string(section, key, "");
  return mrpt::system::trim(text.substr(0, detail::comment_begin(text)));
}

}  // namespace talus
