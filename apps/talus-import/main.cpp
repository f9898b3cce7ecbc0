// talus-import: scans of other programs in, a log for talus-map out.
#include "../common/child_process.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"
#include "../common/progress_bar.h"
#include "../common/suspect.h"
#include "merged_sources.h"
#include "options.h"
#include "poses_out.h"
#include "rawlog_writer.h"

#include <talus/number_text.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <stdexcept>

namespace fs = std::filesystem;
using namespace talus::import;
using talus::app::OutputFolder;
using talus::app::ProgressBar;

namespace
{
constexpr const char* kLessAtOnce = "Import fewer sources at once";

void print_error(const std::string& text) { std::cerr << "talus-import: " << text << "\n"; }

/** What was read. */
struct Sums
{
  std::map<std::string, std::size_t> scans;  //!< by label
  std::size_t points = 0, not_finite = 0;
  double first_s = 0, last_s = 0;
  bool any = false;

  void add(const ImportedScan& scan)
  {
    first_s = any ? std::min(first_s, scan.time_s) : scan.time_s;
    last_s = any ? std::max(last_s, scan.time_s) : scan.time_s;
    any = true;
    ++scans[scan.sensor_label];
    points += scan.x_m.size();
    not_finite += scan.not_finite;
  }
};

std::string counted(std::size_t count, const std::string& what)
{
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/** A mounting for a sensor that there is not is a misspelt one. */
void require_sensors(const Options& o, const Sums& sums)
{
  std::string names;
  for (const auto& [label, count] : sums.scans) names += (names.empty() ? "" : ", ") + label;
  for (const auto& [label, mounting] : o.source.mountings)
    if (!sums.scans.count(label))
      throw std::runtime_error(
          "--mount " + label + ": no sensor is called that; there are: " + names + ".");
}

Sums write_scans(const Options& o, const std::string& path, MergedSources& sources)
{
  ProgressBar bar("talus-import", !o.quiet);
  RawlogWriter log(path);
  Sums sums;
  ImportedScan scan;
  while (sources.next(scan))
  {
    if (const auto m = o.source.mountings.find(scan.sensor_label); m != o.source.mountings.end())
      scan.T_base_sensor = m->second;
    log.write(scan);
    sums.add(scan);
    bar.show(sources.progress(), counted(sums.points, "point"));
  }
  if (sums.points == 0)
    throw std::runtime_error(
        o.sources.front() + ": " + counted(sums.scans.size(), "sensor") + " and " +
        (sums.not_finite ? counted(sums.not_finite, "point") + ", of which none is finite"
                         : "not a single point") +
        ": there is nothing to map. Compare it with its source.");
  require_sensors(o, sums);
  log.close();
  return sums;
}

/** Poses of another time are none. */
void require_poses_in_time(const Sums& sums, const WrittenPoses& poses)
{
  constexpr double kNear_s = 1;
  if (poses.count == 0) return;
  if (poses.first_s <= sums.last_s + kNear_s && poses.last_s >= sums.first_s - kNear_s) return;
  const auto span = [](double first_s, double last_s)
  { return talus::number_text(first_s, 13) + " to " + talus::number_text(last_s, 13) + " s"; };
  throw std::runtime_error(
      poses.source + ": its poses are of " + span(poses.first_s, poses.last_s) + ", the scans of " +
      span(sums.first_s, sums.last_s) +
      ". Give both the same clock: put a times.txt (seconds, a line a scan) into a folder of "
      "scans, "
      "or pass as many poses as there are scans.");
}

/** What lies beside a log counts as its poses. */
void require_no_old_poses(const std::string& tum)
{
  if (fs::exists(tum))
    throw std::runtime_error(
        tum +
        ": lies there already, but these scans have no poses, and talus-map would take those. "
        "Remove it, pass --poses, or give the log another name.");
}

void tell(const Options& o, const Sums& sums, const WrittenPoses& poses, const MergedSources& all)
{
  std::string sensors;
  for (const auto& [label, count] : sums.scans)
    sensors += (sensors.empty() ? "" : ", ") + counted(count, "scan") + " of " + label;
  std::cout << o.output << ": " << sensors << ", " << counted(sums.points, "point");
  if (sums.not_finite) std::cout << " (" << sums.not_finite << " more are not finite: left out)";
  std::cout << "\n";
  if (poses.count)
    std::cout << "  poses   " << poses.count << " of " << poses.source << ", over "
              << talus::fixed_text(poses.length_m, 1) << " m\n";
  else
    std::cout << "  poses   none: talus-map needs --trajectory FILE, or --static\n";
  for (const auto& remark : all.remarks()) std::cout << "  note    " << remark << "\n";
}

void import_all(const Options& o, const fs::path& folder)
{
  const fs::path output(o.output);
  MergedSources sources(o.sources, o.source);
  const Sums sums = write_scans(o, (folder / output.filename()).string(), sources);
  const std::string tum = talus::app::trajectory_beside(o.output);
  const auto poses =
      write_poses((folder / fs::path(tum).filename()).string(), o.source.poses, sources);
  require_poses_in_time(sums, poses);
  if (poses.count == 0) require_no_old_poses(tum);
  if (!o.quiet) tell(o, sums, poses, sources);
}

/** In a child: the exit code. */
int import_or_tell(const Options& o, const OutputFolder& folder)
{
  try
  {
    import_all(o, folder.staging());
    return 0;
  }
  catch (const std::exception& e)
  {
    print_error(folder.told(talus::app::failure_text(e, o.sources.front(), kLessAtOnce)));
    return 1;
  }
}

void require_all_apart(const Options& o)
{
  auto inputs = o.sources;
  if (!o.source.poses.empty()) inputs.push_back(o.source.poses);
  talus::app::require_apart(o.output, inputs);
  talus::app::require_apart(talus::app::trajectory_beside(o.output), inputs);
}

/** The exit code. */
int run(const Options& o)
{
  require_all_apart(o);
  const fs::path output(o.output);
  OutputFolder folder(output.has_parent_path() ? output.parent_path().string() : ".");
  const auto work = [&] { return import_or_tell(o, folder); };
  if (const int code = talus::app::run_command_in_child(o.sources.front(), work, print_error))
    return code;
  const std::string tum = talus::app::trajectory_beside(o.output);
  const bool has_poses = fs::exists(fs::path(folder.staging()) / fs::path(tum).filename());
  folder.commit(output.filename().string());
  if (!o.quiet) std::cout << "  wrote   " << o.output << (has_poses ? " and " + tum : "") << "\n";
  return 0;
}
}  // namespace

int main(int argc, char** argv)
{
  const talus::app::PrintableOutput printable;
  Options options;
  if (const auto code = parse_options(argc, argv, options)) return *code;
  try
  {
    talus::app::forward_signals();  // before any folder is made: a signal must not leave it behind
    return run(options);
  }
  catch (const std::exception& e)
  {
    print_error(talus::app::failure_text(e, options.sources.front(), kLessAtOnce));
    return 1;
  }
}
