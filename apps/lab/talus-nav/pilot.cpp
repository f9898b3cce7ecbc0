#include "pilot.h"

#include "../../common/suspect.h"
#include "planner_ini.h"
#include "settings.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/Clock.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem3D.h>
#include <talus/io/mrpt_error.h>
#include <talus/mrpt/planner_ini.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string_view>

namespace talus::nav
{
namespace
{
constexpr double kSameTarget_m = 0.3;
constexpr double kCreep_mps = 0.2, kCreepClear_m = 0.2;
constexpr double kTurn_radps = 0.8, kTurnClear_m = 0.05;
constexpr double kTurnFrom_rad = 1.4, kTurnTo_rad = 0.1;  // off the target
constexpr double kStuck_s = 1, kStill_mps = 0.02, kStill_radps = 0.02;

/** MRPT compiles the formulas of scores with the symbols of the first movement that it rates, and
 * one that does not lead to the target (a near one, or one behind the robot) has hardly any. */
void compile_formulas(mrpt::nav::CMultiObjectiveMotionOptimizerBase& decider)
{
  mrpt::nav::TCandidateMovementPTG no_movement;
  for (const char* symbol :
       {"clearance",
        "clearance_50p",
        "clearance_path",
        "clearance_path_50p",
        "dist_eucl_final",
        "dist_eucl_min",
        "collision_free_distance",
        "eta",
        "holo_stage_eval",
        "hysteresis",
        "is_PTG_cont",
        "is_slowdown",
        "move_cur_d",
        "move_k",
        "num_paths",
        "original_col_free_dist",
        "ptg_idx",
        "ptg_priority",
        "ref_dist",
        "robpose_phi",
        "robpose_x",
        "robpose_y",
        "target_d_norm",
        "target_dir",
        "target_k",
        "WS_target_x",
        "WS_target_y"})
    no_movement.props[symbol] = 0;
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

/** Whether f(x, y) holds of a point. */
template <class F>
bool any_point(const mrpt::maps::CSimplePointsMap& points, F f)
{
  const auto& x = points.getPointsBufferRef_x();
  const auto& y = points.getPointsBufferRef_y();
  for (std::size_t i = 0; i < x.size(); i++)
    if (f(x[i], y[i])) return true;
  return false;
}
}  // namespace

mrpt::math::TPose2D RobotInterface::pose_in_map()
{
  return {T_map_base.x(), T_map_base.y(), T_map_base.yaw()};
}

mrpt::math::TTwist2D RobotInterface::velocity_in_map()
{
  const double yaw = T_map_base.yaw(), v_mps = robot_.v_mps();
  return {v_mps * std::cos(yaw), v_mps * std::sin(yaw), robot_.w_radps()};
}

bool RobotInterface::changeSpeeds(const mrpt::kinematics::CVehicleVelCmd& command)
{
  const auto& c = dynamic_cast<const mrpt::kinematics::CVehicleVelCmd_DiffDriven&>(command);
  const RobotBody& body = robot_.body();
  const double known_m = map_.known_ahead_m(T_map_base, c.lin_vel, c.ang_vel, body.width_m);
  const double most_mps =
      stopping_speed_mps(known_m - 0.5 * body.length_m, body.reacts_s, body.brakes_mps2);
  const double share = std::min(1.0, most_mps / std::max(std::abs(c.lin_vel), 1e-9));
  robot_.command(share * c.lin_vel, share * c.ang_vel);
  return true;
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
  map_.obstacles(T, prism_heights_m, seen);
}

bool RobotInterface::senseObstacles(
    mrpt::maps::CSimplePointsMap& obstacles, mrpt::system::TTimeStamp& timestamp)
{
  look(T_map_base);
  obstacles = seen;
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
  const app::Suspect suspect(name_, advice_);
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

void Pilot::step(
    const mrpt::poses::CPose3D& T_map_base, const mrpt::math::TPoint2D& target, bool is_last)
{
  interface_.T_map_base = T_map_base;
  if (turn(target)) return;
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

bool Pilot::turn(const mrpt::math::TPoint2D& target)
{
  const mrpt::math::TPoint2D to = interface_.pose_in_map().inverseComposePoint(target);
  const double off_rad = std::atan2(to.y, to.x);
  turns_ = std::abs(off_rad) > (turns_ || is_stuck() ? kTurnTo_rad : kTurnFrom_rad) &&
           has_room_to_turn();
  if (!turns_) return false;
  navigator_->cancel();
  robot_.command(0, std::copysign(kTurn_radps, off_rad));
  return true;
}

bool Pilot::is_stuck()
{
  const bool still =
      std::abs(robot_.v_mps()) < kStill_mps && std::abs(robot_.w_radps()) < kStill_radps;
  if (!still) moved_s_ = robot_.time_s();
  return robot_.time_s() - moved_s_ > kStuck_s;
}

void Pilot::creep(const mrpt::poses::CPose3D& T_map_base, const mrpt::math::TPoint2D& place)
{
  halt();
  interface_.look(T_map_base);
  const mrpt::math::TPoint2D to = interface_.pose_in_map().inverseComposePoint(place);
  const double v_mps = is_clear(to.x > 0) ? std::copysign(kCreep_mps, to.x) : 0;
  robot_.command(v_mps, v_mps * 2 * to.y / (to.x * to.x + to.y * to.y));
}

bool Pilot::is_clear(bool forwards) const
{
  const double end_m = robot_.body().length_m / 2, side_m = robot_.body().width_m / 2;
  return !any_point(
      interface_.seen,
      [&](double x, double y)
      {
        const double ahead_m = (forwards ? x : -x) - end_m;
        return ahead_m > 0 && ahead_m < kCreepClear_m && std::abs(y) < side_m;
      });
}

bool Pilot::has_room_to_turn()
{
  interface_.look(interface_.T_map_base);
  const RobotBody& body = robot_.body();
  const double radius_m = std::hypot(body.length_m, body.width_m) / 2 + kTurnClear_m;
  return !any_point(
      interface_.seen, [&](double x, double y) { return std::hypot(x, y) < radius_m; });
}

void Pilot::halt()
{
  turns_ = false;
  navigator_->cancel();
  interface_.stand();
  interface_.seen.clear();
}

}  // namespace talus::nav
