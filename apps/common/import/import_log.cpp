#include "import_log.h"

#include "merged_sources.h"
#include "rawlog_writer.h"

#include <talus/io/quantile.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::import
{
namespace
{
void add(const ImportedScan& scan, ImportedLog& log)
{
  const bool is_first = log.scans.empty();
  log.first_s = is_first ? scan.time_s : std::min(log.first_s, scan.time_s);
  log.last_s = is_first ? scan.time_s : std::max(log.last_s, scan.time_s);
  ++log.scans[scan.sensor_label];
  log.points += scan.x_m.size();
  log.not_finite += scan.not_finite;
}

/** No scanner sees half of its points so far away. */
void warn_of_units(const ImportedScan& scan, ImportedLog& log)
{
  constexpr double kFar_m = 250, kCentimetres_m = 2500;
  std::vector<float> ranges_m;
  for (std::size_t i = 0; i < scan.x_m.size(); ++i)
    ranges_m.push_back(std::hypot(scan.x_m[i], scan.y_m[i], scan.z_m[i]));
  const double median_m = io::quantile(ranges_m, 0.5);
  if (!(median_m > kFar_m)) return;
  log.warnings.push_back(
      "half of the points of the first scan of " + scan.sensor_label + " are farther than " +
      fixed_text(median_m, 0) + " m: are these " +
      (median_m < kCentimetres_m ? "centimetres (--scale 0.01)?" : "millimetres (--scale 0.001)?"));
}

std::string counted(std::size_t count, const std::string& what)
{
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/** A mounting for a sensor that there is not is a misspelt one. */
void require_sensors(const SourceOptions& o, const ImportedLog& log)
{
  std::string names;
  for (const auto& [label, count] : log.scans) names += (names.empty() ? "" : ", ") + label;
  for (const auto& [label, mounting] : o.mountings)
    if (label.empty() && log.scans.size() > 1)
      throw std::runtime_error(
          "--mount: say which sensor, as LABEL=...; there are: " + names + ".");
    else if (!label.empty() && !log.scans.count(label))
      throw std::runtime_error(
          "--mount " + label + ": no sensor is called that; there are: " + names + ".");
}

void require_points(const std::string& source, const ImportedLog& log)
{
  if (log.points > 0) return;
  throw std::runtime_error(
      source + ": " + counted(log.scans.size(), "sensor") + " and " +
      (log.not_finite ? counted(log.not_finite, "point") + ", of which none is finite"
                      : "not a single point") +
      ": there is nothing to map. Compare it with its source.");
}

/** Poses of another time are none. */
void require_poses_in_time(const ImportedLog& log)
{
  constexpr double kNear_s = 1;
  const WrittenPoses& poses = log.poses;
  if (poses.count == 0) return;
  if (poses.first_s <= log.last_s + kNear_s && poses.last_s >= log.first_s - kNear_s) return;
  const auto span = [](double first_s, double last_s)
  { return number_text(first_s, 13) + " to " + number_text(last_s, 13) + " s"; };
  throw std::runtime_error(
      poses.source + ": its poses are of " + span(poses.first_s, poses.last_s) + ", the scans of " +
      span(log.first_s, log.last_s) +
      ". Give both the same clock: of a bag, --recorded-times takes the times at which its scans "
      "were recorded; for a folder of scans, put a times.txt (seconds, a line a scan) into it.");
}

/** `is_again`: bytes should have meant what `notes` then says. */
ImportedLog write_scans(
    const SourceOptions& o, const std::string& path, MergedSources& sources, PointNotes& notes,
    bool& is_again, const ImportProgress& progress)
{
  notes.pieces = sources.pieces();
  RawlogWriter writer(path, notes);
  ImportedLog log;
  log.pieces = notes.pieces;
  ImportedScan scan;
  bool loses_times = false;
  while (sources.next(scan))
  {
    if (const auto* mounting = o.mounting_of(scan.sensor_label);
        mounting && notes.pieces != Pieces::Tiles)
      scan.T_base_sensor = *mounting;
    if (!log.scans.count(scan.sensor_label)) warn_of_units(scan, log);
    writer.write(scan);
    loses_times |= !scan.rgb.empty() && !scan.point_time_s.empty();
    add(scan, log);
    progress(sources.progress(), counted(log.points, "point"));
  }
  writer.close();
  is_again = writer.wants(notes);
  if (const PointNotes& used = writer.notes(); used.step != 1)
    log.remarks.push_back(
        "the intensities are kept in 256 steps " + used.range_text() +
        ", as clouds of MRPT with times of points have bytes for them");
  if (loses_times)
    log.remarks.emplace_back(
        "the times of the points are left out: clouds of MRPT keep colours or times, not both");
  return log;
}

/** Checks what was made, and adds its poses and what is to be known of it. */
void finish(
    const std::vector<std::string>& sources, const SourceOptions& options, MergedSources& merged,
    const std::string& tum, ImportedLog& made)
{
  require_points(sources.front(), made);
  require_sensors(options, made);
  made.poses = write_poses(tum, options, merged);
  require_poses_in_time(made);
  const auto remarks = merged.remarks();
  made.remarks.insert(made.remarks.begin(), remarks.begin(), remarks.end());
  for (auto& warning : merged.warnings()) made.warnings.push_back(std::move(warning));
}
}  // namespace

ImportedLog import_log(
    const std::vector<std::string>& sources, const ImportOptions& options, const std::string& log,
    const std::string& tum, const ImportProgress& progress)
{
  SourceOptions source = options.source;
  PointNotes notes;
  notes.values = source.values;
  for (;;)
  {
    MergedSources merged(sources, source);
    bool is_again = false;
    ImportedLog made = write_scans(source, log, merged, notes, is_again, progress);
    if (merged.wants(source) || is_again) continue;
    finish(sources, source, merged, tum, made);
    return made;
  }
}

const char* name_of(Pieces pieces)
{
  return pieces == Pieces::Scans ? "scan" : pieces == Pieces::Tiles ? "tile" : "viewpoint";
}

std::string contents_text(const ImportedLog& log)
{
  std::string text;
  for (const auto& [label, count] : log.scans)
    text += (text.empty() ? "" : ", ") + counted(count, name_of(log.pieces)) + " of " + label;
  text += ", " + counted(log.points, "point");
  if (log.not_finite)
    text += " (" + std::to_string(log.not_finite) + " more are not finite: left out)";
  return text;
}

std::string poses_text(const ImportedLog& log)
{
  const WrittenPoses& poses = log.poses;
  if (poses.count == 0) return "no poses";
  if (log.pieces != Pieces::Scans) return "no path of the robot";
  return counted(poses.count, "pose") + " of " + poses.source + " over " +
         fixed_text(poses.length_m, 1) + " m";
}

}  // namespace talus::import
