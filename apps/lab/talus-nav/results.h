#pragma once
#include "options.h"
#include "picture.h"

#include <string>

namespace talus::nav
{
/** Writes path.csv, summary.json and the last picture into a folder. Throws std::runtime_error. */
void write_results(
    const std::string& folder, const Options& options, const MissionResult& mission,
    const cv::Mat& picture);

/** A few lines for the terminal. */
std::string console_summary(const Options& options, const MissionResult& mission);

}  // namespace talus::nav
