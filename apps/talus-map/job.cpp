#include "job.h"

#include "../common/log_name.h"

#include <algorithm>
#include <filesystem>
#include <set>

namespace fs = std::filesystem;

namespace talus::app
{
std::vector<Job> plan_jobs(const Options& options)
{
  if (options.logs.size() == 1 && !options.output.empty())
    return {{options.logs.front(), options.output}};
  std::vector<Job> jobs;
  std::set<std::string> taken;
  for (const auto& log : options.logs)
  {
    const std::string name = name_of_log(log);
    std::string unique = name;
    for (int i = 2; !taken.insert(unique).second; ++i) unique = name + "_" + std::to_string(i);
    const fs::path folder =
        options.output.empty() ? fs::path(unique + "_map") : fs::path(options.output) / unique;
    jobs.push_back({log, folder.string()});
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
