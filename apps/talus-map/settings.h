#pragma once
#include "options.h"

#include <talus/parameters.h>

#include <string>
#include <vector>

namespace talus::app
{
/** How to map: defaults, then the INI file, then the command line. */
struct Settings
{
  Parameters parameters;
  Backend backend = Backend::Auto;
  int threads = 0;  //!< of the CPU backend, 0: all cores
  std::vector<std::string> warnings;
};

/** Throws std::runtime_error that says what is wrong with which file or option, and what to do. */
Settings load_settings(const Options& options);

}  // namespace talus::app
