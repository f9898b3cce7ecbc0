// talus-map: rawlogs in; maps, pictures and timing out.
#include "../common/child_process.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "job.h"
#include "options.h"
#include "run_job.h"
#include "settings.h"

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

using namespace talus::app;

namespace
{
enum ExitCode
{
  kDone = 0,
  kSomeFailed = 1,
  kUsage = 2
};

/** Runs all jobs, one after the other, and says how the batch went. */
int run_batch(const std::vector<Job>& jobs, const Options& options, const Settings& settings)
{
  std::vector<std::string> failed;
  for (std::size_t i = 0; i < jobs.size(); ++i)
  {
    std::string label = name_of_log(jobs[i].log);
    if (jobs.size() > 1)
      label = std::to_string(i + 1) + "/" + std::to_string(jobs.size()) + " " + label;
    if (!run_job(jobs[i], options, settings, label))
      failed.push_back(jobs[i].log);
    else if (!options.quiet)
      std::cout << "  wrote   " << (std::filesystem::path(jobs[i].folder) / "map.png").string()
                << (options.has_site ? ", site.png\n" : "\n");
    if (stop_signal()) return 128 + stop_signal();
  }
  if (jobs.size() > 1 && !options.quiet)
    std::cout << jobs.size() << " logs: " << jobs.size() - failed.size() << " done, "
              << failed.size() << " failed\n";
  if (jobs.size() > 1 && !failed.empty())
  {
    std::string list;
    for (const auto& log : failed) list += "\n  " + log;
    print_error(std::to_string(failed.size()) + " of the logs failed:" + list);
  }
  return failed.empty() ? kDone : kSomeFailed;
}

/** Everything that is wrong before any log is read. */
int run(const Options& options)
{
  Settings settings;
  try
  {
    settings = load_settings(options.config, options.overrides);
    if (options.backend) settings.backend = *options.backend;
    if (options.threads) settings.threads = *options.threads;
    forward_signals();  // before any folder is made: a signal must not leave it behind
    if (!options.suggest) require_writable(options.output.empty() ? "." : options.output);
  }
  catch (const std::exception& e)
  {
    print_error(e.what());
    return kUsage;
  }
  for (const auto& warning : settings.warnings) print_error("warning: " + warning);
  if (settings.backend == talus::Backend::Cuda && !settings_work(settings)) return kUsage;
  const auto jobs = plan_jobs(options);
  if (options.suggest)
  {
    const bool done = suggest_settings(jobs.front(), options, settings);
    return stop_signal() ? 128 + stop_signal() : done ? kDone : kSomeFailed;
  }
  return run_batch(jobs, options, settings);
}
}  // namespace

int main(int argc, char** argv)
{
  const PrintableOutput printable;
  Options options;
  if (const auto code = parse_options(argc, argv, options)) return *code;
  return run(options);
}
