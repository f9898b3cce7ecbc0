#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ini_sections.h"

namespace talus
{
namespace
{
using mrpt::system::lowerCase;

constexpr int kMaxThreads = 1024, kMaxDevice = 1023;

/** Keys of the two sections that are not parameters of the pipeline; read elsewhere. */
const std::vector<std::string> kOtherKeys{
    "backend",
    "threads",
    "device",
    "keep_whole",
    "enableSaveAs3DObject",
    "enableObservationLikelihood",
    "enableObservationInsertion"};

bool contains_name(const std::vector<std::string>& names, const std::string& name)
{
  return std::any_of(
      names.begin(), names.end(), [&](const auto& n) { return lowerCase(n) == lowerCase(name); });
}

/** What is meant by a key that is neither a parameter nor another key; may be empty. */
std::string nearest_key(const std::string& key)
{
  std::vector<std::string> names = kOtherKeys;
  names.reserve(names.size() + parameter_table().size());
  for (const auto& info : parameter_table()) names.emplace_back(info.name);
  return nearest_name(key, names);
}

std::string joined(const std::vector<std::string>& names)
{
  std::string text;
  for (const auto& n : names) text += (text.empty() ? "" : ", ") + n;
  return text;
}

/** Sections that begin as those of this map but that nothing reads; a map without sections. */
void warn_sections(
    const mrpt::config::CConfigFileBase& cfg, const std::string& prefix,
    std::vector<std::string>& warnings)
{
  std::vector<std::string> sections, known;
  cfg.getAllSections(sections);
  for (const auto& ending : detail::section_endings()) known.push_back(prefix + ending);
  bool any = false;
  for (const auto& s : sections)
  {
    if (contains_name(known, s))
      any = true;
    else if (lowerCase(s).rfind(lowerCase(prefix) + "_", 0) == 0)
      warnings.push_back("section [" + s + "] is not read; known are " + joined(known));
  }
  if (!any)
    warnings.push_back(
        "no section [" + prefix + "_creationOpts], [" + prefix +
        "_insertOpts], ...: this map has the defaults");
}

/** Adds `source` to what an invalid value says. */
template <typename Function>
void with_source(const std::string& source, Function&& f)
{
  try
  {
    f();
  }
  catch (const std::invalid_argument& e)
  {
    throw std::runtime_error(e.what() + source);
  }
}

}  // namespace

std::string parameter_of_key(const std::string& key)
{
  const std::string k = lowerCase(key);
  return k == "resolution" || k == "window" ? k + "_m" : k;
}

void warn_unknown_keys(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section,
    const std::vector<std::string>& known, std::vector<std::string>& warnings)
{
  for (const auto& key : detail::keys_of(cfg, section))
    if (!contains_name(known, key))
    {
      const std::string nearest = nearest_name(key, known);
      warnings.push_back(
          "unknown key '" + key + "' in section [" + section + "]; " +
          (nearest.empty() ? "" : "the nearest known name is '" + nearest + "'; ") + "known are " +
          joined(known));
    }
}

void load_parameter_section(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section, Parameters& p,
    std::vector<std::string>& warnings)
{
  require_sound_ini(cfg, {section});
  std::set<std::string> seen;
  const std::string source = detail::in_section(cfg, section);
  for (const auto& key : detail::keys_of(cfg, section))
  {
    const std::string name = parameter_of_key(key);
    if (contains_name(kOtherKeys, key)) continue;
    if (!find_parameter(name))
    {
      const std::string nearest = nearest_key(key);
      warnings.push_back(
          "unknown key '" + key + "' in section [" + section + "]; " +
          (nearest.empty() ? "doc/parameters.md lists the known ones"
                           : "the nearest known name is '" + nearest + "'"));
      continue;
    }
    if (!seen.insert(name).second)
      throw std::runtime_error(
          name + " is given twice, with and without its unit; leave one of them" + source);
    with_source(source, [&] { set_parameter(p, name, ini_value(cfg, section, key)); });
  }
}

std::vector<std::string> load_parameters(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section_prefix, Parameters& p)
{
  std::vector<std::string> warnings;
  Parameters loaded = p;
  const std::string creation = section_prefix + "_creationOpts";
  const std::string insertion = section_prefix + "_insertOpts";
  load_parameter_section(cfg, creation, loaded, warnings);
  load_parameter_section(cfg, insertion, loaded, warnings);
  with_source(detail::in_sections(cfg, creation, insertion), [&] { loaded.validate(); });
  warn_sections(cfg, section_prefix, warnings);
  p = loaded;
  return warnings;
}

void load_execution(
    const mrpt::config::CConfigFileBase& cfg, const std::string& section_prefix, Backend& backend,
    int& threads, int& device)
{
  const std::string section = section_prefix + "_creationOpts";
  with_source(
      detail::in_section(cfg, section),
      [&]
      {
        if (cfg.keyExists(section, "backend"))
          backend = backend_from_text(ini_value(cfg, section, "backend"));
      });
  threads = detail::ini_whole_number(cfg, section, "threads", threads, 0, kMaxThreads);
  device = detail::ini_whole_number(cfg, section, "device", device, 0, kMaxDevice);
}

void save_parameters(
    mrpt::config::CConfigFileBase& cfg, const std::string& section, const Parameters& p)
{
  for (const auto& info : parameter_table())
  {
    const std::string unit = *info.unit ? std::string("[") + info.unit + "] " : std::string();
    // No padding of the name: an unsaved configuration would keep it as part of the key.
    cfg.write(section, info.name, parameter_text(p, info), -1, 12, unit + info.description);
  }
}

std::string backend_text(Backend backend)
{
  return backend == Backend::Cpu ? "cpu" : backend == Backend::Cuda ? "cuda" : "auto";
}

Backend backend_from_text(const std::string& text)
{
  for (Backend b : {Backend::Auto, Backend::Cpu, Backend::Cuda})
    if (lowerCase(text) == backend_text(b)) return b;
  throw std::invalid_argument("backend = '" + text + "': must be one of auto cpu cuda");
}

std::string parameters_as_markdown()
{
  const Parameters defaults;
  std::ostringstream out;
  out << "| name | default | unit | allowed | meaning |\n|---|---|---|---|---|\n";
  for (const auto& info : parameter_table())
  {
    out << "| `" << info.name << "` | " << parameter_text(defaults, info) << " | " << info.unit
        << " | ";
    if (info.is_text())
      out << "text";
    else
      out << number_text(info.min, 6) << " to " << number_text(info.max, 6);
    out << " | " << info.description << " |\n";
  }
  return out.str();
}

void fit_planner_ini(mrpt::config::CConfigFileBase& ini)
{
  const std::string section = "CHolonomicFullEval";
  for (const std::string key : {"factorWeights", "factorNormalizeOrNot"})
  {
    std::vector<std::string> factors;
    mrpt::system::tokenize(ini_value(ini, section, key), "[], \t", factors);
    if (factors.size() != 7 && factors.size() != 8) continue;
    factors.resize(detail::kHolonomicFactors, "0");
    std::string text;
    for (const auto& factor : factors) text += (text.empty() ? "[" : ", ") + factor;
    ini.write(section, key, text + "]");
  }
}

}  // namespace talus
