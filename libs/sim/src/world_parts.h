#pragma once
#include <talus/sim/robot.h>

#include "fields.h"

namespace talus::sim
{
/** The sections of a world file. Each throws as load_world() does. */
Ground parse_ground(const YAML::Node& list, const std::string& file);
/** `path`: of the robot; scattered things keep clear of it. */
std::vector<Shape> parse_objects(
    const YAML::Node& list, const std::string& file, const Ground& ground, const RobotPath& path);
std::vector<Mover> parse_movers(const YAML::Node& list, const std::string& file);

}  // namespace talus::sim
