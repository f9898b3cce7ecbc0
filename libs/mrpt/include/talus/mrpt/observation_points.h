#pragma once
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/frame.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace talus
{
/** The points of one observation, in the frame of its sensor (x forward, y left, z up). */
struct SensorPoints
{
  /** May hold NaN or zero-range returns: the map counts and drops them. */
  std::vector<float> x_m, y_m, z_m;
  std::vector<float>
      time_s;  //!< per point, relative to stamp_s; empty when the observation has none
  /** Which values of each point are read besides, for the channels of a map; set before. */
  std::vector<std::string> channel_names;
  /** By those names: a value a point, or empty where the observation has none. */
  std::vector<std::vector<float>> channels;
  double stamp_s = 0;  //!< seconds since the epoch: that of the observation
  mrpt::poses::CPose3D T_base_sensor;  //!< where the sensor is mounted
  std::string sensor_label;  //!< which of several sensors
};

/** Reads the points out of CObservationPointCloud, CObservationVelodyneScan (all returns of every
 * block, both of dual ones), CObservationRotatingScan, CObservation3DRangeScan (every pixel),
 * CObservation2DRangeScan. Rays without a return give no point, nor do Velodyne and rotating-scan
 * returns outside the minRange..maxRange that the observation states. The memory of `out` is used
 * again. Those of a level 2D scan all have one height: whoever maps them takes each wall that it
 * hits for flat ground.
 *
 * Values that can be read besides: `intensity` (clouds with intensities, Velodyne from 0 to 255,
 * rotating and 2D scans), `red`, `green` and `blue` from 0 to 255 (clouds with colours); from MRPT
 * 2.15 on all fields of clouds that are floats. NaN for points without.
 *
 * False for any other class, `out` is then untouched. Throws std::runtime_error when a supported
 * observation cannot be decoded (names class, label and reason). */
bool points_from_observation(const mrpt::obs::CObservation& obs, SensorPoints& out);

/** The points as a frame, its sensor at `T_map_base (+) T_base_sensor`; without a path, and as
 * those of sensor 0: SensorNumbers gives each label its own. Valid as long as `points` stays. */
Frame frame_from(const SensorPoints& points, const mrpt::poses::CPose3D& T_map_base);

/** The same rigid transform without MRPT. */
Pose pose_from(const mrpt::poses::CPose3D& pose);
/** The same with MRPT. */
mrpt::poses::CPose3D to_mrpt(const Pose& T);

/** Frame::sensor of the sensors of one map, by their labels: in the order in which they appear. */
class SensorNumbers
{
 public:
  SensorNumbers() = default;
  /** Of a map that has these already. */
  explicit SensorNumbers(std::vector<std::string> labels) : labels_(std::move(labels)) {}

  /** Throws std::invalid_argument for one sensor more than a map tells apart, kMaxSensors. */
  std::uint32_t number_of(const std::string& label);

  /** By number. */
  const std::vector<std::string>& labels() const { return labels_; }

 private:
  std::vector<std::string> labels_;
};

/** The poses of the sensor over the times of the points, for Frame::path; empty where the points
 * have no times, or `base_at`, the base in the map at a time [s], does not know two poses of them.
 */
std::vector<TimedPose> sensor_path(
    const SensorPoints& points,
    const std::function<std::optional<mrpt::poses::CPose3D>(double stamp_s)>& base_at);

}  // namespace talus
