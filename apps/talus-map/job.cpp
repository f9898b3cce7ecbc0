#include "job.h"

#include "../common/log_name.h"

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

}  // namespace talus::app
