#pragma once
#include "../common/import/import_log.h"

#include <talus/elevation_mapper.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::app
{
/** What the command line says. */
struct Options
{
  import::SourceOptions source;  //!< topics, frames and mountings
  double max_wait_s = 0.2;  //!< how long a cloud waits for its pose
  std::optional<int> domain;  //!< else that of the environment

  std::string config;  //!< INI file, empty: none
  std::vector<std::string> overrides;  //!< name=value
  std::optional<Backend> backend;
  std::optional<int> threads;
  double memory_mb = 512;  //!< of the site map

  double hz = 5;  //!< of what is published
  std::vector<std::string> layers;  //!< of /talus/grid_map

  std::optional<int> page;  //!< port of the page, if there is one
  std::string page_address = "127.0.0.1";  //!< of this machine, where the page is served

  std::string output = "live_map";
  std::string resume;  //!< site map of an earlier run, empty: none
  double save_every_min = 0;  //!< 0: at the end only
  bool record = false;  //!< a log is a result, too
  std::string corrected_path, corrected_trajectory;  //!< topic and file of poses that change
  bool quiet = false;
};

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, Options& options);

}  // namespace talus::app
