#include "mission.h"

#include <mrpt/core/Clock.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace talus::nav
{
namespace
{
using mrpt::poses::CPose3D;

constexpr double kStep_s = 0.1, kFirstStamp_s = 1700000000.0;
constexpr int kStepsPerPlan = 5;
constexpr int kPlansWithoutWay = 10;  // in a row: blocked
constexpr double kMap_m = 4;  // as far from the robot as the window of the shipped settings reaches
constexpr int kChecksPerStep = 2;  // of collisions

double ms_of(const std::function<void()>& work)
{
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

void set_clock(double time_s)
{
  mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(kFirstStamp_s + time_s));
  mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
}

/** The robot with all that drives it, one step after the other. */
class Mission
{
 public:
  Mission(
      const sim::World& world, SimulatedRobot& robot, MapSource& map, Pilot& pilot,
      Planner& planner, const MissionOptions& options)
      : T_base_sensor_(to_mrpt(world.sensors[0].T_base_sensor)),
        robot_(robot),
        map_(map),
        pilot_(pilot),
        planner_(planner),
        o_(options)
  {
  }

  /** True when the mission has ended. */
  bool step(MissionResult& result)
  {
    set_clock(robot_.time_s());
    const CPose3D T = to_mrpt(robot_.T_map_base_estimated());
    Step s = now(T);
    sense(T, s);
    if (count_ % kStepsPerPlan == 0) s.plan_ms = ms_of([&] { plan(T); });
    count_++;
    if (has_way_)
      s.pilot_ms = ms_of([&] { steer(T); });
    else
      halt();
    s.obstacles = pilot_.obstacles().size();
    result.steps.push_back(s);
    return drive(result) || has_ended(result);
  }

 private:
  Step now(const CPose3D& T) const
  {
    Step s;
    s.time_s = robot_.time_s();
    s.x_m = robot_.x_m(), s.y_m = robot_.y_m(), s.z_m = robot_.T_map_base().z();
    s.yaw_rad = robot_.yaw_rad();
    s.x_estimated_m = T.x(), s.y_estimated_m = T.y();
    s.v_mps = robot_.v_mps(), s.w_radps = robot_.w_radps();
    return s;
  }

  void sense(const CPose3D& T, Step& s)
  {
    const sim::Scan scan = robot_.scan();
    s.map_ms =
        ms_of([&] { map_.insert(scan, T, T_base_sensor_, kFirstStamp_s + robot_.time_s()); });
  }

  void plan(const CPose3D& T)
  {
    const Pose2 here{T.x(), T.y(), T.yaw()};
    Costmap& costmap = planner_.costmap();
    costmap.cover(here.x_m - kMap_m, here.x_m + kMap_m, here.y_m - kMap_m, here.y_m + kMap_m);
    map_.update_costmap(T, costmap);
    Costmap known = costmap;
    map_.block_unseen(T, known);
    has_way_ = planner_.plan(
        here, o_.goal, known, [this](const Pose2& at) { return map_.ground_cost(at); });
    plans_without_way_ = has_way_ ? 0 : plans_without_way_ + 1;
  }

  void steer(const CPose3D& T)
  {
    if (const auto back = retreat_.target(robot_.time_s(), {T.x(), T.y()}))
      return pilot_.creep(T, {back->x_m, back->y_m});
    pilot_.step(T, planner_.route(), o_.look_ahead_m);
  }

  void halt()
  {
    pilot_.halt();
    retreat_.rest(robot_.time_s());
  }

  bool drive(MissionResult& result)
  {
    for (int i = 0; i < kChecksPerStep; i++)
    {
      robot_.drive(kStep_s / kChecksPerStep);
      const Contact contact = robot_.contact();
      if (contact == Contact::Drop) return end(result, Ending::Fall, "went over an edge");
      if (contact == Contact::Obstacle) return end(result, Ending::Collision, "hit an obstacle");
    }
    return false;
  }

  bool has_ended(MissionResult& result) const
  {
    if (std::hypot(robot_.x_m() - o_.goal.x_m, robot_.y_m() - o_.goal.y_m) <= o_.arrived_m)
      return end(result, Ending::Arrived, "reached the goal");
    if (plans_without_way_ >= kPlansWithoutWay)
      return end(result, Ending::Blocked, "found no way to the goal");
    if (robot_.time_s() > o_.timeout_s)
      return end(result, Ending::Timeout, "did not reach the goal in time");
    return false;
  }

  bool end(MissionResult& result, Ending ending, const std::string& what) const
  {
    char where[100];
    std::snprintf(
        where, sizeof where, " at (%.2f, %.2f) after %.1f s and %.1f m", robot_.x_m(), robot_.y_m(),
        robot_.time_s(), robot_.driven_m());
    result.ending = ending;
    result.detail = what + where;
    result.time_s = robot_.time_s();
    result.driven_m = robot_.driven_m();
    return true;
  }

  CPose3D T_base_sensor_;
  SimulatedRobot& robot_;
  MapSource& map_;
  Pilot& pilot_;
  Planner& planner_;
  Retreat retreat_;
  const MissionOptions& o_;
  int count_ = 0, plans_without_way_ = 0;
  bool has_way_ = false;
};
}  // namespace

MissionResult run_mission(
    const sim::World& world, SimulatedRobot& robot, MapSource& map, Pilot& pilot, Planner& planner,
    const MissionOptions& options, const std::function<void(const MissionResult&)>& on_step)
{
  MissionResult result;
  Mission mission(world, robot, map, pilot, planner, options);
  for (bool ended = false; !ended;)
  {
    ended = mission.step(result);
    on_step(result);
  }
  return result;
}

}  // namespace talus::nav
