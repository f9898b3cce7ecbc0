// talus-map: rawlogs in; maps, pictures and timing out.
#include "../common/child_process.h"
#include "../common/export/export_files.h"
#include "../common/output_folder.h"
#include "../common/run_app.h"
#include "run_job.h"
#include "job.h"
#include "options.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

using namespace talus::app;

namespace
{
/** A device that is not there is an error, unless the CPU may do without. */
bool has_device(Settings& settings)
{
  if (settings.backend == talus::Backend::Cuda) return settings_work(settings);
  if (settings.backend == talus::Backend::Cpu || !settings.device) return true;
  const int devices = count_devices();
  if (*settings.device < devices) return true;
  print_error(
      "warning: device " + std::to_string(*settings.device) + ": there are only " +
      std::to_string(devices) + " devices; the cpu makes the same map");
  settings.backend = talus::Backend::Cpu;
  return true;
}

/** Whether switches of an import were given, and nothing is to be imported: they would be ignored.
 * What is missing says so itself. */
bool has_idle_switches(const std::vector<Job>& jobs, const Options& options)
{
  const auto is_import = [](const Job& job)
  { return job.needs_import || !std::filesystem::exists(job.log); };
  if (options.import_switches.empty() || std::any_of(jobs.begin(), jobs.end(), is_import))
    return false;
  print_error(
      options.import_switches.front() +
      ": is for scans of other programs, and there are only rawlogs, which say all that "
      "themselves");
  return true;
}

/** Everything that is wrong before any log is read. */
int run(const Options& options)
{
  Settings settings;
  try
  {
    settings = load_settings(options.config, options.overrides, options.channels);
    if (options.backend) settings.backend = *options.backend;
    if (options.threads) settings.threads = *options.threads;
    if (options.device) settings.device = options.device;
    require_exportable(options.exports);
    if (!options.suggest) require_writable(options.output.empty() ? "." : options.output);
  }
  catch (const std::exception& e)
  {
    print_error(e.what());
    return kUsage;
  }
  for (const auto& warning : settings.warnings) print_error("warning: " + warning);
  if (!has_device(settings)) return kUsage;
  const auto jobs = plan_jobs(options);
  if (has_idle_switches(jobs, options)) return kUsage;
  if (!options.suggest) return run_batch(jobs, options, settings);
  const bool done = suggest_settings(jobs.front(), options, settings);
  return stop_signal() ? 128 + stop_signal() : done ? kDone : kSomeFailed;
}
}  // namespace

int main(int argc, char** argv) { return run_app("talus-map", argc, argv, run); }
