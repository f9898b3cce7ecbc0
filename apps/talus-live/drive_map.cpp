#include "drive_map.h"

#include "corrected_poses.h"
#include "../common/child_process.h"
#include "../common/import/rawlog_writer.h"
#include "../common/output_folder.h"
#include "../common/run_app.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/site/site_files.h>

#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
/** A pose as a log gives it back. */
mrpt::poses::CPose3D as_in_log(const mrpt::poses::CPose3D& pose)
{
  mrpt::io::CMemoryStream bytes;
  auto archive = mrpt::serialization::archiveFrom(bytes);
  archive << pose;
  bytes.Seek(0);
  mrpt::poses::CPose3D read;
  archive >> read;
  return read;
}

/** Before a drive begins in it. */
site::Site& with_cells_of(const std::string& resume, site::Site& site)
{
  if (!resume.empty()) site::read_site_files(resume, site);
  return site;
}
}  // namespace

DriveMap::DriveMap(
    const Settings& s, double memory_mb, const std::string& folder, const std::string& resume)
    : map_(s.parameters, s.backend, s.threads, s.device.value_or(0)),
      memory_bytes_(static_cast<std::size_t>(memory_mb * 1024 * 1024)),
      site_(s.parameters.resolution_m, memory_bytes_, folder),
      mapper_(with_cells_of(resume, site_))
{
}

void DriveMap::run_on(const Settings& s)
{
  const auto layers = map_.output_layers();
  map_ = ElevationMapper(s.parameters, map_.save(), s.backend, s.threads, s.device.value_or(0));
  map_.set_output_layers(layers);
}

std::string DriveMap::add(const import::ImportedScan& scan, const io::Trajectory& poses)
{
  const auto observation = import::observation_of(scan);
  observation->setSensorPose(as_in_log(scan.T_base_sensor));
  return add(*observation, poses);
}

std::string DriveMap::add(const mrpt::obs::CObservation& scan, const io::Trajectory& poses)
{
  try
  {
    if (!points_from_observation(scan, scan_)) return scan.sensorLabel + ": not a scan";
  }
  catch (const std::runtime_error& e)
  {
    return e.what();
  }
  const auto base_at = [&](double stamp_s) { return poses.at(stamp_s, kMaxGap_s); };
  const auto T_map_base = base_at(scan_.stamp_s);
  if (scan_.x_m.empty() || !T_map_base) return scan.sensorLabel + ": a scan without points or pose";
  Frame frame = frame_from(scan_, *T_map_base);
  frame.path = sensor_path(scan_, base_at);
  try
  {
    frame.sensor = sensors_.number_of(scan.sensorLabel);
    map_.window_after(frame);  // throws for a pose that is none
    T_map_base_ = *T_map_base;
    gatherer_.add(frame, [this](const Frame& whole) { map_scan(whole); });
  }
  catch (const std::invalid_argument& e)
  {
    return scan.sensorLabel + ": " + e.what();
  }
  return "";
}

void DriveMap::map_scan(const Frame& scan)
{
  const FrameReport report = mapper_.update(map_, scan, [this] { ++frames_, show_(); });
  points_ += report.points_in;
  accepted_ += report.points_accepted;
}

void DriveMap::finish(const std::string& folder)
{
  gatherer_.finish([this](const Frame& whole) { map_scan(whole); });
  if (const auto why = why_empty(); !why.empty()) throw std::runtime_error(why);
  write(map_, folder);
}

std::string DriveMap::why_empty() const
{
  if (points_ == 0 || accepted_ > 0) return "";
  return "none of the " + std::to_string(points_) +
         " points was accepted: see window_m, min_height_m, max_height_m (from the sensor "
         "upwards), "
         "min_range_m and max_range_m, which -s NAME=VALUE sets";
}

std::optional<int> DriveMap::start_save(const std::string& folder)
{
  const auto memory = site_.tiles.memory();
  if (site_.tiles.tiles_in_memory() < site_.tiles.keys().size() ||
      memory.open + memory.packed > memory_bytes_ / 2)
    return std::nullopt;
  const auto state = map_.save();
  return start_child(
      [&]
      {
        try
        {
          OutputFolder output(folder);
          write(ElevationMapper(map_.parameters(), state, Backend::Cpu, 1), output.staging());
          output.commit(kSeal);
          return 0;
        }
        catch (const std::exception& e)
        {
          print_error(e.what());
          return 1;
        }
      });
}

void DriveMap::write(const ElevationMapper& map, const std::string& folder)
{
  mapper_.keep_window(map);
  mapper_.look_back(map);
  const fs::path to(folder);
  site::write_site_files((to / "site.tif").string(), (to / "site.png").string(), site_);
  const io::LayerStack window = io::snapshot(map);
  io::write_geotiff((to / kSeal).string(), window);
  io::PictureOptions picture;
  picture.has_robot = true;
  picture.robot_x_m = T_map_base_.x();
  picture.robot_y_m = T_map_base_.y();
  picture.robot_yaw_rad = T_map_base_.yaw();
  io::write_map_picture((to / "map.png").string(), window, picture);
}

}  // namespace talus::app
