#include "job.h"

#include "../common/log_name.h"

#include <talus/number_text.h>

#include <filesystem>
#include <numeric>
#include <set>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
constexpr const char* kHidden = ".talus-import";  // never a result

std::string poses_text(const import::WrittenPoses& poses)
{
  if (poses.count == 0) return "no poses";
  return std::to_string(poses.count) + (poses.count == 1 ? " pose" : " poses") + " of " +
         poses.source + " over " + fixed_text(poses.length_m, 1) + " m";
}
/** Which values of points --channels wants, where --values does not say: a log keeps one of each
 * point. Throws std::runtime_error where it wants several. */
std::string values_for(const Options& options)
{
  if (!options.import.source.values.empty()) return options.import.source.values;
  std::set<std::string> wanted;
  for (const Channel& c : options.channels)
    wanted.insert(c.name == "red" || c.name == "green" || c.name == "blue" ? "rgb" : c.name);
  if (wanted.size() > 1)
  {
    std::string names;
    for (const std::string& name : wanted) names += (names.empty() ? "" : " and ") + name;
    throw std::runtime_error(
        "--channels " + names +
        ": the log of an import keeps one value of each point: the "
        "intensity, rgb or one field");
  }
  return wanted.empty() || *wanted.begin() == "intensity" ? "" : *wanted.begin();
}
}  // namespace

std::vector<std::string> kept_logs(const Job& job, const Options& options)
{
  if (!job.needs_import || !options.keep_log) return {};
  return {name_of_source(job.log) + ".rawlog", name_of_source(job.log) + ".tum"};
}

std::string path_of_log(const Job& job, const Options& options, const std::string& folder)
{
  if (!job.needs_import) return job.log;
  const fs::path where = options.keep_log ? fs::path(folder) : fs::path(folder) / kHidden;
  return (where / (name_of_source(job.log) + ".rawlog")).string();
}

SourceLog source_log(
    const Job& job, const Options& options, const std::string& folder,
    const import::ImportProgress& progress)
{
  SourceLog log;
  log.path = path_of_log(job, options, folder);
  log.is_imported = job.needs_import;
  if (!job.needs_import) return log;
  fs::create_directories(fs::path(log.path).parent_path());
  import::ImportOptions wanted = options.import;
  wanted.source.values = values_for(options);
  const auto made = import_log({job.log}, wanted, log.path, trajectory_beside(log.path), progress);
  for (const auto& [label, count] : made.scans) log.scans += count;
  log.not_finite = made.not_finite;
  log.poses = made.poses.count ? made.poses.source : "";
  log.notes = made.remarks;
  log.warnings = made.warnings;
  log.notes.insert(log.notes.begin(), contents_text(made) + "; " + poses_text(made.poses));
  return log;
}

}  // namespace talus::app
