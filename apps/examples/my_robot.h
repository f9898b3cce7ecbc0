#pragma once
// A robot of one's own between the map and MRPT's reactive navigator, for MRPT 2. A test drives it.
// To build it, add find_package(mrpt-nav REQUIRED) and link talus::mrpt and mrpt::nav; what calls
// it is in doc/mrpt.md.
#include <mrpt/config/CConfigFile.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/mrpt/planner_ini.h>

#include <cmath>
#include <iostream>

struct MyRobot : mrpt::nav::CRobot2NavInterface
{
  using Cmd = mrpt::kinematics::CVehicleVelCmd;
  talus::CDualElevationMap map;  // map.insertObservation(scan, pose) for each scan
  talus::ObstacleOptions options;  // range_m, spacing_m, what unknown cells are ...
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
    v = c.lin_vel;
    w = c.ang_vel;
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
