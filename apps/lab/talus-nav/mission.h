#pragma once
#include "map_source.h"
#include "pilot.h"
#include "simulated_robot.h"

#include <functional>
#include <string>
#include <vector>

namespace talus::nav
{
enum class Ending
{
  Arrived,
  Blocked,  //!< no way to the goal, again and again
  Collision,
  Fall,  //!< over an edge below which it is deeper than it climbs
  Timeout
};
/** What the results call each, and the exit code of the command. */
struct EndingInfo
{
  const char* name;
  int exit_code;
};
constexpr EndingInfo kEndings[]{
    {"arrived", 0}, {"blocked", 3}, {"collision", 4}, {"fall", 6}, {"timeout", 5}};
constexpr EndingInfo info_of(Ending ending) { return kEndings[static_cast<int>(ending)]; }

/** One step of the robot, as it begins. */
struct Step
{
  double time_s = 0, x_m = 0, y_m = 0, z_m = 0, yaw_rad = 0;  //!< where it is
  double x_estimated_m = 0, y_estimated_m = 0;
  double v_mps = 0, w_radps = 0;
  double map_ms = 0, plan_ms = 0, pilot_ms = 0;  //!< computing time
  std::size_t obstacles = 0;  //!< points given to the navigator
};

struct MissionOptions
{
  Point2 goal;
  double arrived_m = 0.4;  //!< the robot's middle this near to the goal has arrived
  double timeout_s = 180;  //!< of the simulated time
  double look_ahead_m = 1.6;  //!< how far along the route the navigator's target lies
};

struct MissionResult
{
  Ending ending = Ending::Timeout;
  std::string detail;
  double time_s = 0, driven_m = 0;  //!< when it ended, after the last step
  std::vector<Step> steps;
};

/** Drives to the goal. `on_step` is called after each step. */
MissionResult run_mission(
    const sim::World& world, SimulatedRobot& robot, MapSource& map, Pilot& pilot, Planner& planner,
    const MissionOptions& options, const std::function<void(const MissionResult&)>& on_step);

}  // namespace talus::nav
