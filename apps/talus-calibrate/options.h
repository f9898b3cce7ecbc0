#pragma once
#include "../common/mounting.h"

#include <talus/calibrate/calibrate.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::calibrate
{
/** What the command line says. */
struct AppOptions
{
  std::string log, trajectory, sensor, output;
  double max_gap_s = 0.5;
  double base_height_m = 0;
  std::optional<app::Mounting> mounting;  //!< empty: the log's
  double time_offset_s = 0;  //!< as it is believed to be
  Thinning thinning;
  Options fit;
  bool quiet = false;
};

/** Reads the command line; answers --help, --version and mistakes itself. The exit code of the
 * program, or nothing: go on. */
std::optional<int> parse_options(int argc, char** argv, AppOptions& options);

}  // namespace talus::calibrate
