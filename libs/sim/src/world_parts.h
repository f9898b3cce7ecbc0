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
/** Its ground, objects, robot and sensor are there already. */
std::vector<Mover> parse_movers(
    const YAML::Node& list, const std::string& file, const World& world);

/** When and where a mover is first inside something solid that stands still. Nothing real is, and
 * no map can be right about it. */
struct Collision
{
  double time_s, x_m, y_m;
};
std::optional<Collision> first_collision(const Mover& mover, const World& world);
/** When and where, during the drive, it is first inside the robot: a box over its wheels, as high
 * as its sensor. */
std::optional<Collision> first_meeting(const Mover& mover, const World& world);

}  // namespace talus::sim
