#include "job.h"

#include "../common/log_name.h"

#include <talus/import/scan_source.h>
#include <talus/io/packed_log.h>

#include <algorithm>
#include <filesystem>
#include <set>

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

/** A folder always: what it lacks is told by who looks into it. */
bool is_importable(const std::string& path)
{
  std::error_code ec;
  return fs::is_directory(path, ec) || import::Input(path).format;
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

}  // namespace talus::app
