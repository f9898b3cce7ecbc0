#pragma once
#include <CLI/CLI.hpp>
#include <talus/elevation_mapper.h>
#include <talus/parameters.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::app
{
/** How to map. */
struct Settings
{
  Parameters parameters;
  Backend backend = Backend::Auto;
  int threads = kAllCores;  //!< of the CPU backend
  std::optional<int> device;  //!< of the CUDA backend; nothing: a batch is dealt out over all
  std::vector<std::string> warnings;
};

/** Adds --config, --set and --backend: load_settings() takes the first two. */
void add_map_settings(
    CLI::App& app, std::string& config, std::vector<std::string>& overrides,
    std::optional<Backend>& backend);

/** Defaults, then the INI file `config` (unless empty), then each NAME=VALUE of `overrides`;
 * `channels`, unless there are none, in the place of those of the file. Throws std::runtime_error
 * that says what is wrong with which file or option, and what to do. */
Settings load_settings(
    const std::string& config, const std::vector<std::string>& overrides,
    const std::vector<Channel>& channels = {});

}  // namespace talus::app
