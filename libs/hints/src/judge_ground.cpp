// Hints about frames: what the ground shows of poses and mountings.
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

#include "judge.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
std::string degrees(double rad) { return fixed_text(rad * 180 / M_PI, 0) + " degrees"; }
std::string metres(double m) { return fixed_text(m, 2) + " m"; }

double lean_rad(const NearPlane& plane) { return std::acos(std::clamp(plane.normal.z, -1.0, 1.0)); }

bool shows_ground(const SensorFigures& s) { return s.share(s.ground_m) > kGroundShare; }

/** Names a sensor where there are several. */
std::string of_sensor(const Figures& f, const SensorFigures& s)
{
  return f.sensors.size() > 1 ? " of '" + s.label + "'" : std::string();
}

/** Whether the robot has been to enough positions to separate its mounting from where it stands. */
bool was_around(const SensorFigures& s)
{
  return s.ground_m.size() >= kMinGrounds && s.body.path_m() >= kMinBodyPath_m;
}

/** The ground, which a mounting puts at the base, lies above or below it nearly everywhere. */
bool is_wrong_height(const SensorFigures& s)
{
  const double least_m = was_around(s) ? kWrongHeight_m : kWrongHeightOnce_m;
  const double limit_m = std::max(least_m, kWrongHeightShare * std::abs(s.sensor.z));
  const double low_m = s.ground_m.quantile(0.25), high_m = s.ground_m.quantile(0.75);
  return std::abs(s.ground_m.median()) > limit_m &&
         std::max(low_m, -high_m) > kSteadyHeight * limit_m;
}

/** The ground leans against base and map alike; against the base alone, the robot stood askew. */
bool is_wrong_tilt(const SensorFigures& s)
{
  constexpr double kWrong_rad = kWrongTilt_deg * M_PI / 180;
  return was_around(s) && lean_rad(s.ground()) > kWrong_rad &&
         s.lean_in_map_rad.median() > kWrong_rad;
}

/** The map leans as the sensor is mounted: its frame is that of the sensor's first pose. */
bool is_in_frame_of_sensor(const SensorFigures& s)
{
  constexpr double kDegree = M_PI / 180;
  return s.mount_tilt_rad > kMinTiltedFrame_deg * kDegree &&
         s.first_tilt_rad < kBeginsLevel_deg * kDegree &&
         s.lean_in_map_rad.median() > kTiltedFrame * s.mount_tilt_rad &&
         lean_rad(s.ground()) < s.lean_in_map_rad.median() / 2;
}

/** As high above the sensor as the ground should be below it. */
bool is_mirrored(const SensorFigures& s)
{
  return s.sensor.z > kMinMounting_m && s.share(s.ceiling_above_m) > kGroundShare &&
         std::abs(s.ceiling_above_m.median() - s.sensor.z) < kAtSensor_m;
}
/** Where nothing returned from above a ray, it may be that nothing was there, or that far points
 * are missing from the log. Not so where it looks down, and beams look up to other sides. */
bool is_highest(const HighestRay& ray, const SensorFigures& s)
{
  return ray.slope > 0 || (ray.slope < -kLooksDown && s.top_around.median() > kLooksDown);
}
}  // namespace

std::optional<HighestRay> highest_ray(const Figures& f)
{
  std::optional<HighestRay> highest;
  for (const SensorFigures& s : f.sensors)
  {
    if (s.top_ahead.size() == 0) continue;
    const Vec3 up = s.ground().normal;
    const HighestRay ray{
        s.sensor.x, s.sensor_above_m.median(), s.top_ahead.quantile(1) + up.x / up.z};
    if (!was_around(s) || !shows_ground(s) || !is_highest(ray, s)) return {};
    if (!highest || ray.height_m(kLooksAhead_m) > highest->height_m(kLooksAhead_m)) highest = ray;
  }
  return highest;
}

std::optional<Hint> upside_down(const Figures& f)
{
  if (f.base_up.size() > 0 && f.base_up.median() < kUpsideDown)
    return Hint{
        Kind::UpsideDown, "the poses turn the robot upside down (z of the base points down, " +
                              fixed_text(f.base_up.median(), 2) +
                              " along the map's z): a TUM line is t x y z qx qy qz qw, and z of "
                              "base and map point up"};
  for (const SensorFigures& s : f.sensors)
    if (is_mirrored(s))
      return Hint{
          Kind::UpsideDown,
          "the sensor" + of_sensor(f, s) + " is upside down: the ground lies " +
              metres(s.ceiling_above_m.median()) +
              " above it, and should as far below: turn its sensorPose by 180 degrees of roll "
              "(rawlog-edit --sensors-pose)"};
  return {};
}

std::optional<Hint> tilted_ground(const Figures& f)
{
  constexpr double kTilted_rad = kTilted_deg * M_PI / 180;
  for (const SensorFigures& s : f.sensors)
  {
    const bool only_steep = s.share(s.steep_rad) > kGroundShare;
    if (s.has_mounting && !only_steep && s.analysed >= kMinNoGround &&
        s.share(s.ground_m) + s.share(s.above_far_ground_m) + s.share(s.ceiling_above_m) <
            kNoGround)
      return Hint{
          Kind::TiltedGround, "hardly any frame" + of_sensor(f, s) +
                                  " shows ground around the base: are the axes of its points x "
                                  "ahead and z up, or those of a camera, whose z points ahead?"};
    const double in_base_rad = only_steep ? s.steep_rad.median() : lean_rad(s.ground());
    if (!only_steep && !shows_ground(s)) continue;
    if (s.has_mounting && in_base_rad > kTilted_rad)
      return Hint{
          Kind::TiltedGround,
          "the ground" + of_sensor(f, s) + " is tilted against the base by " +
              degrees(in_base_rad) +
              ": the rotation of sensorPose is wrong (yaw pitch roll; x ahead, z up): see "
              "rawlog-edit --sensors-pose"};
    const double in_map_rad = s.lean_in_map_rad.median();
    if (!only_steep && is_in_frame_of_sensor(s))
      return Hint{
          Kind::TiltedGround, "the ground" + of_sensor(f, s) + " is tilted in the map by " +
                                  degrees(in_map_rad) + ", as the sensor is on the base (" +
                                  degrees(s.mount_tilt_rad) +
                                  "): the poses are in the frame that the sensor had at the "
                                  "beginning: --level turns the map upright"};
    if (!only_steep && in_map_rad > kTilted_rad)
      return Hint{
          Kind::TiltedGround,
          "the ground is tilted in the map by " + degrees(in_map_rad) +
              ": check the order of the quaternion (a TUM line is t x y z qx qy qz qw) and that "
              "the map's z points up; --level turns a map that is only tilted"};
  }
  return {};
}

std::optional<Hint> sensor_in_ground(const Figures& f)
{
  for (const SensorFigures& s : f.sensors)
    if (s.share(s.buried) > kGroundShare && s.buried.median() > kBuried)
      return Hint{
          Kind::SensorInGround,
          "the rays" + of_sensor(f, s) + " begin in the ground (" +
              metres(s.sensor_above_m.median()) + " above it, mounted at " + metres(s.sensor.z) +
              "): of the rays to it " + fixed_text(100 * s.buried.median(), 0) +
              " % run into ground that is seen nearer: the points are given in the frame of the "
              "base or of the map: give them in the frame of the sensor, with its mounting as "
              "sensorPose (talus-import --clouds-in map --mount ...)"};
  return {};
}

std::optional<Hint> two_grounds(const Figures& f)
{
  const SensorFigures* lowest = nullptr;
  const SensorFigures* highest = nullptr;
  double lean_deg = 0;
  for (const SensorFigures& s : f.sensors)
  {
    if (!shows_ground(s)) continue;
    if (!lowest || s.ground_m.median() < lowest->ground_m.median()) lowest = &s;
    if (!highest || s.ground_m.median() > highest->ground_m.median()) highest = &s;
    for (const SensorFigures& o : f.sensors)
      if (shows_ground(o))
        lean_deg = std::max(
            lean_deg, std::acos(std::clamp(dot(s.ground().normal, o.ground().normal), -1.0, 1.0)) *
                          180 / M_PI);
  }
  if (!lowest) return {};
  const double apart_m = highest->ground_m.median() - lowest->ground_m.median();
  if (apart_m < kTwoGrounds_m && lean_deg < kTwoGrounds_deg) return {};
  const std::string a = lowest->label,
                    b = highest == lowest ? f.sensors.back().label : highest->label;
  return Hint{
      Kind::TwoGrounds,
      "two sensors see two grounds: '" + b + "' " + metres(apart_m) + " above that of '" + a +
          "', and tilted by up to " + fixed_text(lean_deg, 0) +
          " degrees: one sensorPose is wrong: talus-calibrate --sensor LABEL finds it"};
}

std::optional<Hint> wrong_mounting(const Figures& f)
{
  for (const SensorFigures& s : f.sensors)
  {
    if (!s.has_mounting || !shows_ground(s)) continue;
    if (!is_wrong_height(s) && !is_wrong_tilt(s)) continue;
    const double lean_deg = lean_rad(s.ground()) * 180 / M_PI;
    return Hint{
        Kind::Mounting, "the mounting" + of_sensor(f, s) + " contradicts the ground: seen at " +
                            metres(s.ground_m.median()) +
                            " of the base, where it should be at 0, and tilted by " +
                            fixed_text(lean_deg, 0) + " degrees; the sensor is " +
                            metres(s.sensor_above_m.median()) + " above it, sensorPose says " +
                            metres(s.sensor.z) + ": talus-calibrate finds the mounting"};
  }
  return {};
}

}  // namespace talus::hints
