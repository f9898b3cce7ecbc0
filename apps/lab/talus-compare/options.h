#pragma once
#include <talus/baselines/real_log.h>
#include <talus/baselines/truth_map.h>

#include <optional>
#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace talus::baselines
{
/** Which scans of a rawlog are read. */
struct LogOptions
{
  std::string trajectory;  //!< TUM or simplemap; empty: LOG.tum beside the log, else the log itself
  std::string sensor;  //!< label, empty for all
  std::optional<int> frames;  //!< the maximum number
};

/** Reads the scans of a rawlog that have a pose. Scans whose
 * pose is farther away than any map reaches are left out, with a warning on stderr. Throws
 * std::runtime_error that names the file and says what to do. */
Sequence read_log(const std::string& path, const LogOptions& options);

/** What people say of each point of each scan: the files 000000.label ... of a folder, by the
 * number of the scan in its log, in SemanticKITTI's format. Throws std::runtime_error that names
 * the file and what is wrong with it. */
std::vector<std::vector<GroundTruth>> read_label_folder(
    const std::string& folder, const Sequence& sequence);

/** What --truth names. Throws std::runtime_error that names the file. */
io::LayerStack read_truth_file(const std::string& path);
/** Truth as talus-sim writes it (truth.tif). Throws std::runtime_error, also when its cells are not
 * those of a map with these parameters. */
TruthMap truth_from(
    const io::LayerStack& stack, const std::string& path, const Parameters& parameters);

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
  bool quiet = false, check = false;
};

/** Whether an input is a world to simulate, and no log. */
bool is_world(const std::string& path);

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, CommandOptions& options);

/** Config file, then --set. Throws std::runtime_error. */
void load_parameters_into(CommandOptions& o);

}  // namespace talus::baselines
