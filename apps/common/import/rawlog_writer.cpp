#include "rawlog_writer.h"

#include <mrpt/core/Clock.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/io/packed_log.h>
#include <talus/number_text.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <sstream>

namespace talus::import
{
namespace
{
constexpr const char* kIntensitiesAre = "talus: the intensities of the points are ";
constexpr const char* kStepsAre = "talus: the intensities of the points count in steps of ";
constexpr const char* kTiles = "talus: the points are those of a map, without rays";
constexpr const char* kViewpoints =
    "talus: the points are those of a map, by where they were seen from";
constexpr const char* kFrom = " from ";
constexpr double kMaxByte = 255;

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

std::vector<std::uint8_t> intensity_in_bytes(const ImportedScan& scan, const PointNotes& notes)
{
  std::vector<std::uint8_t> bytes(scan.x_m.size(), 0);
  for (std::size_t i = 0; i < scan.intensity.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(
        std::lround(std::clamp((scan.intensity[i] - notes.least) / notes.step, 0.0, kMaxByte)));
  return bytes;
}

mrpt::obs::CObservation::Ptr timed_observation(const ImportedScan& scan, const PointNotes& notes)
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
  points.intensity = intensity_in_bytes(scan, notes);
  points.laser_id.assign(scan.x_m.size(), 0);  // programs of MRPT count on them
  std::copy(scan.ring.begin(), scan.ring.end(), points.laser_id.begin());
  points.timestamp.reserve(scan.point_time_s.size());
  for (const float time_s : scan.point_time_s)
    points.timestamp.push_back(
        obs.timestamp +
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(time_s)));
  return made;
}

bool is_timed(const ImportedScan& scan) { return !scan.point_time_s.empty() && scan.rgb.empty(); }
}  // namespace

double stamp_in_log_s(double time_s)
{
  return mrpt::Clock::toDouble(mrpt::Clock::fromDouble(time_s));
}

mrpt::obs::CObservation::Ptr observation_of(const ImportedScan& scan, const PointNotes& notes)
{
  auto obs = is_timed(scan) ? timed_observation(scan, notes) : cloud_observation(scan);
  obs->timestamp = mrpt::Clock::fromDouble(scan.time_s);
  obs->sensorLabel = scan.sensor_label;
  obs->setSensorPose(scan.T_base_sensor);
  return obs;
}

struct RawlogWriter::Impl
{
  Impl(const std::string& path, const PointNotes& point_notes) : log(path), notes(point_notes) {}
  void begin(const ImportedScan& scan)
  {
    if (notes.is_guess && is_timed(scan))
    {
      note_range(scan);
      set_steps(notes);
    }
    mrpt::obs::CObservationComment comment;
    if (!notes.values.empty() && notes.values != "rgb")
      comment.text = kIntensitiesAre + notes.values + "\n";
    if (notes.step != 1 || notes.least != 0)
      comment.text +=
          kStepsAre + exact_number_text(notes.step) + kFrom + exact_number_text(notes.least) + "\n";
    if (notes.pieces != Pieces::Scans)
      comment.text += std::string(notes.pieces == Pieces::Tiles ? kTiles : kViewpoints) + "\n";
    if (!comment.text.empty()) log.write(comment);
  }
  void note_range(const ImportedScan& scan)
  {
    for (const float value : scan.intensity)
    {
      min = std::min(min, value);
      max = std::max(max, value);
    }
  }
  /** Values as they are, or, where bytes do not hold them, in 256 steps. */
  void set_steps(PointNotes& n) const
  {
    constexpr double kMax = 65535;  // of any scanner
    const double least = std::max<double>(min, -kMax), most = std::min<double>(max, kMax);
    const bool is_fraction = n.values.empty() && least >= 0 && most > 0 && most <= 1;
    n.step = is_fraction ? 1 / kMaxByte : std::max(1.0, (most - least) / kMaxByte);
    n.least = least;
    n.is_guess = false;
  }
  io::PackedLog log;
  PointNotes notes;
  float min = 0, max = 0;  //!< intensity
  std::size_t scans = 0;
  bool has_bytes = false;  //!< of intensities
};

std::string PointNotes::range_text() const
{
  return "from " + number_text(least) + " to " + number_text(least + step * kMaxByte);
}

PointNotes notes_from(const std::string& comment)
{
  PointNotes notes;
  std::istringstream lines(comment);
  const auto rest = [](const std::string& line, const std::string& begin)
  { return line.compare(0, begin.size(), begin) == 0 ? line.substr(begin.size()) : ""; };
  for (std::string line; std::getline(lines, line);)
  {
    if (auto name = rest(line, kIntensitiesAre); !name.empty()) notes.values = std::move(name);
    if (line == kTiles) notes.pieces = Pieces::Tiles;
    if (line == kViewpoints) notes.pieces = Pieces::Viewpoints;
    const std::string steps = rest(line, kStepsAre);
    const auto from = steps.find(kFrom);
    if (from == std::string::npos) continue;
    notes.step = number_from(steps.substr(0, from)).value_or(1);
    notes.least = number_from(steps.substr(from + std::string(kFrom).size())).value_or(0);
  }
  return notes;
}

RawlogWriter::RawlogWriter(const std::string& path, const PointNotes& notes)
    : impl_(std::make_unique<Impl>(path, notes))
{
}
RawlogWriter::~RawlogWriter() = default;

void RawlogWriter::write(const ImportedScan& scan)
{
  if (impl_->scans++ == 0) impl_->begin(scan);
  if (is_timed(scan))
  {
    impl_->note_range(scan);
    impl_->has_bytes = true;
  }
  impl_->log.write(*observation_of(scan, impl_->notes));
}

const PointNotes& RawlogWriter::notes() const { return impl_->notes; }

bool RawlogWriter::wants(PointNotes& notes) const
{
  notes = impl_->notes;
  if (impl_->has_bytes) impl_->set_steps(notes);
  return notes.step != impl_->notes.step || notes.least != impl_->notes.least;
}

void RawlogWriter::flush() { impl_->log.flush(); }
void RawlogWriter::close() { impl_->log.close(); }

}  // namespace talus::import
