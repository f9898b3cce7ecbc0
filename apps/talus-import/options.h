#pragma once
#include <talus/import/scan_source.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::import
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> sources;
  std::string output;  //!< ends in .rawlog
  SourceOptions source;
  bool quiet = false;
};

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, Options& options);

}  // namespace talus::import
