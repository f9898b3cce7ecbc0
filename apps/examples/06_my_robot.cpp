// A robot drives around a block on a road: scans, map, route, obstacles, MRPT's
// reactive navigator, motors.
//   example_06_my_robot reactive2d_config.ini     (datasets/configs; installed:
//   /usr/share/talus/configs)
#include "made_up_scans.h"
#include "my_robot.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/nav/route.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>

namespace
{
constexpr double kStep_s = 0.1, kGoalX_m = 6, kLongest_s = 60, kAhead_m = 1.6;
constexpr int kStepsPerPlan = 5;

/** In this program time goes as fast as it can; a real robot leaves MRPT's clock as it is. */
struct SimulatedRobot : MyRobot
{
  using MyRobot::MyRobot;
  double getNavigationTime() override { return mrpt::Clock::nowDouble() - begin_s; }
  void resetNavigationTimer() override { begin_s = mrpt::Clock::nowDouble(); }
  double begin_s = 0;
};

/** What a driver of the sensor does: hands each scan to the map. */
void scan(MyRobot& robot)
{
  auto points = std::make_shared<mrpt::maps::CSimplePointsMap>();
  for (const auto& p : scan_of_road(robot.pose.x(), robot.pose.y(), robot.pose.yaw()))
    points->insertPoint(p[0], p[1], p[2]);
  mrpt::obs::CObservationPointCloud observation;
  observation.pointcloud = points;
  observation.sensorPose = mrpt::poses::CPose3D(0, 0, kSensorHeight_m, 0, 0, 0);
  observation.timestamp = mrpt::Clock::now();
  observation.sensorLabel = "lidar";
  robot.map.insertObservation(observation, robot.pose);
}

/** What motors and localisation do: the pose after a step. */
void move(MyRobot& robot)
{
  const double yaw = robot.pose.yaw() + kStep_s * robot.w;
  robot.pose = mrpt::poses::CPose3D(
      robot.pose.x() + kStep_s * robot.v * std::cos(yaw),
      robot.pose.y() + kStep_s * robot.v * std::sin(yaw), 0, yaw, 0, 0);
}

/** Plans a route to the goal, and sends the navigator to a point on it. */
void follow_route(
    const MyRobot& robot, talus::nav::Planner& planner, mrpt::nav::CReactiveNavigationSystem& nav)
{
  const talus::Pose T_map_base = talus::pose_from(robot.pose);
  if (!planner.plan(robot.map.mapper(), T_map_base, {kGoalX_m, 0})) return;
  const auto at = talus::nav::from_above(T_map_base);
  const auto to = talus::nav::point_ahead(planner.route(), at, kAhead_m);
  mrpt::nav::CReactiveNavigationSystem::TNavigationParams params;
  params.target.target_coords = {to.x_m, to.y_m, 0};
  params.target.targetAllowedDistance = 0.3F;
  nav.navigate(&params);
}

int drive(const std::string& file)
{
  mrpt::config::CConfigFile ini(file);
  talus::fit_planner_ini(ini);  // as many factors as this MRPT weighs
  ini.discardSavingChanges();  // else MRPT writes the file
  SimulatedRobot robot(ini);
  robot.pose = mrpt::poses::CPose3D(0, 0.3, 0, 0, 0, 0);  // the block is straight ahead

  QuietNavigator navigator(robot);
  navigator.loadConfigFile(ini);
  const auto tables = std::filesystem::temp_directory_path();  // computed once, in seconds
  navigator.params_abstract_ptg_navigator.ptg_cache_files_directory = tables.string();
  navigator.initialize();

  talus::nav::Planner planner({}, {robot.map.insertionOptions.resolution_m, 0, 0, 0, 0, {}});
  double aside_m = robot.pose.y();
  for (int step = 0; step * kStep_s < kLongest_s; step++)
  {
    const double time_s = step * kStep_s;
    mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(1000 + time_s));
    scan(robot);
    if (step % kStepsPerPlan == 0) follow_route(robot, planner, navigator);
    navigator.navigationStep();
    if (std::abs(robot.pose.x() - kGoalX_m) < 0.4) break;
    move(robot);
    if (std::fmod(time_s + kStep_s / 2, 5) < kStep_s)
      std::printf("%2.0f s: %.1f m to the goal\n", time_s, kGoalX_m - robot.pose.x());
    aside_m = std::min(aside_m, robot.pose.y());
  }
  const bool arrived = std::abs(robot.pose.x() - kGoalX_m) < 0.5;
  std::printf(
      "%s; drove by on the right side of the block: %s\n", arrived ? "arrived" : "did not arrive",
      aside_m < -0.05 ? "yes" : "no");
  return arrived ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv)
{
  if (argc != 2)
  {
    std::fprintf(stderr, "usage: %s reactive2d_config.ini\n", argv[0]);
    return 2;
  }
  mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(1000));
  mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
  try
  {
    return drive(argv[1]);
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
