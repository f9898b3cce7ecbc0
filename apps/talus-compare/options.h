#pragma once
#include <talus/baselines/holdout.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace talus::baselines
{
/** What the command line says. */
struct CommandOptions
{
  std::vector<std::string> inputs;  //!< .yaml worlds and rawlogs
  std::string output, world, truth, trajectory, sensor, config, markdown;
  std::vector<std::string> settings;  //!< NAME=VALUE
  EvaluationOptions evaluation;
  HoldOutOptions holdout;
  bool quiet = false, check = false;
};

void add_options(CLI::App& app, CommandOptions& o);

/** Config file, then --set. Throws std::runtime_error. */
void load_parameters_into(CommandOptions& o);

}  // namespace talus::baselines
