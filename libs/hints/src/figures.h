#pragma once
#include <talus/frame_report.h>
#include <talus/parameters.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "axes_watch.h"
#include "body_watch.h"
#include "contradiction_watch.h"
#include "lag_watch.h"
#include "level_watch.h"
#include "pose_watch.h"

namespace talus::hints
{
/** Over frames; their median counts. */
class Values
{
 public:
  void add(double value) { values_.push_back(static_cast<float>(value)); }
  std::size_t size() const { return values_.size(); }
  /** 0 where there are none. */
  double quantile(double share) const;
  double median() const { return quantile(0.5); }

 private:
  std::vector<float> values_;
};

/** What the frames of one sensor showed of the ground, in the frame of the base. */
struct SensorFigures
{
  std::string label;
  bool has_mounting = false;  //!< the log says where the sensor is
  Vec3 sensor;  //!< where it is mounted
  std::size_t frames = 0, analysed = 0;
  /// @name Of frames that show ground below the sensor
  /// @{
  Values normal_x, normal_y;  //!< of its plane
  Values ground_m;  //!< height at the base
  Values sensor_above_m;  //!< of the sensor, at right angles
  Values rms_m;  //!< of its points
  Values lean_in_map_rad;
  Values reach_m;  //!< 9 of 10 points on it are nearer
  Values nearest_m;  //!< hardly any point on it is nearer to the sensor
  Values buried;  //!< see buried_share()
  Values spread_m;  //!< of heights within small cells of the first frames
  /// @}
  /** Slope in the base of the highest ray ahead and to any side, of frames that have any ahead. */
  Values top_ahead, top_around;
  Values above_far_ground_m;  //!< of the sensor, of frames that show ground farther away only
  Values ceiling_above_m;  //!< of frames that show ground above the sensor, and none below
  Values steep_rad;  //!< lean of the plane of frames where only one leans more than ground does
  BodyWatch body;
  LagWatch lag;
  AxesWatch axes;
  bool is_deskewed = false;  //!< by the map
  double mount_tilt_rad = 0, first_tilt_rad = 0;  //!< of its z axis, against those of base and map

  /** The median plane; level and at the base where no frame shows one. */
  NearPlane ground() const;
  /** Share of the frames analysed. */
  double share(const Values& values) const;
};

/** What a log showed. */
struct Figures
{
  std::vector<SensorFigures> sensors;
  ContradictionWatch ground;
  PoseWatch poses;
  LevelWatch level;
  Values base_up;  //!< z of the base's z axis in the map
  std::size_t frames = 0;
  std::uint64_t points_in = 0, accepted = 0;
  std::array<std::uint64_t, kRejectCount> rejected{};
  std::uint64_t sampled = 0, below_band = 0, above_band = 0;  //!< of the points that were looked at

  const SensorFigures* sensor_with_most_frames() const;
};

}  // namespace talus::hints
