#include "../common/import/import_log.h"
#include "log_mapper.h"

#include <mrpt/core/format.h>
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/io/quantile.h>
#include <talus/io/summary_json.h>

#include <algorithm>
#include <filesystem>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
void write_map(
    const std::string& tif, const std::string& png, const io::LayerStack& map,
    const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin)
{
  const auto& run = mapper.summary();
  const auto& robot = mapper.last_base();
  const std::string log = fs::path(run.log).filename().string();
  const double stamp_s = run.frames.back().stamp_s;
  io::write_geotiff(
      tif, map,
      {{"TALUS_VERSION", run.version},
       {"LOG", log},
       {"FRAMES", std::to_string(run.frames.size())},
       {"STAMP_S", mrpt::format("%.6f", stamp_s)},
       {"ROBOT_X_M", mrpt::format("%.6f", robot.x())},
       {"ROBOT_Y_M", mrpt::format("%.6f", robot.y())},
       {"ROBOT_Z_M", mrpt::format("%.6f", robot.z())},
       {"ROBOT_YAW_RAD", mrpt::format("%.6f", robot.yaw())}},
      origin);
  io::PictureOptions picture;
  const std::string date = io::date_text(stamp_s);
  picture.title = mrpt::format("%s, frame %zu, ", log.c_str(), run.frames.size()) +
                  (date.empty() ? mrpt::format("t = %.3f s", stamp_s) : date);
  picture.driven_m = mapper.driven_m();
  picture.has_robot = true;
  picture.robot_x_m = robot.x();
  picture.robot_y_m = robot.y();
  picture.robot_yaw_rad = robot.yaw();
  picture.way.assign(mapper.last_way().begin(), mapper.last_way().end());
  io::write_map_picture(png, map, picture);
}

/** 1234567 as "1.23 M". */
std::string short_count(std::uint64_t n)
{
  if (n < 100000) return std::to_string(n);
  return n < 10000000 ? mrpt::format("%.2f M", 1e-6 * static_cast<double>(n))
                      : mrpt::format("%.1f M", 1e-6 * static_cast<double>(n));
}

std::string counts(const std::map<std::string, std::size_t>& by_name)
{
  std::string text;
  for (const auto& [name, count] : by_name)
    text += (text.empty() ? "" : ", ") + name + " x " + std::to_string(count);
  return text;
}

std::string points_line(const io::RunSummary& run)
{
  const auto sum = io::totals_of(run.frames);
  std::string text = short_count(sum.in) + " in, " + short_count(sum.accepted) + " accepted";
  std::string reasons;
  for (int i = 0; i < kRejectCount; ++i)
    if (sum.rejected[i] > 0)
      reasons += std::string(reasons.empty() ? "" : ", ") + kRejectNames[i] + " " +
                 short_count(sum.rejected[i]);
  return reasons.empty() ? text : text + "; rejected: " + reasons;
}

std::string map_line(const io::LayerStack& map)
{
  const auto c = io::coverage_of(map);
  return mrpt::format(
      "%.4g x %.4g m of %.3g m cells: %.1f %% measured, %.1f %% filled from two sides, %.1f %% "
      "from "
      "one, %.1f %% presumed, %.1f %% unknown",
      map.cells_x * map.resolution_m, map.cells_y * map.resolution_m, map.resolution_m,
      100 * c.measured, 100 * c.filled_two_sided, 100 * c.filled_one_sided, 100 * c.presumed,
      100 * c.unknown);
}

std::string site_line(const io::SiteSummary& site)
{
  const auto& c = site.cells;
  const double all = std::max(1.0, static_cast<double>(c[1] + c[2] + c[3] + c[4]));
  std::string where;
  if (site.floors > 1) where += mrpt::format(" on %d floors", site.floors);
  if (site.islands > 0) where += mrpt::format(" in %d places far apart", site.islands + 1);
  const std::string way =
      site.length_m > 0 ? mrpt::format(" along %.4g m of way", site.length_m) : "";
  return mrpt::format(
      "%.4g m2%s%s: %.1f %% measured, %.1f %% filled from two sides, %.1f %% "
      "from one, %.1f %% presumed",
      site.area_m2, way.c_str(), where.c_str(), 100 * static_cast<double>(c[1]) / all,
      100 * static_cast<double>(c[2]) / all, 100 * static_cast<double>(c[3]) / all,
      100 * static_cast<double>(c[4]) / all);
}
}  // namespace

void write_results(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin)
{
  const fs::path to(folder);
  const io::LayerStack map = mapper.layers();
  write_map((to / "map.tif").string(), (to / "map.png").string(), map, mapper, origin);
  io::write_timing_csv((to / "timing.csv").string(), mapper.summary().frames);
  io::write_summary_json((to / "summary.json").string(), mapper.summary(), map);
}

void write_snapshot(
    const std::string& folder, const LogMapper& mapper, const std::optional<io::GeoOrigin>& origin)
{
  const fs::path frames = fs::path(folder) / "frames";
  fs::create_directories(frames);
  const std::string stem =
      (frames / mrpt::format("frame_%06zu", mapper.summary().frames.size())).string();
  write_map(stem + ".tif", stem + ".png", mapper.layers(), mapper, origin);
}

std::string console_summary(const LogMapper& mapper)
{
  const auto& run = mapper.summary();
  std::vector<double> ms;
  std::size_t skipped = 0;
  for (const auto& f : run.frames) ms.push_back(f.total_ms);
  for (const auto& entry : run.skipped) skipped += entry.second;
  const bool has_poses = mapper.notes().pieces == import::Pieces::Scans;
  const char* const unit = has_poses ? "frame" : import::name_of(mapper.notes().pieces);
  std::string text = mrpt::format(
      "%s: %zu %s%s, %zu skipped, %.2f ms a %s (median; p99 %.2f) on %s\n", run.log.c_str(),
      run.frames.size(), unit, run.frames.size() == 1 ? "" : "s", skipped, io::quantile(ms, 0.5),
      unit, io::quantile(ms, 0.99), run.backend.c_str());
  for (std::size_t i = 0; i < run.imported.size(); ++i)
    text += (i == 0 ? "  import  " : "  note    ") + run.imported[i] + "\n";
  if (has_poses)
    text +=
        "  poses   " + run.pose_source +
        (run.frames_deskewed ? mrpt::format(", %zu frames deskewed", run.frames_deskewed) : "") +
        "\n";
  if (run.sensors.size() > 1) text += "  sensors " + counts(run.sensors) + "\n";
  text += "  points  " + points_line(run) + "\n";
  text += "  map     " + map_line(io::snapshot(mapper.map())) + "\n";
  if (run.site) text += "  site    " + site_line(*run.site) + "\n";
  if (!run.unsupported.empty()) text += "  unused  " + counts(run.unsupported) + "\n";
  return text;
}

std::string suggestion_ini(const LogMapper& mapper)
{
  const auto& run = mapper.summary();
  const std::string log = fs::path(run.log).filename().string();
  std::string creation, insertion;
  for (const auto& s : mapper.suggest())
  {
    const bool is_window = s.name == "resolution_m" || s.name == "window_m";
    (is_window ? creation : insertion) += s.name + " = " + s.value + "  // " + s.reason + "\n";
  }
  const std::string ground =
      creation.empty() ? "# No ground was seen in it: window and heights are left as they are.\n"
                       : "";
  return "# Made from " + std::to_string(run.frames.size()) + " scans of " + log +
         " by talus-map --suggest; see doc/parameters.md\n" + ground +
         "\n[CDualElevationMap_creationOpts]\n" + creation + "\n[CDualElevationMap_insertOpts]\n" +
         insertion;
}

}  // namespace talus::app
