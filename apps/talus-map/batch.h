#pragma once
#include "job.h"
#include "settings.h"

#include <vector>

namespace talus::app
{
enum ExitCode
{
  kDone = 0,
  kSomeFailed = 1,
  kUsage = 2
};

/** Maps all logs, some at once, and says how the batch went. The exit code of the program. */
int run_batch(std::vector<Job> jobs, const Options& options, const Settings& settings);

}  // namespace talus::app
