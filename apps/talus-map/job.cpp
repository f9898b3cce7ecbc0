#include "job.h"

#include "../common/log_name.h"
#include "run_job.h"
#include "../common/output_folder.h"

#include <talus/import/scan_source.h>
#include <talus/io/packed_log.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
/** As a shell's *.rawlog sees it: what is hidden is none. */
bool is_rawlog(const fs::path& path)
{
  return path.filename().string().front() != '.' &&
         fs::path(io::without_packing(path.string())).extension() == ".rawlog";
}

std::vector<std::string> rawlogs_in(const std::string& folder)
{
  std::vector<std::string> logs;
  std::error_code ec;
  for (fs::directory_iterator i(folder, ec), end; !ec && i != end; i.increment(ec))
    if (is_rawlog(i->path()) && i->is_regular_file(ec)) logs.push_back(i->path().string());
  std::sort(logs.begin(), logs.end());
  return logs;
}

/** A folder always: who looks into it says what it lacks. */
bool is_importable(const std::string& path)
{
  std::error_code ec;
  return fs::is_directory(path, ec) || import::Input(path).format;
}

constexpr const char* kHidden = ".talus-import";  // never a result

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

std::vector<std::string> logs_in(const std::vector<std::string>& named)
{
  std::vector<std::string> logs;
  for (std::string name : named)
  {
    while (name.size() > 1 && name.back() == '/') name.pop_back();
    const auto inside = rawlogs_in(name);
    logs.insert(logs.end(), inside.begin(), inside.end());
    if (inside.empty()) logs.push_back(name);
  }
  return logs;
}

std::string name_of_source(const std::string& log)
{
  return name_of_log(import::format_by_ending(log) ? fs::path(log).stem().string() : log);
}

std::vector<Job> plan_jobs(const Options& options)
{
  if (options.logs.size() == 1 && !options.output.empty())
    return {
        {options.logs.front(), options.output, options.labels,
         is_importable(options.logs.front())}};
  std::vector<Job> jobs;
  std::set<std::string> taken;
  for (const auto& log : options.logs)
  {
    const std::string name = name_of_source(log);
    std::string unique = name;
    for (int i = 2; !taken.insert(unique).second; ++i) unique = name + "_" + std::to_string(i);
    const fs::path folder =
        options.output.empty() ? fs::path(unique + "_map") : fs::path(options.output) / unique;
    const bool one = options.labels.empty() || options.logs.size() == 1;
    const std::string labels = one ? options.labels : (fs::path(options.labels) / unique).string();
    jobs.push_back({log, folder.string(), labels, is_importable(log)});
  }
  return jobs;
}

Sharing share(
    const Options& options, const Settings& settings, std::size_t logs, int cores, int devices)
{
  constexpr int kOnADevice = 2;  // one reads its log while the other's frame is computed
  constexpr double kEnough_mb = 64;  // with less a site map goes to disk and back
  const int each = std::max(1, settings.threads);
  int at_once = options.jobs;
  if (at_once == 0) at_once = cores / each;
  if (options.jobs == 0 && options.has_site)
    at_once = std::min(at_once, static_cast<int>(options.memory_mb / kEnough_mb));
  if (options.jobs == 0 && devices > 0) at_once = std::min(at_once, kOnADevice * devices);
  Sharing s;
  s.at_once = std::clamp<std::size_t>(static_cast<std::size_t>(std::max(at_once, 1)), 1, logs);
  s.threads = settings.threads;
  if (s.threads == 0 && s.at_once > 1) s.threads = std::max(1, cores / static_cast<int>(s.at_once));
  s.memory_mb = options.memory_mb / static_cast<double>(s.at_once);
  return s;
}

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
  log.notes.insert(log.notes.begin(), contents_text(made) + "; " + poses_text(made));
  return log;
}

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
