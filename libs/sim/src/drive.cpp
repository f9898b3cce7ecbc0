#include <talus/number_text.h>
#include <talus/sim/drive.h>
#include <talus/sim/random.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace talus::sim
{
namespace
{
constexpr double kMaxFrames = 100000;

Scanner scanner_of(const World& world, const DriveOptions& options)
{
  const std::string name = options.scanner.value_or(world.sensor.scanner);
  const Scanner* found = find_scanner(name);
  if (!found)
  {
    std::string known;
    for (const Scanner& s : scanners()) known += (known.empty() ? "" : ", ") + s.name;
    throw std::runtime_error("unknown scanner '" + name + "'; known: " + known);
  }
  Scanner s = *found;
  s.noise_m = options.noise_m.value_or(world.sensor.noise_m.value_or(s.noise_m));
  s.noise_per_m = options.noise_per_m.value_or(world.sensor.noise_per_m.value_or(s.noise_per_m));
  s.dropout = world.sensor.dropout.value_or(s.dropout);
  s.rate_hz = world.sensor.rate_hz.value_or(s.rate_hz);
  s.max_range_m = world.sensor.max_range_m.value_or(s.max_range_m);
  return s;
}

}  // namespace

Drive::Drive(const World& world, const DriveOptions& options)
    : world_(world),
      options_(options),
      scanner_(scanner_of(world, options)),
      path_(world.robot, world.ground),
      seed_(options.seed.value_or(world.seed))
{
  const double duration_s = path_.duration_s();
  double frames = std::floor(duration_s * scanner_.rate_hz + 1e-6) + 1;
  if (options.frames) frames = std::min(frames, static_cast<double>(*options.frames));
  if (!(frames <= kMaxFrames))
    throw std::runtime_error(
        "world '" + world.name + "': the drive would have " + number_text(frames) + " frames (" +
        number_text(duration_s) + " s at " + number_text(scanner_.rate_hz) +
        " Hz), the limit is 100000; shorten robot.path_m or robot.duration_s");
  frames_ = static_cast<int>(frames);
}

bool Drive::has_pose_errors() const
{
  return options_.pose_noise_m > 0 || options_.angle_noise_rad > 0 || options_.z_drift != 0;
}

Pose Drive::T_map_base_noisy(int frame) const
{
  Pose T = T_map_base(frame);
  if (!has_pose_errors()) return T;
  Random random(mix(seed_ ^ 0x905E, static_cast<std::uint64_t>(frame)));
  double e[6];
  for (double& v : e) v = random.normal();
  const double m = options_.pose_noise_m, a = options_.angle_noise_rad;
  T = compose(T, pose_from_rpy({0, 0, 0}, a * e[3], a * e[4], a * e[5]));
  T.m[3] += m * e[0];
  T.m[7] += m * e[1];
  T.m[11] += m * e[2] + options_.z_drift * path_.distance_m(time_s(frame));
  return T;
}

Scan Drive::scan(int frame) const
{
  Sweep sweep;
  sweep.time_s = time_s(frame);
  sweep.T_map_sensor = [this](double t)
  { return compose(path_.T_map_base(t), world_.sensor.T_base_sensor); };
  sweep.motion_distortion = world_.sensor.motion_distortion;
  sweep.seed = mix(seed_, static_cast<std::uint64_t>(frame));
  return take_scan(world_, scanner_, sweep);
}

}  // namespace talus::sim
