#pragma once
#include "../common/import/import_log.h"
#include "job.h"

#include <functional>
#include <string>
#include <vector>

namespace talus::app
{
/** The rawlog that a job reads. */
struct SourceLog
{
  std::string path;
  bool is_imported = false;  //!< it was made of scans of another program
  std::size_t scans = 0;  //!< of an import
  std::size_t not_finite = 0;  //!< points that an import left out
  std::string poses;  //!< of an import: where its poses, beside the log, come from; "": it has none
  std::vector<std::string> notes;  //!< what was read and assumed, a line each
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
