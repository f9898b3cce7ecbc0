#pragma once
#include "follow.h"
#include "map_source.h"
#include "simulated_robot.h"

#include <mrpt/nav/reactive/CAbstractPTGBasedReactive.h>
#include <talus/mrpt/version_compat_nav.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talus::nav
{
/** What MRPT's reactive navigators know of the robot: its pose as estimated, its speeds, the
 * obstacles of the map. */
class RobotInterface : public detail::RobotToNavigate
{
 public:
  RobotInterface(SimulatedRobot& robot, MapSource& map) : robot_(robot), map_(map)
  {
    setMinLoggingLevel(mrpt::system::LVL_ERROR);
  }

  std::vector<double> prism_heights_m;  //!< of a 3D robot shape
  mrpt::poses::CPose3D T_map_base;  //!< as estimated
  Around around;  //!< what was seen last
  bool narrow = false;  //!< there is no room for the whole distance to what stands

  /** Takes the pose and makes the obstacles anew. */
  void look(const mrpt::poses::CPose3D& T);

  mrpt::math::TPose2D pose_in_map() override { return here(); }
  mrpt::math::TTwist2D velocity_in_map() override;
  bool changeSpeeds(const mrpt::kinematics::CVehicleVelCmd& command) override;
  /** Slower where the ground ahead is not known far enough to stop, or what blocks would come
   * nearer than kKeepAway_m; all that the robot does goes through here. */
  void drive(double v_mps, double w_radps);
  /** clear_time_s() of what blocks. */
  double clear_s(double v_mps, double w_radps, double max_s) const;
  void stand() override { robot_.command(0, 0); }
  mrpt::kinematics::CVehicleVelCmd::Ptr getEmergencyStopCmd() override;
  mrpt::kinematics::CVehicleVelCmd::Ptr getStopCmd() override { return getEmergencyStopCmd(); }
  bool senseObstacles(
      mrpt::maps::CSimplePointsMap& obstacles, mrpt::system::TTimeStamp& timestamp) override;
  double getNavigationTime() override { return robot_.time_s() - start_s_; }
  void resetNavigationTimer() override { start_s_ = robot_.time_s(); }

 private:
  mrpt::math::TPose2D here() const { return {T_map_base.x(), T_map_base.y(), T_map_base.yaw()}; }
  /** By how much a command is slowed down for what the ground does with the robot on its way. */
  double ground_share(double v_mps, double w_radps) const;

  SimulatedRobot& robot_;
  MapSource& map_;
  double start_s_ = 0;
};

struct Settings;

/** A stock reactive navigator, CReactiveNavigationSystem or ...3D, set up from an INI file. */
class Pilot
{
 public:
  /** Writes its log into `log_folder` (unless empty) and its caches into `cache_folder`. Throws
   * WrongConfiguration. */
  Pilot(
      SimulatedRobot& robot, MapSource& map, bool in_3d, const Settings& settings,
      const std::string& log_folder, const std::string& cache_folder);
  ~Pilot();

  /** One step along a route, with the navigator to a place `ahead_m` along it where there is room.
   * Throws WrongConfiguration: formulas may fail only with the numbers of a movement. */
  void step(const mrpt::poses::CPose3D& T_map_base, const Route& route, double ahead_m);
  /** One slow step on an arc to a place where the robot was, without the navigator, which does not
   * move once its shape touches an obstacle. */
  void creep(const mrpt::poses::CPose3D& T_map_base, const mrpt::math::TPoint2D& place);
  void halt();

  const mrpt::maps::CSimplePointsMap& obstacles() const { return interface_.around.obstacles; }

 private:
  /** Keeps to the route, pose by pose, where it is narrow, where the target lies beside or behind
   * the robot, and where the navigator finds no movement. False where it need not. */
  bool keep_to(const Route& route, const mrpt::math::TPoint2D& target);
  void navigate(const mrpt::math::TPoint2D& target, bool is_last);
  /** Creeps on that arc, forwards or backwards, which leads nearest to the target without coming
   * nearer to anything, for a robot to which the navigator finds no movement, as beside a wall.
   * False where it need not, or there is none. */
  bool edge_out(const mrpt::math::TPoint2D& target);
  bool is_stuck(double for_s);
  void try_to(const std::function<void()>& work);

  SimulatedRobot& robot_;
  RobotInterface interface_;
  std::string name_;  //!< of the configuration
  std::string failure_, advice_;  //!< around what MRPT says
  std::string log_folder_;
  std::string error_;  //!< that MRPT logged
  std::unique_ptr<mrpt::nav::CAbstractPTGBasedReactive> navigator_;
  mrpt::math::TPoint2D target_{1e9, 1e9};
  Follower follower_;
  double moved_s_ = 0;  //!< when it did last
  double keeps_until_s_ = 0, edges_out_until_s_ = 0;
};

}  // namespace talus::nav
