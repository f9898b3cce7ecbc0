// The robot of apps/examples/my_robot.h, compiled and driven: a robot of one's own between the map
// and MRPT's reactive navigator.
#include "my_robot.h"

#include "room_for_maps.h"
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
  EXPECT_EQ(robot.options.seen_within_m, 1.0);
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
  robot.options.unseen = talus::Unseen::Free;  // it sees no more of the room while it drives
  robot.pose = mrpt::poses::CPose3D(-1.2, 0.2, 0, 0, 0, 0);
  set_clock(0);
  QuietNavigator navigator(robot);
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
