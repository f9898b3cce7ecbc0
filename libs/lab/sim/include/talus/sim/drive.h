#pragma once
#include <talus/sim/robot.h>
#include <talus/sim/scanner.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::sim
{
/** What a drive takes from elsewhere than its world. */
struct DriveOptions
{
  std::optional<std::string> scanner;
  std::optional<std::uint64_t> seed;
  std::optional<double> noise_m;  //!< standard deviation of a range
  std::optional<double> noise_per_m;  //!< its growth with the range [m/m]
  std::optional<int> frames;  //!< the maximum number
  int every = 1;  //!< of each sensor's sweeps, only one of this number, the first
  /** A sweep becomes this number of frames by its columns, each with the stamp and pose of its
   * first. */
  int cut_frames = 1;
  double pose_noise_m = 0;  //!< standard deviation of the noisy pose in x, y and z
  double angle_noise_rad = 0;  //!< the same in roll, pitch and yaw
  double z_drift = 0;  //!< how the noisy pose climbs, metres per metre driven
};

/** A robot drives through a world and scans it. The frames of all its sensors are in the order of
 * time, those of one time in the order of the sensors. */
class Drive
{
 public:
  /** Keeps a reference to `world`. Throws std::runtime_error for an unknown scanner and for no
   * or more than 100,000 frames, std::invalid_argument for fewer than one in `every` or
   * `cut_frames`. */
  explicit Drive(const World& world, const DriveOptions& options = {});

  int frames() const { return static_cast<int>(frames_.size()); }
  const Scanner& scanner(std::size_t sensor = 0) const { return scanners_[sensor]; }
  /** Which of the world's sensors took a frame. */
  std::size_t sensor(int frame) const { return at(frame).sensor; }
  const Pose& T_base_sensor(int frame) const { return setup(frame).T_base_sensor; }
  const RobotPath& path() const { return path_; }
  /** Since the start of the drive [s]. */
  double time_s(int frame) const { return at(frame).time_s; }

  Pose T_map_base(int frame) const { return path_.T_map_base(time_s(frame)); }
  /** As a localisation with the errors of the world and the options would say; the truth without
   * them. */
  Pose T_map_base_noisy(int frame) const;
  bool has_pose_errors() const;

  /** Points in the sensor frame. Frames can be asked for in any order. */
  Scan scan(int frame) const;

 private:
  /** Part of one sweep of one sensor. */
  struct FrameAt
  {
    double time_s;
    std::size_t sensor;
    int sweep, cut;
    int pose;  //!< the first frame of the same time: they share the noise of the pose
  };
  const FrameAt& at(int frame) const { return frames_[frame]; }
  const SensorSetup& setup(int frame) const { return world_.sensors[at(frame).sensor]; }
  int first_column(std::size_t sensor, int cut) const;
  void list_frames();
  void require_few_frames() const;
  double sweeps(std::size_t sensor) const;

  const World& world_;
  DriveOptions options_;
  std::vector<Scanner> scanners_;  //!< of each sensor
  RobotPath path_;
  std::uint64_t seed_ = 0;
  std::vector<FrameAt> frames_;
};

}  // namespace talus::sim
