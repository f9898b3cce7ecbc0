#include "rawlog_writer.h"

#include <mrpt/core/Clock.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/io/packed_log.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace talus::import
{
namespace
{
constexpr const char* kIntensitiesAre = "talus: the intensities of the points are ";

mrpt::maps::CPointsMap::Ptr cloud_of(const ImportedScan& scan)
{
  const std::size_t count = scan.x_m.size();
  if (!scan.rgb.empty())
  {
    const auto points = talus::detail::make_cloud_with_colours(count);
    for (std::size_t i = 0; i < count; ++i)
    {
      points->setPointFast(i, scan.x_m[i], scan.y_m[i], scan.z_m[i]);
      talus::detail::set_colour(*points, i, scan.rgb[i]);
    }
    return points;
  }
  if (scan.intensity.empty())
  {
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->resize(count);
    for (std::size_t i = 0; i < count; ++i)
      points->setPointFast(i, scan.x_m[i], scan.y_m[i], scan.z_m[i]);
    return points;
  }
  const auto points = talus::detail::make_cloud_with_intensity(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    points->setPointFast(i, scan.x_m[i], scan.y_m[i], scan.z_m[i]);
    talus::detail::set_intensity(*points, i, scan.intensity[i]);
  }
  return points;
}

mrpt::obs::CObservation::Ptr cloud_observation(const ImportedScan& scan)
{
  auto obs = mrpt::obs::CObservationPointCloud::Create();
  obs->pointcloud = cloud_of(scan);
  return obs;
}

/** In steps of 1/255 where a file has intensities from 0 to 1; other values as they are. */
std::vector<std::uint8_t> intensity_in_bytes(const ImportedScan& scan, bool is_intensity)
{
  std::vector<std::uint8_t> bytes(scan.x_m.size(), 0);
  if (scan.intensity.empty()) return bytes;
  const float most = *std::max_element(scan.intensity.begin(), scan.intensity.end());
  const float scale = is_intensity && most <= 1 ? 255.0F : 1.0F;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] =
        static_cast<std::uint8_t>(std::lround(std::clamp(scan.intensity[i] * scale, 0.0F, 255.0F)));
  return bytes;
}

mrpt::obs::CObservation::Ptr timed_observation(const ImportedScan& scan, bool is_intensity)
{
  using Duration = mrpt::Clock::duration;
  auto made = mrpt::obs::CObservationVelodyneScan::Create();
  auto& obs = *made;
  obs.timestamp = mrpt::Clock::fromDouble(scan.time_s);
  obs.minRange = 0;
  auto& points = obs.point_cloud;
  points.x.assign(scan.x_m.begin(), scan.x_m.end());
  points.y.assign(scan.y_m.begin(), scan.y_m.end());
  points.z.assign(scan.z_m.begin(), scan.z_m.end());
  points.intensity = intensity_in_bytes(scan, is_intensity);
  points.laser_id.assign(scan.x_m.size(), 0);  // programs of MRPT count on them
  std::copy(scan.ring.begin(), scan.ring.end(), points.laser_id.begin());
  points.timestamp.reserve(scan.point_time_s.size());
  for (const float time_s : scan.point_time_s)
    points.timestamp.push_back(
        obs.timestamp +
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(time_s)));
  return made;
}
}  // namespace

double stamp_in_log_s(double time_s)
{
  return mrpt::Clock::toDouble(mrpt::Clock::fromDouble(time_s));
}

mrpt::obs::CObservation::Ptr observation_of(const ImportedScan& scan, bool is_intensity)
{
  const bool keeps_times = !scan.point_time_s.empty() && scan.rgb.empty();
  auto obs = keeps_times ? timed_observation(scan, is_intensity) : cloud_observation(scan);
  obs->timestamp = mrpt::Clock::fromDouble(scan.time_s);
  obs->sensorLabel = scan.sensor_label;
  obs->setSensorPose(scan.T_base_sensor);
  return obs;
}

struct RawlogWriter::Impl
{
  Impl(const std::string& path, const std::string& values) : log(path), is_intensity(values.empty())
  {
    if (values.empty() || values == "rgb") return;
    mrpt::obs::CObservationComment comment;
    comment.text = kIntensitiesAre + values;
    log.write(comment);
  }
  io::PackedLog log;
  bool is_intensity;  //!< the intensities are such
};

std::optional<std::string> values_told_by(const std::string& comment)
{
  const std::string begin = kIntensitiesAre;
  if (comment.compare(0, begin.size(), begin) != 0) return std::nullopt;
  return comment.substr(begin.size());
}

RawlogWriter::RawlogWriter(const std::string& path, const std::string& values)
    : impl_(std::make_unique<Impl>(path, values))
{
}
RawlogWriter::~RawlogWriter() = default;

void RawlogWriter::write(const ImportedScan& scan)
{
  impl_->log.write(*observation_of(scan, impl_->is_intensity));
}

void RawlogWriter::close() { impl_->log.close(); }

}  // namespace talus::import
