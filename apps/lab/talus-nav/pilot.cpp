#include "pilot.h"

#include "../../common/crash_context.h"
#include "options.h"
#include "planner_ini.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/Clock.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem3D.h>
#include <talus/io/mrpt_error.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace talus::nav
{
namespace
{
constexpr double kSameTarget_m = 0.3;
constexpr double kCreep_mps = 0.2, kCreep_s = 1.5;
constexpr std::array<double, 9> kCreepCurvatures{0, 0.4, -0.4, 0.8, -0.8, 1.6, -1.6, 3, -3};  // 1/m
constexpr double kTurnBackFrom_rad = 1.4;  // off the target
constexpr double kNarrowAhead_m = 0.6, kKeep_s = 1.5;
constexpr double kBlocked_m = 2.5;  // as far as a command is looked at
constexpr double kLongestStop_s = 2;
constexpr std::array<double, 2> kGroundAhead_m{0.15, 0.3};  // within its way to stop
constexpr double kOnEven_mps = 0.8;  // slower the more the ground tilts and shakes the robot
constexpr double kStuck_s = 1, kStuckLong_s = 2, kStill_mps = 0.02, kStill_radps = 0.02;

/** MRPT compiles the formulas of scores with the symbols of the first movement that it rates, and
 * one that does not lead to the target (a near one, or one behind the robot) has hardly any. */
void compile_formulas(mrpt::nav::CMultiObjectiveMotionOptimizerBase& decider)
{
  std::istringstream symbols(
      "clearance clearance_50p clearance_path clearance_path_50p dist_eucl_final dist_eucl_min "
      "collision_free_distance eta holo_stage_eval hysteresis is_PTG_cont is_slowdown move_cur_d "
      "move_k num_paths original_col_free_dist ptg_idx ptg_priority ref_dist robpose_phi robpose_x "
      "robpose_y target_d_norm target_dir target_k WS_target_x WS_target_y");
  mrpt::nav::TCandidateMovementPTG no_movement;
  for (std::string symbol; symbols >> symbol;) no_movement.props[symbol] = 0;
  mrpt::nav::CMultiObjectiveMotionOptimizerBase::TResultInfo ignored;
  decider.decide({no_movement}, ignored);
}

/** A navigator that prints nothing, and keeps the first error that it would print in `error`. */
template <class Navigator>
struct Quiet : Navigator
{
  Quiet(mrpt::nav::CRobot2NavInterface& robot, const std::string& log_folder, std::string& error)
      : Navigator(robot, false, false, log_folder)
  {
    this->m_timlog_delays.enable(false);
    this->setMinLoggingLevel(mrpt::system::LVL_ERROR);
    this->logging_enable_console_output = false;
    this->logRegisterCallback(
        [&error](
            std::string_view text, mrpt::system::VerbosityLevel level, std::string_view,
            mrpt::Clock::time_point)
        {
          if (level >= mrpt::system::LVL_ERROR && error.empty()) error = text;
        });
  }

  void initialize() override
  {
    Navigator::initialize();
    compile_formulas(*this->m_multiobjopt);
  }
};

/** The heights in [CReactiveNavigationSystem3D]. */
std::vector<double> prism_heights(const mrpt::config::CConfigFileBase& ini)
{
  const std::string section = "CReactiveNavigationSystem3D";
  std::vector<double> heights;
  const int count = ini.read_int(section, "HEIGHT_LEVELS", 0, true);
  for (int i = 1; i <= count; i++)
    heights.push_back(ini.read_double(section, "LEVEL" + std::to_string(i) + "_HEIGHT", 0, true));
  return heights;
}

/** Where an arc of this curvature [1/m] leads to, robot frame; backwards where it is negative. */
mrpt::math::TPoint2D end_of_arc(double length_m, double curvature)
{
  if (curvature == 0) return {length_m, 0};
  const double turned_rad = curvature * length_m;
  return {std::sin(turned_rad) / curvature, (1 - std::cos(turned_rad)) / curvature};
}
}  // namespace

mrpt::math::TTwist2D RobotInterface::velocity_in_map()
{
  const double yaw = T_map_base.yaw(), v_mps = robot_.v_mps();
  return {v_mps * std::cos(yaw), v_mps * std::sin(yaw), robot_.w_radps()};
}

bool RobotInterface::changeSpeeds(const mrpt::kinematics::CVehicleVelCmd& command)
{
  const auto& c = dynamic_cast<const mrpt::kinematics::CVehicleVelCmd_DiffDriven&>(command);
  drive(c.lin_vel, c.ang_vel);
  return true;
}

void RobotInterface::drive(double v_mps, double w_radps)
{
  const RobotBody& body = robot_.body();
  const auto share_of = [&body](double speed_mps, double within_m)
  {
    const double most_mps = stopping_speed_mps(within_m, body.reacts_s, body.brakes_mps2);
    return most_mps / std::max(speed_mps, 1e-9);
  };
  const Ahead ahead = map_.ahead(T_map_base, v_mps, w_radps, body.width_m);
  const double front_m = 0.5 * body.length_m, speed_mps = std::abs(v_mps);
  const double daring = std::min(
      share_of(speed_mps, ahead.dared_m - front_m), kCreep_mps / std::max(speed_mps, 1e-9));
  const double corner_mps =
      std::abs(v_mps) + std::abs(w_radps) * std::hypot(body.length_m, body.width_m) / 2;
  const double share = std::min(
      {1.0, ground_share(v_mps, w_radps),
       std::max(share_of(speed_mps, ahead.known_m - front_m), daring),
       share_of(corner_mps, corner_mps * clear_s(v_mps, w_radps, kLongestStop_s))});
  robot_.command(share * v_mps, share * w_radps);
}

double RobotInterface::ground_share(double v_mps, double w_radps) const
{
  if (v_mps == 0) return 1;
  const double curvature = w_radps / v_mps;
  double worst = 0;
  for (const double ahead_m : kGroundAhead_m)
  {
    const double along_m = std::copysign(ahead_m, v_mps);
    const auto end = end_of_arc(along_m, curvature);
    const auto to = here() + mrpt::math::TPose2D(end.x, end.y, along_m * curvature);
    const double cost = map_.ground_cost({to.x, to.y, to.phi});
    worst = std::fmax(worst, cost);  // NaN counts for nothing
  }
  return std::max(kCreep_mps, kOnEven_mps * (1 - worst)) / std::abs(v_mps);
}

double RobotInterface::clear_s(double v_mps, double w_radps, double max_s) const
{
  return clear_time_s(around.blocked, robot_.body(), v_mps, w_radps, max_s, narrow);
}

mrpt::kinematics::CVehicleVelCmd::Ptr RobotInterface::getEmergencyStopCmd()
{
  auto command = std::make_shared<mrpt::kinematics::CVehicleVelCmd_DiffDriven>();
  command->setToStop();
  return command;
}

void RobotInterface::look(const mrpt::poses::CPose3D& T)
{
  T_map_base = T;
  around = map_.look(T, prism_heights_m, kBlocked_m);
}

bool RobotInterface::senseObstacles(
    mrpt::maps::CSimplePointsMap& obstacles, mrpt::system::TTimeStamp& timestamp)
{
  obstacles = around.obstacles;  // of this step
  timestamp = mrpt::Clock::now();
  return true;
}

Pilot::Pilot(
    SimulatedRobot& robot, MapSource& map, bool in_3d, const Settings& settings,
    const std::string& log_folder, const std::string& cache_folder)
    : robot_(robot),
      interface_(robot, map),
      name_(settings.name),
      failure_(settings.name + ": MRPT's " + planner_name(in_3d) + " cannot work with this: "),
      advice_("compare it with " + shipped_ini(in_3d)),
      log_folder_(log_folder)
{
  mrpt::config::CConfigFileMemory config;
  config.setContent(settings.ini);
  fit_planner_ini(config);
  if (in_3d)
  {
    navigator_ = std::make_unique<Quiet<mrpt::nav::CReactiveNavigationSystem3D>>(
        interface_, log_folder, error_);
    interface_.prism_heights_m = prism_heights(config);
  }
  else
    navigator_ = std::make_unique<Quiet<mrpt::nav::CReactiveNavigationSystem>>(
        interface_, log_folder, error_);
  navigator_->enableLogFile(!log_folder.empty());
  try_to(
      [&]
      {
        const app::MemoryLimit limit(std::size_t{2} << 30);
        navigator_->loadConfigFile(config);
        navigator_->params_abstract_ptg_navigator.ptg_cache_files_directory = cache_folder;
        navigator_->initialize();
      });
}

/** Says which file it is when MRPT throws or logs an error, or crashes. */
void Pilot::try_to(const std::function<void()>& work)
{
  const app::CrashContext context(name_, advice_);
  try
  {
    work();
    if (!error_.empty()) throw std::runtime_error(error_);
  }
  catch (const std::bad_alloc&)
  {
    throw WrongConfiguration(failure_ + "it needs too much memory; " + advice_);
  }
  catch (const std::exception& e)
  {
    const std::string reason = io::reason_of(e);
    // What MRPT says of a disk that is full.
    if (reason.find("write bytes") != std::string::npos)
      throw std::runtime_error(
          log_folder_ +
          ": the log of the navigator cannot be written; is the disk full? Free some space there");
    throw WrongConfiguration(failure_ + reason + "; " + advice_);
  }
}

Pilot::~Pilot() = default;

void Pilot::step(const mrpt::poses::CPose3D& T_map_base, const Route& route, double ahead_m)
{
  interface_.look(T_map_base);
  const Point2 ahead = point_ahead(route, from_above(pose_from(T_map_base)), ahead_m);
  const mrpt::math::TPoint2D target(ahead.x_m, ahead.y_m);
  if (edge_out(target) || keep_to(route, target)) return;
  const RoutePose& last = route.back();
  navigate(target, target == mrpt::math::TPoint2D(last.x_m, last.y_m));
}

void Pilot::navigate(const mrpt::math::TPoint2D& target, bool is_last)
{
  const bool idle =
      navigator_->getCurrentState() != mrpt::nav::CAbstractNavigator::TState::NAVIGATING;
  if (navigator_->getCurrentState() == mrpt::nav::CAbstractNavigator::TState::NAV_ERROR)
    navigator_->resetNavError();
  if (idle || std::hypot(target.x - target_.x, target.y - target_.y) > kSameTarget_m)
  {
    mrpt::nav::CAbstractPTGBasedReactive::TNavigationParamsPTG wanted;
    wanted.target.target_coords = mrpt::math::TPose2D(target.x, target.y, 0);
    wanted.target.targetAllowedDistance = 0.2F;
    wanted.target.targetDesiredRelSpeed = is_last ? 0.05 : 1.0;
    wanted.target.targetIsIntermediaryWaypoint = !is_last;
    navigator_->navigate(&wanted);
    target_ = target;
  }
  try_to([&] { navigator_->navigationStep(); });
}

bool Pilot::keep_to(const Route& route, const mrpt::math::TPoint2D& target)
{
  const mrpt::math::TPose2D here = interface_.pose_in_map();
  const Pose2 at{here.x, here.y, here.phi};
  interface_.narrow = is_narrow(route, at, kNarrowAhead_m);
  const mrpt::math::TPoint2D to = here.inverseComposePoint(target);
  if (is_stuck(kStuck_s) || std::abs(std::atan2(to.y, to.x)) > kTurnBackFrom_rad)
    keeps_until_s_ = robot_.time_s() + kKeep_s;
  const bool must = interface_.narrow || is_tilted(route, at, kNarrowAhead_m);
  if (!must && robot_.time_s() >= keeps_until_s_) return false;
  navigator_->cancel();
  const Speeds speeds = follower_.follow(route, at);
  interface_.drive(speeds.v_mps, speeds.w_radps);
  return true;
}

bool Pilot::edge_out(const mrpt::math::TPoint2D& target)
{
  if (is_stuck(kStuckLong_s)) edges_out_until_s_ = robot_.time_s() + kCreep_s;
  if (robot_.time_s() >= edges_out_until_s_) return false;
  const mrpt::math::TPoint2D to = interface_.pose_in_map().inverseComposePoint(target);
  const double creep_s = std::min(kCreep_s, to.norm() / kCreep_mps);
  double nearest_m = HUGE_VAL, v_mps = 0, w_radps = 0;
  for (const double curvature : kCreepCurvatures)
    for (const double v : {kCreep_mps, -kCreep_mps})
    {
      if (interface_.clear_s(v, curvature * v, creep_s) < creep_s) continue;
      const double left_m = (end_of_arc(v * creep_s, curvature) - to).norm();
      if (left_m >= nearest_m) continue;
      nearest_m = left_m;
      v_mps = v;
      w_radps = curvature * v;
    }
  if (nearest_m == HUGE_VAL) return false;
  navigator_->cancel();
  interface_.drive(v_mps, w_radps);
  return true;
}

bool Pilot::is_stuck(double for_s)
{
  const bool still =
      std::abs(robot_.v_mps()) < kStill_mps && std::abs(robot_.w_radps()) < kStill_radps;
  if (!still) moved_s_ = robot_.time_s();
  return robot_.time_s() - moved_s_ > for_s;
}

void Pilot::creep(const mrpt::poses::CPose3D& T_map_base, const mrpt::math::TPoint2D& place)
{
  halt();
  interface_.look(T_map_base);
  const mrpt::math::TPoint2D to = interface_.pose_in_map().inverseComposePoint(place);
  const double v_mps = std::copysign(kCreep_mps, to.x);
  interface_.drive(v_mps, v_mps * 2 * to.y / (to.x * to.x + to.y * to.y));
}

void Pilot::halt()
{
  navigator_->cancel();
  interface_.stand();
  interface_.around = {};
}

}  // namespace talus::nav
