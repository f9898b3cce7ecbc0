#pragma once
// A robot of one's own between the map and MRPT's reactive navigator, for MRPT 2. A test drives it.
// To build it, add find_package(mrpt-nav REQUIRED) and link talus::mrpt and mrpt::nav;
// 06_my_robot.cpp calls it.
#include <mrpt/config/CConfigFile.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>

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
    setMinLoggingLevel(mrpt::system::LVL_WARN);  // MRPT tells of each event else
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
    // Over what was not seen and is dared (drops = slope) it creeps.
    const auto most_mps = [&](talus::Drops drops)
    {
      talus::ObstacleOptions o = options;
      o.drops = drops;
      const double m = talus::known_ahead_m(map.mapper(), pose, c.lin_vel, c.ang_vel, 0.6, o);
      return talus::stopping_speed_mps(m - 0.3, 0.4, 1.0);
    };
    const double most =
        std::max(most_mps(talus::Drops::Avoid), std::min(0.2, most_mps(options.drops)));
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

/** MRPT's navigator, which else prints how long its steps took. */
struct QuietNavigator : mrpt::nav::CReactiveNavigationSystem
{
  explicit QuietNavigator(MyRobot& robot) : CReactiveNavigationSystem(robot, false)
  {
    setMinLoggingLevel(mrpt::system::LVL_ERROR);
    m_timlog_delays.enable(false);
  }
};
