#pragma once
#include <string>
#include <vector>

namespace talus::nav
{
/** In Markdown: from which width on, and up to which speed, each known scanner finds a hole in
 * level ground in time for the robot to stop. `mount`: as of Options; empty: level and tilted
 * forward, at the height that a world's sensor has unless it says another. */
std::string drop_table(const std::vector<double>& mount);

}  // namespace talus::nav
