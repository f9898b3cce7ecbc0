#pragma once
#include <talus/baselines/real_log.h>
#include <talus/baselines/truth_map.h>

#include <string>

namespace talus::baselines
{
/** Reads all scans of a rawlog that have a pose. `trajectory`: TUM or simplemap; empty: LOG.tum
 * beside the log, else what the log holds itself. `sensor`: label, empty for all. Scans whose
 * pose is farther away than any map reaches are left out and told on stderr. Throws
 * std::runtime_error that names the file and says what to do. */
Sequence read_log(
    const std::string& path, const std::string& trajectory, const std::string& sensor);

/** What --truth names. Throws std::runtime_error that names the file. */
io::LayerStack read_truth_file(const std::string& path);
/** Truth as talus-sim writes it (truth.tif). Throws std::runtime_error, also when its cells are not
 * those of a map with these parameters. */
TruthMap truth_from(
    const io::LayerStack& stack, const std::string& path, const Parameters& parameters);

}  // namespace talus::baselines
