#pragma once
#include <optional>
#include <string>
#include <vector>

#include "../common/import/import_options.h"

namespace talus::import
{
/** What the command line says. */
struct Options
{
  std::vector<std::string> sources;
  std::string output;  //!< ends in .rawlog
  ImportOptions import;
  bool quiet = false;
};

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, Options& options);

}  // namespace talus::import
