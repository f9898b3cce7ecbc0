#pragma once
#include <talus/calibrate/mounting.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace talus::calibrate
{
/** Points that were taken at one time: a frame, or a slice of one whose points have times. */
struct View
{
  double time_s = 0;  //!< by the clock of the log
  int frame = 0;
  std::uint32_t first = 0, count = 0;  //!< of the set's points
};

/** Which points of a log are kept. */
struct Thinning
{
  double min_range_m = 0.3, max_range_m = 20;
  /** Points this far above or below the ground under the robot, given the mounting, may be ground:
   * `band_m` and `band_slope` for each metre away. */
  double band_m = 0.4, band_slope = 0.35;
  int points_per_frame = 6000;
  std::size_t most_points = 2000000;  //!< of all; with more, half of them go, again and again
  int hold_out_every = 5;  //!< every so many frames one is kept from the fit; 0: none
};

/** The points of a log that may show the ground, sensor frame. */
class ScanSet
{
 public:
  /** `base_height_m`: of the base above the ground. */
  ScanSet(
      const Thinning& thinning, const mrpt::poses::CPose3D& T_base_sensor, double base_height_m);

  /** One frame: `size` coordinates each [m], NaN is dropped, and times relative to the stamp [s] or
   * nullptr; points hours away are dropped. Which points are kept depends on their number in the
   * frame only. */
  void add(
      double stamp_s, const float* x_m, const float* y_m, const float* z_m, const float* time_s,
      std::size_t size);

  int frames() const { return static_cast<int>(stamps_s_.size()); }
  double stamp_s(int frame) const { return stamps_s_[static_cast<std::size_t>(frame)]; }
  bool held_out(int frame) const;
  const std::vector<View>& views() const { return views_; }
  Eigen::Vector3d point(std::uint32_t i) const { return points_[i].cast<double>(); }
  std::size_t points() const { return points_.size(); }
  std::size_t points_in() const { return points_in_; }
  const Thinning& thinning() const { return thinning_; }
  double base_height_m() const { return base_height_m_; }

 private:
  bool may_be_ground(const Eigen::Vector3f& p) const;
  void halve();

  Thinning thinning_;
  MountingPose mounting_;
  double base_height_m_ = 0;
  std::vector<double> stamps_s_;
  std::vector<View> views_;
  std::vector<Eigen::Vector3f> points_;
  std::size_t points_in_ = 0;
};

/** A hash, for choices that look random and are the same every time. Uniform in [0, 1). */
double chance(std::uint64_t a, std::uint64_t b);

}  // namespace talus::calibrate
