#pragma once
#include "job.h"

namespace talus::app
{
/** Throws std::runtime_error when a result of the job would replace a file that the run reads, or
 * when --rawlog-out names a file that the run reads or another that it writes. The site map of
 * --resume may be replaced: it goes on in the new one. */
void require_files_apart(const Job& job, const Options& options);

}  // namespace talus::app
