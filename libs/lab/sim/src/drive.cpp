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
constexpr int kMaxFrames = 100000;

Scanner scanner_of(const SensorSetup& sensor, const DriveOptions& options)
{
  const std::string name = options.scanner.value_or(sensor.scanner);
  const Scanner* found = find_scanner(name);
  if (!found)
  {
    std::string known;
    for (const Scanner& s : scanners()) known += (known.empty() ? "" : ", ") + s.name;
    throw std::runtime_error("unknown scanner '" + name + "'; known: " + known);
  }
  Scanner s = *found;
  s.noise_m = options.noise_m.value_or(sensor.noise_m.value_or(s.noise_m));
  s.noise_per_m = options.noise_per_m.value_or(sensor.noise_per_m.value_or(s.noise_per_m));
  s.dropout = sensor.dropout.value_or(s.dropout);
  s.rate_hz = sensor.rate_hz.value_or(s.rate_hz);
  s.max_range_m = sensor.max_range_m.value_or(s.max_range_m);
  return s;
}

Pose moved(Pose T, const Vec3& by_m)
{
  T.m[3] += by_m.x;
  T.m[7] += by_m.y;
  T.m[11] += by_m.z;
  return T;
}

/** T_said_true at a time: where the localisation says that a point of the map is. */
Pose error_at(const PoseErrors& errors, const RobotPath& path, double time_s)
{
  Pose T;
  for (const PoseErrors::Jump& jump : errors.jumps)
  {
    if (jump.time_s > time_s) break;
    const Pose said = compose(T, path.T_map_base(jump.time_s));
    const Vec3 at{said.x(), said.y(), said.z()};
    const Pose turn = pose_from_rpy({0, 0, 0}, jump.roll_rad, jump.pitch_rad, jump.yaw_rad);
    T = compose(moved(turn, at + jump.shift_m - rotate(turn, at)), T);
  }
  return moved(T, errors.drift_mps * time_s);
}

}  // namespace

Drive::Drive(const World& world, const DriveOptions& options)
    : world_(world), options_(options), path_(world), seed_(options.seed.value_or(world.seed))
{
  if (options.every < 1 || options.cut_frames < 1)
    throw std::invalid_argument("a drive needs 1 or more for `every` and for `cut_frames`");
  for (const SensorSetup& s : world.sensors) scanners_.push_back(scanner_of(s, options));
  require_few_frames();
  list_frames();
}

/** Of a sensor during the drive; no whole number if its rate is none. */
double Drive::sweeps(std::size_t sensor) const
{
  const double sees_s = path_.duration_s() - world_.sensors[sensor].phase_s;
  if (sees_s < 0) return 0;
  const double all = std::floor(sees_s * scanners_[sensor].rate_hz + 1e-6) + 1;
  return std::ceil(all / options_.every);
}

void Drive::require_few_frames() const
{
  double frames = 0;
  for (std::size_t s = 0; s < scanners_.size(); ++s) frames += sweeps(s) * options_.cut_frames;
  const double wanted =
      options_.frames ? std::min(frames, static_cast<double>(*options_.frames)) : frames;
  if (wanted <= kMaxFrames) return;
  throw std::runtime_error(
      "world '" + world_.name + "': the drive would have " + number_text(frames) + " frames (" +
      number_text(path_.duration_s()) + " s at " + number_text(scanners_[0].rate_hz) +
      " Hz), the limit is 100000; shorten robot.path_m or robot.duration_s");
}

int Drive::first_column(std::size_t sensor, int cut) const
{
  const std::int64_t columns = scanners_[sensor].columns;
  return static_cast<int>(columns * cut / options_.cut_frames);
}

void Drive::list_frames()
{
  const std::size_t max_frames = static_cast<std::size_t>(options_.frames.value_or(kMaxFrames));
  for (std::size_t s = 0; s < scanners_.size(); ++s)
  {
    const double count = std::min(sweeps(s), static_cast<double>(max_frames));
    for (int i = 0; i < count; ++i)
      for (int cut = 0; cut < options_.cut_frames; ++cut)
      {
        const int sweep = i * options_.every;
        const double cut_s = scanners_[s].column_time_s(first_column(s, cut));
        const double start_s = world_.sensors[s].phase_s + sweep / scanners_[s].rate_hz;
        frames_.push_back({start_s + cut_s, s, sweep, cut, 0});
      }
  }
  if (frames_.empty())
    throw std::runtime_error(
        "world '" + world_.name + "': no sensor begins a sweep within the " +
        number_text(path_.duration_s()) + " s of the drive; give one a smaller phase_s");
  std::stable_sort(
      frames_.begin(), frames_.end(),
      [](const FrameAt& a, const FrameAt& b) { return a.time_s < b.time_s; });
  if (frames_.size() > max_frames) frames_.resize(max_frames);
  for (std::size_t i = 0; i < frames_.size(); ++i)
  {
    const bool same = i > 0 && frames_[i].time_s == frames_[i - 1].time_s;
    frames_[i].pose = same ? frames_[i - 1].pose : static_cast<int>(i);
  }
}

bool Drive::has_pose_errors() const
{
  const PoseErrors& e = world_.poses;
  return options_.pose_noise_m > 0 || options_.angle_noise_rad > 0 || options_.z_drift != 0 ||
         !e.jumps.empty() || norm(e.drift_mps) > 0;
}

Pose Drive::T_map_base_noisy(int frame) const
{
  Pose T = T_map_base(frame);
  if (!has_pose_errors()) return T;
  Random random(mix(seed_ ^ 0x905E, static_cast<std::uint64_t>(at(frame).pose)));
  double e[6];
  for (double& v : e) v = random.normal();
  const double m = options_.pose_noise_m, a = options_.angle_noise_rad;
  T = compose(error_at(world_.poses, path_, time_s(frame)), T);
  T = compose(T, pose_from_rpy({0, 0, 0}, a * e[3], a * e[4], a * e[5]));
  const double drift_m = options_.z_drift * path_.distance_m(time_s(frame));
  return moved(T, {m * e[0], m * e[1], m * e[2] + drift_m});
}

Scan Drive::scan(int frame) const
{
  const FrameAt& f = at(frame);
  const Pose T_base_sensor = setup(frame).T_base_sensor;
  Sweep sweep;
  sweep.time_s = f.time_s;
  sweep.first_column = first_column(f.sensor, f.cut);
  sweep.end_column = first_column(f.sensor, f.cut + 1);
  sweep.T_map_sensor = [this, T_base_sensor](double t)
  { return compose(path_.T_map_base(t), T_base_sensor); };
  sweep.motion_distortion = setup(frame).motion_distortion;
  for (Shape s : world_.robot.body)
  {
    s.T_map_shape = compose(inverse(T_base_sensor), s.T_map_shape);
    sweep.body.push_back(s);
  }
  sweep.seed = mix(seed_, static_cast<std::uint64_t>(f.sweep));
  if (f.sensor > 0) sweep.seed = mix(sweep.seed, f.sensor);
  return take_scan(world_, scanners_[f.sensor], sweep);
}

}  // namespace talus::sim
