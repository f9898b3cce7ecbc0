#include "results.h"

#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/io/quantile.h>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::nav
{
namespace
{
std::string path_csv(const MissionResult& mission)
{
  std::string text =
      "time_s,x_m,y_m,z_m,yaw_rad,x_estimated_m,y_estimated_m,v_mps,w_radps,map_ms,plan_ms,"
      "pilot_ms,obstacles\n";
  for (const Step& s : mission.steps)
  {
    char line[300];
    std::snprintf(
        line, sizeof line, "%.2f,%.4f,%.4f,%.4f,%.5f,%.4f,%.4f,%.4f,%.4f,%.3f,%.3f,%.3f,%zu\n",
        s.time_s, s.x_m, s.y_m, s.z_m, s.yaw_rad, s.x_estimated_m, s.y_estimated_m, s.v_mps,
        s.w_radps, s.map_ms, s.plan_ms, s.pilot_ms, s.obstacles);
    text += line;
  }
  return text;
}

double median_of(const MissionResult& mission, double Step::*value)
{
  std::vector<double> values;
  for (const Step& s : mission.steps)
    if (s.*value > 0) values.push_back(s.*value);
  return values.empty() ? 0 : io::quantile(values, 0.5);
}

nlohmann::json summary(const Options& o, const MissionResult& mission)
{
  std::vector<double> obstacles;
  for (const Step& s : mission.steps) obstacles.push_back(static_cast<double>(s.obstacles));
  return {
      {"version", TALUS_VERSION},
      {"world", fs::path(o.world).filename().string()},
      {"goal_m", o.goal},
      {"planner", o.in_3d ? "3d" : "2d"},
      {"map", o.map},
      {"scanner", o.scanner},
      {"mount", o.mount ? nlohmann::ordered_json(*o.mount) : nlohmann::ordered_json::array()},
      {"seed", o.seed},
      {"noise",
       {{"range_m", o.noise.range_m},
        {"position_m", o.noise.position_m},
        {"angle_rad", o.noise.angle_rad}}},
      {"ending", info_of(mission.ending).name},
      {"detail", mission.detail},
      {"time_s", mission.time_s},
      {"driven_m", mission.driven_m},
      {"steps", mission.steps.size()},
      {"median_ms",
       {{"map", median_of(mission, &Step::map_ms)},
        {"route", median_of(mission, &Step::plan_ms)},
        {"navigator", median_of(mission, &Step::pilot_ms)}}},
      {"median_obstacles", io::quantile(obstacles, 0.5)}};
}
}  // namespace

void write_results(
    const std::string& folder, const Options& options, const MissionResult& mission,
    const cv::Mat& picture)
{
  const fs::path to(folder);
  io::write_png((to / "navigation.png").string(), picture);
  io::write_file((to / "path.csv").string(), path_csv(mission));
  // A file name need not be UTF-8, JSON is.
  const auto json =
      summary(options, mission).dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  io::write_file((to / "summary.json").string(), json + "\n");
}

std::string console_summary(const Options& options, const MissionResult& mission)
{
  char times[100];
  std::snprintf(
      times, sizeof times, "map %.1f, route %.1f, navigator %.1f",
      median_of(mission, &Step::map_ms), median_of(mission, &Step::plan_ms),
      median_of(mission, &Step::pilot_ms));
  return options.world + ": " + info_of(mission.ending).name + "\n  " + mission.detail +
         "\n  median ms a step: " + times + "\n";
}

}  // namespace talus::nav
