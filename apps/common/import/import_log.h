#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "merged_sources.h"

namespace CLI
{
class App;
}

namespace talus::import
{
/** What the command line says of how scans of other programs are read. */
struct ImportOptions
{
  SourceOptions source;
};

/** Adds the options of an import (--poses, --mount, --topic ...) to a command, or to a group of its
 * options. */
void add_import_options(CLI::App& app, ImportOptions& options);

/** Takes the mounting of a sensor, "LABEL=X,Y,Z,YAW,PITCH,ROLL". What is wrong with it, or "". */
std::string read_mounting(const std::string& text, SourceOptions& options);

/** What a log was made of. */
struct ImportedLog
{
  std::map<std::string, std::size_t> scans;  //!< by label
  std::size_t points = 0, not_finite = 0;  //!< that were kept, and left out
  double first_s = 0, last_s = 0;  //!< stamps of the first and the last scan
  WrittenPoses poses;
  Pieces pieces = Pieces::Scans;  //!< what its scans are
  std::vector<std::string> remarks;  //!< of the sources, a sentence each without its full stop
  std::vector<std::string> warnings;  //!< of what would make the map wrong
};

/** Called after each scan: the fraction done, and how many points there are so far. */
using ImportProgress = std::function<void(double done, const std::string& points)>;

/** Writes the scans of all sources, in the order of time, as a log, and their poses as TUM text
 * (where there are any). Throws std::runtime_error that names the file and what is wrong. */
ImportedLog import_log(
    const std::vector<std::string>& sources, const ImportOptions& options, const std::string& log,
    const std::string& tum, const ImportProgress& progress);

/** "2 scans of front, 1 scan of rear, 12 points (3 more are not finite: left out)". */
std::string contents_text(const ImportedLog& log);

/** Of one of them. */
const char* name_of(Pieces pieces);

/** "120 poses of drive.tum over 35.2 m" */
std::string poses_text(const ImportedLog& log);

}  // namespace talus::import
