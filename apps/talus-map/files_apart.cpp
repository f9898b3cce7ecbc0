#include "run_job.h"

#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "job.h"

#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
/** A file, or those in a folder. */
void add_input(const std::string& path, std::vector<std::string>& inputs)
{
  inputs.push_back(path);
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(path, none))
    inputs.push_back(entry.path().string());
}

/** Whether the run may write or remove a file of this name among its results. */
bool is_result(const fs::path& name, const Options& options)
{
  static const std::set<fs::path> always{"map.tif", "map.png", "timing.csv", "summary.json"};
  if (always.count(name) > 0) return true;
  if (options.has_site) return is_site_file(name) || is_export(name);
  return !options.exports.formats.empty() && is_export(name, "map");
}
}  // namespace

void require_files_apart(const Job& job, const Options& options)
{
  std::vector<std::string> inputs{options.trajectory, options.config};
  add_input(job.log, inputs);
  if (!job.needs_import) inputs.push_back(trajectory_beside(job.log));
  std::vector<std::string> results = kept_logs(job, options);
  for (const std::string& input : inputs)
    if (const fs::path name = fs::path(input).filename(); is_result(name, options))
      results.push_back(name.string());
  require_apart(job.folder, results, inputs);
  if (!job.labels.empty()) require_apart(job.labels, {kLabelTable, kLabelledLog}, inputs);

  const std::string& copy = options.rawlog_out;
  if (copy.empty()) return;
  inputs.push_back(options.resume);
  require_apart("", {copy}, inputs);
  const fs::path name = fs::path(copy).filename();
  if (is_result(name, options)) results.push_back(name.string());
  for (const std::string& result : results)
    if (is_same_file(copy, fs::path(job.folder) / result))
      throw std::runtime_error(
          "--rawlog-out " + copy + ": is one of the results in " + job.folder +
          "; give another name");
}

}  // namespace talus::app
