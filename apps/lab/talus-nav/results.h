#pragma once
#include "options.h"
#include "picture.h"

#include <talus/hints/highest_ray.h>
#include <talus/sim/scanner.h>

#include <optional>
#include <string>

namespace talus::nav
{
/** Writes path.csv, summary.json and the last picture into a folder. Throws std::runtime_error. */
void write_results(
    const std::string& folder, const Options& options, const MissionResult& mission,
    const cv::Mat& picture);

/** A few lines for the terminal. */
std::string console_summary(const Options& options, const MissionResult& mission);

/** Of a scanner that is mounted like that, on a base that stands on level ground. */
hints::HighestRay highest_ray(const sim::Scanner& scanner, const Pose& T_base_sensor);

/** In Markdown: from which width on, and up to which speed, each known scanner finds a hole in
 * level ground in time for the robot to stop, and where ahead it sees what is as high as the robot.
 * `mount`: as of Options; empty: level and tilted forward, at the height that a world's sensor has
 * unless it says another. */
std::string drop_table(const std::optional<app::Mounting>& mount);

}  // namespace talus::nav
