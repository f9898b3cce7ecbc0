#pragma once
#include <optional>
#include <string>
#include <vector>

#include "../common/export/export_files.h"

namespace talus::formats
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> inputs;
  app::ExportOptions exports;
  std::string output;  //!< a folder; empty: that of each map
  std::string title;  //!< of the page; empty: the folder and the name of the map
  std::vector<double> origin;  //!< of ply and octomap; empty: chosen by itself
  bool quiet = false;
};

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, Options& options);

}  // namespace talus::formats
