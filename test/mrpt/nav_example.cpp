// The example of doc/mrpt.md, compiled and driven: a robot of one's own between the map and MRPT's
// reactive navigator. What stands between the marks is the text of the page.
#include "room_for_maps.h"

// [example]
#include <mrpt/config/CConfigFile.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/mrpt/planner_ini.h>

#include <algorithm>
#include <cmath>
#include <iostream>

struct MyRobot : mrpt::nav::CRobot2NavInterface
{
  using Cmd = mrpt::kinematics::CVehicleVelCmd;
  talus::CDualElevationMap map;  // map.insertObservation(scan, pose) for each scan
  talus::ObstacleOptions options;  // range_m, spacing_m, seen_within_m ...
  mrpt::poses::CPose3D pose;  // of the base in the map, from localisation
  double v = 0, w = 0;  // m/s, rad/s: goes to the motors

  // One file: the navigator's sections, the map's, and [talus_obstacles].
  explicit MyRobot(const mrpt::config::CConfigFileBase& ini)
  {
    for (const auto& warning :
         talus::load_parameters(ini, "CDualElevationMap", map.insertionOptions))
      std::cerr << warning << "\n";
    options.loadFromConfigFile(ini, "talus_obstacles");
  }
  bool senseObstacles(mrpt::maps::CSimplePointsMap& obs, mrpt::system::TTimeStamp& t) override
  {
    t = mrpt::Clock::now();
    talus::obstacles_2d(map.mapper(), pose, options, obs);
    return true;
  }
  bool getCurrentPoseAndSpeeds(
      mrpt::math::TPose2D& p, mrpt::math::TTwist2D& speed, mrpt::system::TTimeStamp& t,
      mrpt::math::TPose2D& odometry, std::string&) override
  {
    p = odometry = mrpt::math::TPose2D(pose.x(), pose.y(), pose.yaw());
    speed = {v * std::cos(p.phi), v * std::sin(p.phi), w};
    t = mrpt::Clock::now();
    return true;
  }
  bool changeSpeeds(const Cmd& cmd) override
  {
    const auto& c = dynamic_cast<const mrpt::kinematics::CVehicleVelCmd_DiffDriven&>(cmd);
    // As fast as it can still stop before what is not known; its front is 0.3 m before its middle.
    const double known_m =
        talus::known_ahead_m(map.mapper(), pose, c.lin_vel, c.ang_vel, 0.6, options);
    const double most = talus::stopping_speed_mps(known_m - 0.3, 0.4, 1.0);
    const double share = std::min(1.0, most / std::max(std::abs(c.lin_vel), 1e-9));
    v = share * c.lin_vel;
    w = share * c.ang_vel;
    return true;
  }
  bool stop(bool) override
  {
    v = w = 0;
    return true;
  }
  Cmd::Ptr getStopCmd() override
  {
    auto cmd = std::make_shared<mrpt::kinematics::CVehicleVelCmd_DiffDriven>();
    cmd->setToStop();
    return cmd;
  }
  Cmd::Ptr getEmergencyStopCmd() override { return getStopCmd(); }
};
// [example]

#include "log_files.h"

namespace
{
const std::string kIni = TALUS_SOURCE_DIR "/datasets/configs/reactive2d_config.ini";

/** Time goes as the test says. */
void set_clock(double time_s)
{
  mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(1000 + time_s));
  mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
}

/** The navigator counts real seconds unless it is told otherwise. */
struct RobotInSimulatedTime : MyRobot
{
  using MyRobot::MyRobot;
  double getNavigationTime() override { return mrpt::Clock::nowDouble() - start_s; }
  void resetNavigationTimer() override { start_s = mrpt::Clock::nowDouble(); }
  double start_s = 0;
};

void see_the_room(talus::CDualElevationMap& map)
{
  for (int i = 0; i < 3; i++)
  {
    const mrpt::poses::CPose3D pose(0.03 * i, -0.02 * i, 0, 0.1 * i, 0, 0);
    ASSERT_TRUE(map.insertObservation(talus_test::scan_of_room(pose), pose));
  }
}
}  // namespace

TEST(NavExample, reads_map_and_obstacles_from_the_file_of_the_navigator)
{
  const RobotInSimulatedTime robot{mrpt::config::CConfigFile(kIni)};
  EXPECT_EQ(robot.options.unseen, talus::Unseen::Obstacle);
  EXPECT_EQ(robot.options.seen_within_m, 1.5);
  EXPECT_EQ(robot.map.insertionOptions.clearance_m, 0.8);
  EXPECT_EQ(robot.map.insertionOptions.window_m, 8.0);
}

TEST(NavExample, drives_around_the_box_to_the_goal)
{
  const talus::test::ScratchDir caches;
  mrpt::config::CConfigFile ini(kIni);
  talus::fit_planner_ini(ini);
  ini.discardSavingChanges();
  RobotInSimulatedTime robot(ini);
  see_the_room(robot.map);
  robot.pose = mrpt::poses::CPose3D(-1.2, 0.2, 0, 0, 0, 0);
  set_clock(0);
  mrpt::nav::CReactiveNavigationSystem navigator(robot, false);
  navigator.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  navigator.loadConfigFile(ini);
  navigator.params_abstract_ptg_navigator.ptg_cache_files_directory = caches / "";
  navigator.initialize();
  mrpt::nav::CReactiveNavigationSystem::TNavigationParams goal;
  goal.target.target_coords = {2.3, -1.1, 0};
  goal.target.targetAllowedDistance = 0.2F;
  navigator.navigate(&goal);
  constexpr double kStep_s = 0.1;
  for (int i = 1;
       i < 400 && navigator.getCurrentState() == mrpt::nav::CAbstractNavigator::TState::NAVIGATING;
       i++)
  {
    set_clock(kStep_s * i);
    navigator.navigationStep();
    const double yaw = robot.pose.yaw() + kStep_s * robot.w;
    robot.pose = mrpt::poses::CPose3D(
        robot.pose.x() + kStep_s * robot.v * std::cos(yaw),
        robot.pose.y() + kStep_s * robot.v * std::sin(yaw), 0, yaw, 0, 0);
    ASSERT_FALSE(robot.pose.x() > 0.8 && robot.pose.x() < 1.85 && std::abs(robot.pose.y()) < 0.72)
        << "in the box at " << robot.pose.asString();
  }
  EXPECT_EQ(navigator.getCurrentState(), mrpt::nav::CAbstractNavigator::TState::IDLE);
  EXPECT_LT(std::hypot(robot.pose.x() - 2.3, robot.pose.y() + 1.1), 0.4);
}

TEST(NavExample, is_the_text_of_the_page)
{
  const auto source = talus::test::read_bytes(TALUS_SOURCE_DIR "/test/mrpt/nav_example.cpp");
  const auto page = talus::test::read_bytes(TALUS_SOURCE_DIR "/doc/mrpt.md");
  const std::string mark = "\n// [example]\n";
  const auto from = source.find(mark) + mark.size(), to = source.find(mark, from);
  ASSERT_NE(to, std::string::npos);
  const std::string text = source.substr(from, to + 1 - from);
  EXPECT_NE(page.find("```cpp\n" + text + "```\n"), std::string::npos);
}
