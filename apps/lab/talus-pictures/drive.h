#pragma once
#include "oblique.h"

#include <string>
#include <vector>

namespace talus::pictures
{
/** Pictures of a drive, seen from one place: the maps that talus-map --every wrote, in their order,
 * each over those of before, with the robot in the middle of the newest. Writes
 * FOLDER/drive_000.png and so on. Throws std::runtime_error that names the file. */
void write_drive(
    const std::vector<std::string>& maps, const Camera& camera, const std::string& folder);

}  // namespace talus::pictures
