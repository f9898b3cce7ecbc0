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

/** One job a log. Several logs of the same name get folders NAME, NAME_2, ... */
std::vector<Job> plan_jobs(const Options& options);

}  // namespace talus::app
