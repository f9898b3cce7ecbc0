#include "outputs.h"

#include "../common/memory_limit.h"
#include "../common/log_name.h"
#include "../common/crash_context.h"

#include <talus/calibrate/held_out.h>
#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/observation_points.h>

#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kMaxPitch = 80 * kDegree;  // beyond, roll and yaw turn about the same axis

io::Trajectory load_poses(const AppOptions& o, std::string& source)
{
  auto trajectory = app::poses_of_log(o.log, o.trajectory, &source);
  const std::string beside = app::trajectory_beside(o.log);
  const bool is_own = source != o.trajectory && source != beside;
  if (is_own) source += " of the log";
  if (trajectory.entries().size() >= 2) return trajectory;
  if (is_own)
    throw std::runtime_error(
        o.log + ": holds no poses of the robot. Pass --trajectory FILE, or put them into " +
        beside);
  throw std::runtime_error(
      source + ": number of poses: " + std::to_string(trajectory.entries().size()) +
      ", which shows no motion; two or more are needed, of a robot that drives");
}

mrpt::poses::CPose3D given_mounting(const AppOptions& o, const SensorPoints& first)
{
  mrpt::poses::CPose3D T = first.T_base_sensor;
  if (o.mounting)
  {
    const app::Mounting& m = *o.mounting;
    T = {m[0], m[1], m[2], m[3] * kDegree, m[4] * kDegree, m[5] * kDegree};
  }
  if (std::abs(T.pitch()) > kMaxPitch)
    throw std::runtime_error(
        o.log + ": the sensor is mounted with a pitch of " + std::to_string(T.pitch() / kDegree) +
        " degrees; beyond 80 degrees roll and yaw are not separable");
  return T;
}

/** Takes the scans of one sensor. */
class Loader
{
 public:
  explicit Loader(const AppOptions& options) : options_(options) {}

  void take(const mrpt::obs::CObservation& obs)
  {
    if (!options_.sensor.empty() && obs.sensorLabel != options_.sensor)
    {
      others_.insert(obs.sensorLabel);
      return;
    }
    if (!points_from_observation(obs, scan_)) return;
    if (scan_.x_m.empty() || !std::isfinite(scan_.stamp_s))
    {
      ++skipped;
      return;
    }
    if (!scans_) start(obs.sensorLabel);
    if (obs.sensorLabel != label_)
      throw std::runtime_error(
          options_.log + ": holds scans of several sensors, '" + label_ + "' and '" +
          obs.sensorLabel + "': choose one with --sensor");
    if (!options_.mounting && scan_.T_base_sensor.distanceTo(logged_) > 1e-3)
      throw std::runtime_error(
          options_.log + ": the mounting of '" + label_ +
          "' changes within the log; say the one to start from with --mount");
    for (ScanSet* set : {&*scans_, &*rolled_})
      set->add(
          scan_.stamp_s, scan_.x_m.data(), scan_.y_m.data(), scan_.z_m.data(),
          scan_.time_s.empty() ? nullptr : scan_.time_s.data(), scan_.x_m.size());
  }

  LoadedLog finish(PoseTrack track, std::string source)
  {
    if (scans_)
    {
      const Vector given = vector_of(mounting_);
      const bool is_rolled = is_upside_down(*scans_, *rolled_, given);
      return {
          std::move(is_rolled ? *rolled_ : *scans_),
          std::move(track),
          is_rolled ? pose_of(rolled_over(given)) : mounting_,
          is_rolled,
          label_,
          std::move(source),
          skipped};
    }
    std::string known;
    for (const auto& name : others_) known += (known.empty() ? "'" : ", '") + name + "'";
    throw std::runtime_error(
        options_.log + (others_.empty()
                            ? ": holds no scans"
                            : ": no scans of a sensor called '" + options_.sensor +
                                  "'; this log has " + known + ": choose one with --sensor"));
  }

 private:
  void start(const std::string& label)
  {
    label_ = label;
    logged_ = scan_.T_base_sensor;
    mounting_ = given_mounting(options_, scan_);
    scans_.emplace(options_.thinning, mounting_, options_.base_height_m);
    rolled_.emplace(
        options_.thinning, pose_of(rolled_over(vector_of(mounting_))), options_.base_height_m);
  }

  const AppOptions& options_;
  std::optional<ScanSet> scans_, rolled_;  //!< as given, and upside down
  SensorPoints scan_;
  mrpt::poses::CPose3D mounting_, logged_;
  std::string label_;
  std::set<std::string> others_;
  std::size_t skipped = 0;
};
}  // namespace

LoadedLog load_log(const AppOptions& options, const std::function<void(double)>& progress)
{
  const std::size_t memory_bytes = app::memory_for_log(options.log);
  const auto reader = app::guarded(
      options.log, app::kLookAtLog, [&] { return std::make_unique<io::RawlogReader>(options.log); },
      memory_bytes);
  std::string source;
  PoseTrack track(load_poses(options, source), options.max_gap_s);
  Loader loader(options);
  while (const auto obs = app::guarded(
             options.log, app::kLookAtLog, [&] { return reader->next(); }, memory_bytes))
  {
    loader.take(*obs);
    progress(reader->progress());
  }
  return loader.finish(std::move(track), source);
}

}  // namespace talus::calibrate
