#pragma once
#include <string>

#include "merged_sources.h"

namespace talus::import
{
/** What was done about the poses of a log. */
struct WrittenPoses
{
  std::size_t count = 0;  //!< 0: there are none, nothing was written
  double length_m = 0;  //!< of the way through them
  double first_s = 0, last_s = 0;
  std::string source;  //!< file or folder that they come from
};

/** Writes the poses of a log, whose scans were all read, as TUM text: those of the file that the
 * options name, a TUM file with poses of the base as it is, else those that the sources have.
 * Throws std::runtime_error that names the file and what is wrong. */
WrittenPoses write_poses(
    const std::string& tum, const SourceOptions& options, MergedSources& sources);

}  // namespace talus::import
