#pragma once
#include <talus/nav/heading_cost.h>
#include <talus/sim/random.h>
#include <talus/sim/scanner.h>
#include <talus/sim/world.h>

namespace talus::nav
{
/** Size of the robot, its base in the middle of the ground below it. */
struct RobotBody
{
  double length_m = 0.6, width_m = 0.5;
  double height_m = 0.8;  //!< with the sensor: the clearance that it needs
  double climbs_m = 0.1;  //!< what stands lower is driven over
  double wheel_radius_m = 0.15;
  double steps_m = 0.2;  //!< the highest step of the ground that it takes, up or down
  double reacts_s = 0.4, brakes_mps2 = 1.0;  //!< on what its driver counts to stop it

  Footprint footprint() const;
};

/** What a robot has run into. */
enum class Contact
{
  None,
  Obstacle,  //!< something that stands or hangs too low, a step or slope that goes up
  Drop  //!< an edge below which it is deeper than a step
};

/** Errors of what the robot knows about itself and its surroundings, standard deviations. */
struct Noise
{
  double position_m = 0.01, angle_rad = 0.003;  //!< of each pose, in each axis
  double range_m = 0.015;
};

/** A differential drive in a world: where it really is, what it feels, whether it hit something. */
class SimulatedRobot
{
 public:
  /** Starts where the way of the world's robot begins. Keeps a reference to `world`. */
  SimulatedRobot(const sim::World& world, const Noise& noise, std::uint64_t seed);

  /** Goes on for a time with the speeds commanded; they are reached with a lag. */
  void drive(double seconds);
  void command(double v_mps, double w_radps);

  double time_s() const { return time_s_; }
  double x_m() const { return x_m_; }
  double y_m() const { return y_m_; }
  double yaw_rad() const { return yaw_rad_; }
  double v_mps() const { return v_mps_; }
  double w_radps() const { return w_radps_; }
  double driven_m() const { return driven_m_; }
  const RobotBody& body() const { return body_; }

  /** As its four wheels stand on the ground and on what is low enough to be driven over. */
  Pose T_map_base() const;
  /** As its localisation says. The same at the same time. */
  Pose T_map_base_estimated() const;
  /** What its sensor sees now, sensor frame. */
  sim::Scan scan() const;

  /** Whether its body is where the truth says blocked. */
  Contact contact() const;

 private:
  bool is_drop(double x_m, double y_m) const;
  double support_m(const sim::Scene& scene, double x_m, double y_m) const;
  double wheel_m(const sim::Scene& scene, double forward_m, double left_m) const;

  const sim::World& world_;
  RobotBody body_;
  Noise noise_;
  sim::Scanner scanner_;
  std::uint64_t seed_;
  double time_s_ = 0, x_m_, y_m_, yaw_rad_;
  double v_mps_ = 0, w_radps_ = 0, v_wanted_ = 0, w_wanted_ = 0, driven_m_ = 0;
};

}  // namespace talus::nav
