#pragma once
// The part of version_compat.h that needs mrpt-nav.
#include <mrpt/core/Clock.h>
#include <mrpt/nav/reactive/CRobot2NavInterface.h>
#include <mrpt/version.h>

#include <optional>
#include <string>

namespace talus::detail
{
/** What MRPT's navigators ask every robot; from 3.0 on they ask in another way. */
class RobotToNavigate : public mrpt::nav::CRobot2NavInterface
{
 public:
  virtual mrpt::math::TPose2D pose_in_map() = 0;
  virtual mrpt::math::TTwist2D velocity_in_map() = 0;
  virtual void stand() = 0;

#if MRPT_VERSION >= 0x030000
  std::optional<CurrentPoseAndSpeeds> getCurrentPoseAndSpeeds() override
  {
    CurrentPoseAndSpeeds now;
    now.pose = now.odometry = pose_in_map();
    now.velGlobal = velocity_in_map();
    now.timestamp = mrpt::Clock::now();
    return now;
  }
  bool stop(mrpt::nav::StopType) override
  {
    stand();
    return true;
  }
#else
  bool getCurrentPoseAndSpeeds(
      mrpt::math::TPose2D& pose, mrpt::math::TTwist2D& velocity_map,
      mrpt::system::TTimeStamp& stamp, mrpt::math::TPose2D& odometry, std::string&) override
  {
    pose = odometry = pose_in_map();
    velocity_map = velocity_in_map();
    stamp = mrpt::Clock::now();
    return true;
  }
  bool stop(bool) override
  {
    stand();
    return true;
  }
#endif
};

}  // namespace talus::detail
