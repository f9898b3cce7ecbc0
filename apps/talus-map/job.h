#pragma once
#include "options.h"

#include <string>
#include <vector>

namespace talus::app
{
/** One log of the batch and where its results go. */
struct Job
{
  std::string log, folder;
};

/** The file name of a log without folder, `.gz` and `.rawlog`. */
std::string name_of_log(const std::string& log);

/** One job a log. Several logs of the same name get folders NAME, NAME_2, ... */
std::vector<Job> plan_jobs(const Options& options);

}  // namespace talus::app
