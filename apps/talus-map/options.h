#pragma once
#include <talus/elevation_mapper.h>
#include <talus/site/site.h>

#include <optional>
#include <string>
#include <vector>

#include "../common/export/export_files.h"
#include "../common/import/import_log.h"

namespace CLI
{
class App;
}

namespace talus::app
{
/** How the labels of points are written. */
enum class LabelsAs
{
  Kitti,  //!< a file a scan, in SemanticKITTI's format
  Rawlog  //!< one log of clouds
};

/** What the command line says. */
struct Options
{
  std::vector<std::string> logs;  //!< rawlogs, and folders, files and bags to import
  std::string trajectory;  //!< empty: beside the log, or within it; of an import, too
  bool robot_is_static = false;
  bool is_levelled = false;  //!< --level
  double max_gap_s = 0.5;  //!< longest time between two poses that is interpolated
  std::string sensor;  //!< label, empty: every sensor

  std::string config;  //!< INI file, empty: none
  std::vector<std::string> overrides;  //!< name=value
  std::optional<Backend> backend;
  std::optional<int> threads;
  std::optional<int> device;
  int jobs = 0;  //!< logs at once, 0: as many as find a core for each of their threads

  std::string output;  //!< empty: NAME_map for NAME.rawlog
  int every = 0;  //!< snapshots of every Nth frame, 0: none
  bool has_site = true;  //!< all that the drive saw is kept and written
  double memory_mb = 512;  //!< what of it stays in memory, of all jobs
  bool keep_new = false;  //!< cells that come back start empty
  bool keep_far = false;  //!< what lies kilometres from all else is written, too
  bool traffic = false;  //!< where things moved is written, too
  std::string resume;  //!< site map of an earlier run, empty: none
  std::optional<site::GeoOrigin> origin;
  std::string rawlog_out;  //!< the log with snapshots in it (each, or every Nth); empty: none
  bool risk = false;  //!< the layer risk, too
  std::vector<Channel> channels;  //!< values of points that become layers, by the names of the log
  std::string labels;  //!< folder of the labels of points; empty: none
  LabelsAs labels_as = LabelsAs::Kitti;
  ExportOptions exports;  //!< the site map is written so, too; without one the window
  import::ImportOptions import;
  std::vector<std::string> import_switches;  //!< given, though only an import heeds them
  bool keep_log = false;  //!< the log that an import makes is a result
  bool quiet = false;
  bool strict = false;  //!< hints are errors
  bool suggest = false;  //!< print a configuration, write nothing
};

/** Adds the options, the description and the footer of the command. */
void add_options(CLI::App& app, Options& options);

}  // namespace talus::app
