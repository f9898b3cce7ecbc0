#include "results.h"

#include <talus/sim/scanner.h>
#include <talus/sim/world.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace talus::nav
{
namespace
{
constexpr double kSpeeds_mps[] = {0.35, 0.7, 1.4};
constexpr double kWidths_m[] = {0.5, 1.0, 2.0};

sim::Stopping stopping()
{
  const RobotBody body;
  return {body.reacts_s, body.brakes_mps2, 0.5 * body.length_m};
}

/** To the next centimetre up: it is a least width. */
std::string width_text(double width_m)
{
  if (std::isinf(width_m)) return " none |";
  char text[20];
  std::snprintf(text, sizeof text, " %.2f |", std::ceil(100 * width_m) / 100);
  return text;
}

std::string row(const sim::Scanner& scanner, const Pose& T_base_sensor, const std::string& mount)
{
  char text[60];
  std::snprintf(text, sizeof text, " | %.1f |", sim::nearest_ground_m(scanner, T_base_sensor));
  std::string line = "| " + scanner.name + " | " + mount + text;
  for (const double speed_mps : kSpeeds_mps)
    line += width_text(sim::narrowest_hole_m(scanner, T_base_sensor, speed_mps, stopping()));
  for (const double width_m : kWidths_m)
  {
    std::snprintf(
        text, sizeof text, " %.2f |",
        sim::fastest_before_hole_mps(scanner, T_base_sensor, width_m, stopping()));
    line += text;
  }
  return line + " " + hints::seen_ahead(highest_ray(scanner, T_base_sensor), RobotBody().height_m) +
         " |\n";
}

std::string mount_text(const app::Mounting& m)
{
  char text[80];
  std::snprintf(text, sizeof text, "%.2f m ahead, %.2f m up, pitch %.0f", m[0], m[2], m[4]);
  return text;
}
}  // namespace

hints::HighestRay highest_ray(const sim::Scanner& scanner, const Pose& T_base_sensor)
{
  double slope = -HUGE_VAL;
  for (const double elevation : scanner.elevations_rad)
  {
    const sim::Vec3 d = sim::rotate(T_base_sensor, {std::cos(elevation), 0, std::sin(elevation)});
    if (d.x > 0) slope = std::max(slope, d.z / std::hypot(d.x, d.y));
  }
  return {T_base_sensor.x(), T_base_sensor.z(), slope};
}

std::string drop_table(const std::optional<app::Mounting>& mount)
{
  const double up_m = sim::SensorSetup().T_base_sensor.z();
  const std::vector<app::Mounting> usual{{0, 0, up_m, 0, 0, 0}, {0, 0, up_m, 0, 20, 0}};
  std::string text =
      "| scanner | mounting | ground from [m] | narrowest hole [m] at 0.35 m/s | 0.7 m/s | 1.4 m/s "
      "| "
      "fastest [m/s] at 0.5 m | 1 m | 2 m | seen ahead at the robot's height |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& scanner : sim::scanners())
    for (const auto& m : mount ? std::vector<app::Mounting>{*mount} : usual)
    {
      Options o;
      o.mount = m;
      sim::SensorSetup setup;
      fit_sensor(setup, o);
      text += row(scanner, setup.T_base_sensor, mount_text(m));
    }
  return text;
}

}  // namespace talus::nav
