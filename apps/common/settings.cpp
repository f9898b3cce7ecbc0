#include "settings.h"

#include "command_line.h"

#include <talus/input_file.h>
#include <talus/io/mrpt_error.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/text.h>

#include <mrpt/config/CConfigFile.h>
#include <mrpt/system/string_utils.h>

#include <cstdint>
#include <set>
#include <stdexcept>

namespace talus::app
{
namespace
{
using mrpt::system::lowerCase;

constexpr const char* kPrefix = "CDualElevationMap";

/** The prefix of a section that this program reads, or nothing: `CDualElevationMap_insertOpts`, and
 * as in a multi-map `map_CDualElevationMap_00_insertOpts`. */
std::string prefix_of(const std::string& section)
{
  for (const char* ending : {"_creationopts", "_insertopts"})
  {
    const std::string s = lowerCase(section), e = ending;
    if (s.size() <= e.size() || !ends_with(s, e)) continue;
    std::string prefix = section.substr(0, section.size() - e.size());
    if (lowerCase(prefix).find(lowerCase(kPrefix)) != std::string::npos) return prefix;
  }
  return {};
}

/** The one map that an INI file describes. */
std::string find_prefix(const std::string& file, const mrpt::config::CConfigFileBase& cfg)
{
  std::vector<std::string> sections;
  cfg.getAllSections(sections);
  std::set<std::string> prefixes;
  for (const auto& section : sections)
    if (const auto prefix = prefix_of(section); !prefix.empty()) prefixes.insert(prefix);
  if (prefixes.size() == 1) return *prefixes.begin();
  if (prefixes.count(kPrefix)) return kPrefix;
  std::string found;
  for (const auto& p : prefixes) found += (found.empty() ? "" : ", ") + p;
  if (!found.empty())
    throw std::runtime_error(
        file + ": describes several maps (" + found +
        "); leave one of them, or name its sections [" + kPrefix + "_creationOpts] and [" +
        kPrefix + "_insertOpts]");
  throw std::runtime_error(
      file + ": has neither a section [" + kPrefix + "_creationOpts] nor [" + kPrefix +
      "_insertOpts]; put the parameters into these");
}

mrpt::config::CConfigFile parsed(const std::string& path)
{
  constexpr std::uint64_t kMax_bytes = 1 << 20;
  read_input_file(path, "configuration (--config)", kMax_bytes);
  try
  {
    return mrpt::config::CConfigFile(path);
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(path + ": " + io::reason_of(e));
  }
}

void load_file(const std::string& path, Settings& s)
{
  const auto cfg = parsed(path);
  // Before they are looked for: MRPT may not see what is meant to be one.
  require_sound_ini(
      cfg, {kPrefix + std::string("_creationOpts"), kPrefix + std::string("_insertOpts")});
  const std::string prefix = find_prefix(path, cfg);
  for (const auto& warning : load_parameters(cfg, prefix, s.parameters))
    if (warning.rfind("unknown key", 0) == 0)  // as of --set
      throw std::runtime_error(path + ": " + warning);
    else
      s.warnings.push_back(path + ": " + warning);
  constexpr int kAny = -1;
  int device = kAny;
  load_execution(cfg, prefix, s.backend, s.threads, device);
  if (device != kAny) s.device = device;
}

void apply_override(const std::string& text, Parameters& p)
{
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw std::runtime_error("--set " + text + ": must be NAME=VALUE, for example window_m=20");
  const std::string name = parameter_of_key(text.substr(0, equals));
  try
  {
    set_parameter(p, name, text.substr(equals + 1));
  }
  catch (const std::invalid_argument& e)
  {
    throw std::runtime_error("--set " + text + ": " + e.what());
  }
}
}  // namespace

void add_map_settings(
    CLI::App& app, std::string& config, std::vector<std::string>& overrides,
    std::optional<Backend>& backend)
{
  add_text(
      app, "--config", config, "FILE.ini",
      "INI file with [CDualElevationMap_creationOpts] and [CDualElevationMap_insertOpts]");
  app.add_option("-s,--set", overrides, "Set a parameter, after --config; can be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  app.add_option_function<std::string>(
         "--backend", [&backend](const std::string& text) { backend = backend_from_text(text); },
         "auto, cpu or cuda: the results are the same to the last bit (default: auto)")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}, CLI::ignore_case))
      ->type_name("NAME");
}

Settings load_settings(
    const std::string& config, const std::vector<std::string>& overrides,
    const std::vector<Channel>& channels)
{
  Settings s;
  s.parameters.channels = channels;  // those of a channel_cost must be known
  if (!config.empty()) load_file(config, s);
  if (!channels.empty()) s.parameters.channels = channels;
  for (const auto& text : overrides) apply_override(text, s.parameters);
  s.parameters.validate();
  return s;
}

}  // namespace talus::app
