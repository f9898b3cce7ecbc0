#pragma once
#include <talus/sim/robot.h>

#include "fields.h"

namespace talus::sim
{
/** When a thing is there: from_s and until_s of a part of the ground, an object or a mover. */
struct Presence
{
  explicit Presence(const Fields& f);
  bool holds(double time_s) const { return from_s <= time_s && time_s < until_s; }

  double from_s = -std::numeric_limits<double>::infinity();
  double until_s = std::numeric_limits<double>::infinity();
};
constexpr const char* kPresenceKeys = " from_s until_s";  //!< after those of the thing

/** The sections of a world file. Each throws as load_world() does. */
void parse_ground(const YAML::Node& list, const std::string& file, World& world);
/** Objects and decks. Ground and robot are there already: scattered things keep off its path. */
void parse_objects(const YAML::Node& list, const std::string& file, World& world);
RobotSetup parse_robot(const YAML::Node& node, const std::string& file);
SensorSetup parse_sensor(const YAML::Node& node, const std::string& file);
std::vector<SensorSetup> parse_sensors(const YAML::Node& list, const std::string& file);
PoseErrors parse_poses(const YAML::Node& node, const std::string& file);
/** Its ground, objects, robot and sensors are there already. */
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
