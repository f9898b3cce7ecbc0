#include "files_apart.h"

#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/placing.h"
#include "source_log.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using NamedFiles = std::vector<std::pair<std::string, std::string>>;  // path, what it is

NamedFiles inputs_of(const Job& job, const Options& options)
{
  NamedFiles inputs{{job.log, "the log itself"}};
  if (!job.needs_import)
    inputs.emplace_back(trajectory_beside(job.log), "the trajectory beside the log");
  if (!options.trajectory.empty())
    inputs.emplace_back(options.trajectory, "the file given to --trajectory");
  if (!options.config.empty()) inputs.emplace_back(options.config, "the file given to --config");
  return inputs;
}

/** A file of write_results(), write_snapshot(), KeptSite::write() or source_log(). */
bool is_result(const std::string& path, const Job& job, const Options& options)
{
  const fs::path folder(job.folder), snapshots = folder / "frames";
  std::vector<std::string> names{"map.tif", "map.png", "timing.csv", "summary.json", "frames"};
  for (auto& name : kept_logs(job, options)) names.push_back(std::move(name));
  const auto is_named = [&](const std::string& name) { return is_same_file(path, folder / name); };
  if (std::any_of(names.begin(), names.end(), is_named)) return true;
  const fs::path parent = fs::absolute(path).parent_path();
  return is_same_file(parent, snapshots) ||
         (is_same_file(parent, folder) && is_site_file(fs::path(path).filename()));
}

/** Whether a file is one of the labels of its points. */
bool is_label(const std::string& path, const Job& job)
{
  const fs::path folder(job.labels);
  return !job.labels.empty() &&
         (is_same_file(path, folder / kLabelTable) || is_same_file(path, folder / kLabelledLog));
}

void require_own_rawlog(const Job& job, const Options& options)
{
  const std::string& path = options.rawlog_out;
  if (path.empty()) return;
  NamedFiles inputs = inputs_of(job, options);
  if (!options.resume.empty()) inputs.emplace_back(options.resume, "the file given to --resume");
  std::string what = is_internal(path) ? "a name of files that a run removes" : "";
  for (const auto& [input, name] : inputs)
    if (what.empty() && is_same_file(path, input)) what = name;
  if (what.empty() && is_result(path, job, options)) what = "one of the results in " + job.folder;
  if (what.empty() && is_label(path, job)) what = "one of the files of --labels";
  if (!what.empty())
    throw std::runtime_error("--rawlog-out " + path + ": is " + what + "; give another name");
}
}  // namespace

void require_files_apart(const Job& job, const Options& options)
{
  require_own_rawlog(job, options);
  std::error_code ec;
  for (const auto& [input, name] : inputs_of(job, options))
  {
    const bool by_result = is_result(input, job, options), by_label = is_label(input, job);
    if (fs::exists(input, ec) && (by_result || by_label))
      throw std::runtime_error(
          "a result in " + (by_result ? job.folder : job.labels) + " would replace " + input +
          ", " + name + "; give another folder with " + (by_result ? "--output" : "--labels") +
          ", or rename it");
  }
}

}  // namespace talus::app
