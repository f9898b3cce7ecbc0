#pragma once
#include <talus/baselines/holdout.h>

#include "log_sequence.h"

#include <optional>
#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace talus::baselines
{
/** File of the failures that are expected in the worlds of its folder and the folders in it. */
constexpr const char* kExpectedFailures = "expected_failures.tsv";

/** What the command line says. */
struct CommandOptions
{
  std::vector<std::string> inputs;  //!< .yaml worlds and rawlogs
  std::string output, world, truth, labels, config;
  std::string expected, accept;  //!< files of expected failures: to read; to write
  LogOptions log;
  std::vector<std::string> settings;  //!< NAME=VALUE
  std::vector<int>
      without_rules;  //!< of talus, by their numbers in kernels/rules.md; in rising order
  EvaluationOptions evaluation;
  HoldOutOptions holdout;
  bool quiet = false, check = false;
};

/** Whether an input is a world to simulate, and no log. */
bool is_world(const std::string& path);

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, CommandOptions& options);

/** Config file, then --set. Throws std::runtime_error. */
void load_parameters_into(CommandOptions& o);

}  // namespace talus::baselines
