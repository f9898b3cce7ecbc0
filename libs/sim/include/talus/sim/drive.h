#pragma once
#include <talus/sim/robot.h>
#include <talus/sim/scanner.h>

#include <optional>
#include <string>

namespace talus::sim
{
/** What a drive takes from elsewhere than its world. */
struct DriveOptions
{
  std::optional<std::string> scanner;
  std::optional<std::uint64_t> seed;
  std::optional<double> noise_m;  //!< standard deviation of a range
  std::optional<double> noise_per_m;  //!< its growth with the range [m/m]
  std::optional<int> frames;  //!< at most so many
  double pose_noise_m = 0;  //!< standard deviation of the noisy pose in x, y and z
  double angle_noise_rad = 0;  //!< the same in roll, pitch and yaw
  double z_drift = 0;  //!< how the noisy pose climbs, metres per metre driven
};

/** A robot drives through a world and scans it. Frame i is at i / rate after the start. */
class Drive
{
 public:
  /** Keeps a reference to `world`. Throws std::runtime_error for an unknown scanner or more than
   * 100,000 frames. */
  explicit Drive(const World& world, const DriveOptions& options = {});

  int frames() const { return frames_; }
  const Scanner& scanner() const { return scanner_; }
  const RobotPath& path() const { return path_; }
  /** Since the start of the drive [s]. */
  double time_s(int frame) const { return frame / scanner_.rate_hz; }

  Pose T_map_base(int frame) const { return path_.T_map_base(time_s(frame)); }
  /** As a localisation with the errors of the options would say; the truth without them. */
  Pose T_map_base_noisy(int frame) const;
  bool has_pose_errors() const;

  /** Points in the sensor frame. Frames can be asked for in any order. */
  Scan scan(int frame) const;

 private:
  const World& world_;
  DriveOptions options_;
  Scanner scanner_;
  RobotPath path_;
  std::uint64_t seed_ = 0;
  int frames_ = 0;
};

}  // namespace talus::sim
