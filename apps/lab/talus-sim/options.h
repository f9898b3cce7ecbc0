#pragma once
#include "output.h"

#include <optional>
#include <string>

namespace talus::sim
{
/** What the command line says. */
struct Options
{
  std::string world, output;
  DriveOptions drive;
  Claims claims;
  double resolution_m = 0.05;
  bool without_movers = false, quiet = false;
};

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, Options& options);

}  // namespace talus::sim
