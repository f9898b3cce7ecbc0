#pragma once
// Private to the readers of observations: one overload a class, all fill an emptied SensorPoints.
#include <talus/mrpt/observation_points.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace mrpt::obs
{
class CObservation2DRangeScan;
class CObservation3DRangeScan;
class CObservationPointCloud;
class CObservationRotatingScan;
class CObservationVelodyneScan;
}  // namespace mrpt::obs

namespace talus::detail
{
void read_points(const mrpt::obs::CObservationPointCloud& obs, SensorPoints& out);
void read_points(const mrpt::obs::CObservationVelodyneScan& obs, SensorPoints& out);
void read_points(const mrpt::obs::CObservationRotatingScan& obs, SensorPoints& out);
void read_points(const mrpt::obs::CObservation3DRangeScan& obs, SensorPoints& out);
void read_points(const mrpt::obs::CObservation2DRangeScan& obs, SensorPoints& out);

/** Throws std::runtime_error: class, label, what is wrong, what to do. */
[[noreturn]] void fail(const mrpt::obs::CObservation& obs, const std::string& what);

inline void add_point(SensorPoints& out, double x_m, double y_m, double z_m)
{
  out.x_m.push_back(static_cast<float>(x_m));
  out.y_m.push_back(static_cast<float>(y_m));
  out.z_m.push_back(static_cast<float>(z_m));
}

constexpr const char* kIntensity = "intensity";

/** Where the values of that name go; null: nobody asked for them. */
inline std::vector<float>* channel_of(SensorPoints& out, const char* name)
{
  const auto found = std::find(out.channel_names.begin(), out.channel_names.end(), name);
  if (found == out.channel_names.end()) return nullptr;
  return &out.channels[found - out.channel_names.begin()];
}

/** When the lasers of a Velodyne fire, from the user manuals. */
struct FiringTimes
{
  double cycle_us;  //!< from one firing of all lasers to the next
  double step_us;  //!< from one laser (or group) to the next; 0: all with the block's azimuth
  int group;  //!< lasers that fire together

  /** Time of a laser after the first one of its cycle [us]. */
  double of(int laser) const { return step_us * static_cast<double>(laser / group); }
};

constexpr FiringTimes kFiringVlp16{55.296, 2.304, 1};
constexpr FiringTimes kFiringHdl32{46.08, 1.152, 1};
constexpr FiringTimes kFiringVlp32c{55.296, 2.304, 2};
/** The azimuth corrections in the calibration of an HDL-64 hold for the azimuth of the block. */
constexpr FiringTimes kFiringHdl64{48.0, 0.0, 1};

}  // namespace talus::detail
