#pragma once
#include <string>

namespace talus::io
{
class Trajectory;
}

namespace talus::app
{
/** What the results of a log are called: its file name without folder, `.gz`, `.zst`, `.rawlog`,
 * `.simplemap` and leading dots, so that no name of a log makes a hidden folder or leads out of the
 * one that was given. "unnamed" when nothing is left. */
std::string name_of_log(const std::string& log);

/** The same for a world, without the ending of its file. */
std::string name_of_world(const std::string& world);

/** "monday/site" for "logs/monday/site.tif": its file alone is called like all others. */
std::string name_of_map(const std::string& geotiff);

/** NAME.tum beside NAME.rawlog, whether there is such a file or not. */
std::string trajectory_beside(const std::string& log);

/** The poses of a log: of the file that is given, else of that beside it, else its own. `source`
 * gets which file, or which of its own. */
io::Trajectory poses_of_log(
    const std::string& log, const std::string& given, std::string* source = nullptr);

}  // namespace talus::app
