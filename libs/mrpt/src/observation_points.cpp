#include <talus/mrpt/observation_points.h>
#include <talus/mrpt/version_compat.h>

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/io/mrpt_error.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/frame.h"
#include "observation_points_detail.h"

using namespace mrpt::obs;

namespace talus
{
namespace detail
{
void fail(const CObservation& obs, const std::string& what)
{
  throw std::runtime_error(
      std::string(obs.GetRuntimeClass()->className) + " '" + obs.sensorLabel + "': " + what + ".");
}

void read_points(const CObservationPointCloud& obs, SensorPoints& out)
{
  if (!obs.pointcloud)
    fail(
        obs, obs.isExternallyStored()
                 ? "its points are in the file " + obs.getExternalStorageFile() +
                       ", which is not loaded. Put the directory of external files beside the log"
                 : std::string("it has no point cloud. Record it again"));
  const auto& cloud = *obs.pointcloud;
  const auto &x = cloud.getPointsBufferRef_x(), &y = cloud.getPointsBufferRef_y(),
             &z = cloud.getPointsBufferRef_z();
  out.x_m.assign(x.begin(), x.end());
  out.y_m.assign(y.begin(), y.end());
  out.z_m.assign(z.begin(), z.end());
  if (const auto* times = point_times(cloud); times && times->size() == out.x_m.size())
    out.time_s.assign(times->begin(), times->end());
  for (std::size_t c = 0; c < out.channels.size(); ++c)
    read_point_field(cloud, out.channel_names[c], out.channels[c]);
}

/** The scanner may nod during the scan: sensorPose is its pose at the first ray, and deltaPitch by
 * how much it has turned about its y axis at the last. */
void read_points(const CObservation2DRangeScan& obs, SensorPoints& out)
{
  const std::size_t rays = obs.getScanSize();
  std::vector<float>* const intensity = obs.hasIntensity() ? channel_of(out, kIntensity) : nullptr;
  for (std::size_t i = 0; i < rays; ++i)
  {
    if (!obs.getScanRangeValidity(i)) continue;
    const double range = obs.getScanRange(i);
    const double azimuth = obs.getScanAngle(i);
    const double pitch =
        rays > 1 ? obs.deltaPitch * static_cast<double>(i) / static_cast<double>(rays - 1) : 0.0;
    const double x = range * std::cos(azimuth);
    add_point(out, x * std::cos(pitch), range * std::sin(azimuth), -x * std::sin(pitch));
    if (intensity) intensity->push_back(static_cast<float>(obs.getScanIntensity(i)));
  }
}

namespace
{
void clear(SensorPoints& points)
{
  points.x_m.clear();
  points.y_m.clear();
  points.z_m.clear();
  points.time_s.clear();
  points.channels.resize(points.channel_names.size());
  for (auto& values : points.channels) values.clear();
}

/** Reads the observation if it is of that class. */
template <class Observation>
bool read_as(const CObservation& obs, SensorPoints& out)
{
  const auto* known = dynamic_cast<const Observation*>(&obs);
  if (!known) return false;
  clear(out);
  out.stamp_s = mrpt::Clock::toDouble(obs.timestamp);
  out.T_base_sensor = known->sensorPose;
  out.sensor_label = known->sensorLabel;
  try
  {
    known->load();
  }
  catch (const std::exception& e)
  {
    fail(
        obs, "its external data cannot be loaded (" + io::reason_of(e) +
                 "). Put the directory of external files beside the log");
  }
  read_points(*known, out);
  return true;
}

}  // namespace
}  // namespace detail

bool points_from_observation(const CObservation& obs, SensorPoints& out)
{
  using namespace detail;
  return read_as<CObservationPointCloud>(obs, out) || read_as<CObservationVelodyneScan>(obs, out) ||
         read_as<CObservationRotatingScan>(obs, out) ||
         read_as<CObservation3DRangeScan>(obs, out) || read_as<CObservation2DRangeScan>(obs, out);
}

std::uint32_t SensorNumbers::number_of(const std::string& label)
{
  const auto known = std::find(labels_.begin(), labels_.end(), label);
  const auto number = static_cast<std::uint32_t>(known - labels_.begin());
  if (known != labels_.end()) return number;
  if (labels_.size() == kMaxSensors)
    throw std::invalid_argument(
        "'" + label + "' is a sensor label more than the " + std::to_string(kMaxSensors) +
        " that one map tells apart: a sensor keeps its label from scan to scan");
  labels_.push_back(label);
  return number;
}

std::vector<TimedPose> sensor_path(
    const SensorPoints& points,
    const std::function<std::optional<mrpt::poses::CPose3D>(double stamp_s)>& base_at)
{
  constexpr double kPathStep_s = 0.01;  // a robot that turns at 1 rad/s turns 0.6 degrees in it
  float first = HUGE_VALF, last = -HUGE_VALF;
  for (const float t : points.time_s)
    if (std::isfinite(t))
    {
      first = std::min(first, t);
      last = std::max(last, t);
    }
  const double span_s = static_cast<double>(last) - first;
  if (!(span_s > 0)) return {};

  const int steps = static_cast<int>(
      std::clamp(std::ceil(span_s / kPathStep_s), 1.0, kernels::kMaxPathPoses - 1.0));
  std::vector<TimedPose> path;
  for (int i = 0; i <= steps; ++i)
  {
    const double t = first + span_s * i / steps;
    if (const auto T_map_base = base_at(points.stamp_s + t))
      path.push_back({t, pose_from(*T_map_base + points.T_base_sensor)});
  }
  if (path.size() < 2) path.clear();
  return path;
}

}  // namespace talus
