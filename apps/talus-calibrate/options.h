#pragma once
#include "../common/command_line.h"

#include <talus/calibrate/calibrate.h>

#include <optional>
#include <string>
#include <vector>

namespace CLI
{
class App;
}

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

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, AppOptions& options);

}  // namespace talus::calibrate
