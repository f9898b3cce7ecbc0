#pragma once
#include "../../common/mounting.h"

#include <optional>
#include <string>

namespace talus::nav
{
/** In Markdown: from which width on, and up to which speed, each known scanner finds a hole in
 * level ground in time for the robot to stop, and where ahead it sees what is as high as the robot.
 * `mount`: as of Options; empty: level and tilted
 * forward, at the height that a world's sensor has unless it says another. */
std::string drop_table(const std::optional<app::Mounting>& mount);

}  // namespace talus::nav
