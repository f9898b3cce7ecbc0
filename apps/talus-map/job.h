#pragma once
#include "../common/import/import_log.h"
#include "options.h"
#include "../common/settings.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace talus::app
{
/** One log of the batch and where its results go. */
struct Job
{
  std::string log, folder;
  std::string labels = {};  //!< folder of the labels of its points; empty: none
  bool needs_import = false;  //!< the log is to be made of scans of another program
  int threads = kAllCores;  //!< of the CPU backend
  int device = 0;  //!< of the CUDA backend
};

/** What the logs of a batch share. */
struct Sharing
{
  std::size_t at_once = 1;  //!< logs
  int threads = 0;  //!< of each, 0: all cores
  double memory_mb = 0;  //!< of the site map of each
};

/** By what was asked for and what there is to work with. */
Sharing share(
    const Options& options, const Settings& settings, std::size_t logs, int cores, int devices);

/** The files and folders that a command line names, the rawlogs of each folder in its place; a
 * folder of scans and a bag are one. */
std::vector<std::string> logs_in(const std::vector<std::string>& named);

/** What the results of a log, a bag, a folder or a file of scans are called: name_of_log(), without
 * the ending of a file of another program. */
std::string name_of_source(const std::string& log);

/** One job a log. Several logs of the same name get folders NAME, NAME_2, ... */
std::vector<Job> plan_jobs(const Options& options);

/** The rawlog that a job reads. */
struct SourceLog
{
  std::string path;
  bool is_imported = false;  //!< it was made of scans of another program
  std::size_t scans = 0;  //!< of an import
  std::size_t not_finite = 0;  //!< points that an import left out
  std::string poses;  //!< of an import: where its poses, beside the log, come from; "": it has none
  std::vector<std::string> notes;  //!< what was read and assumed, a line each
  std::vector<std::string> warnings;  //!< of an import
};

/** Where the rawlog of a job lies: as it was named, or, of an import, in the folder of the results
 * (with --keep-log), or hidden in it until that folder is removed. */
std::string path_of_log(const Job& job, const Options& options, const std::string& folder);

/** Makes it, where a job needs an import. Throws std::runtime_error that names the file and what is
 * wrong. */
SourceLog source_log(
    const Job& job, const Options& options, const std::string& folder,
    const import::ImportProgress& progress);

/** What --keep-log adds to the results: the log and its poses; nothing for a job without import. */
std::vector<std::string> kept_logs(const Job& job, const Options& options);

}  // namespace talus::app
