#pragma once
#include <talus/baselines/real_log.h>
#include <talus/baselines/truth_map.h>

#include <optional>
#include <string>
#include <vector>

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

}  // namespace talus::baselines
