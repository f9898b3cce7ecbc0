#include "run_job.h"

#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "job.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace talus::app
{
void require_files_apart(const Job& job, const Options& options)
{
  std::vector<std::string> inputs{job.log, options.trajectory, options.config};
  if (!job.needs_import) inputs.push_back(trajectory_beside(job.log));
  std::vector<std::string> results = kept_logs(job, options);
  for (const char* name :
       {"map.tif", "map.png", "site.tif", "site.png", "timing.csv", "summary.json"})
    results.emplace_back(name);
  require_apart(job.folder, results, inputs);
  if (!job.labels.empty()) require_apart(job.labels, {kLabelTable, kLabelledLog}, inputs);

  const std::string& copy = options.rawlog_out;
  if (copy.empty()) return;
  inputs.push_back(options.resume);
  require_apart("", {copy}, inputs);
  for (const std::string& name : results)
    if (is_same_file(copy, std::filesystem::path(job.folder) / name))
      throw std::runtime_error(
          "--rawlog-out " + copy + ": is one of the results in " + job.folder +
          "; give another name");
}

}  // namespace talus::app
