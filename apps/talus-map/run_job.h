#pragma once
#include <string>
#include <vector>

#include "../common/run_app.h"
#include "job.h"

namespace talus::app
{
/** Maps one log in a child process, so that a crash over a corrupt file costs one log, and lets the
 * results appear when all of them are written. `label` goes before the progress bar. True when
 * done; else the reason has been printed. */
bool run_job(
    const Job& job, const Options& options, const Settings& settings, const std::string& label);

/** Reads one log, likewise, and prints a configuration that suits it. */
bool suggest_settings(const Job& job, const Options& options, const Settings& settings);

/** Checks, in a child process, that the map can be made with these settings. False when not: the
 * reason has been printed. */
bool settings_work(const Settings& settings);

/** How many devices the CUDA backend has; asked in a child process, as CUDA does not survive
 * fork(). */
int count_devices();

/** Throws std::runtime_error when a result of the job would replace a file that the run reads, or
 * when --rawlog-out names a file that the run reads or another that it writes. The site map of
 * --resume may be replaced: it goes on in the new one. */
void require_files_apart(const Job& job, const Options& options);

enum ExitCode
{
  kDone = 0,
  kSomeFailed = 1,
  kUsage = 2,
  kWithoutSite = 3  //!< of a child: everything else is there
};

/** Maps all logs, some at once, and says how the batch went. The exit code of the program. */
int run_batch(std::vector<Job> jobs, const Options& options, const Settings& settings);

}  // namespace talus::app
