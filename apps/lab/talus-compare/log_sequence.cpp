#include "options.h"

#include "../../common/memory_limit.h"
#include "../../common/log_name.h"
#include "../../common/crash_context.h"
#include "../../common/run_app.h"

#include <talus/input_file.h>
#include <talus/io/geotiff.h>
#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/observation_points.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::baselines
{
namespace
{
constexpr double kMaxGap_s = 0.5;

/** Where no map is: MRPT's have coordinates of 32 bits, which would be half a metre apart there. */
bool is_nowhere(const mrpt::poses::CPose3D& T_map_base)
{
  constexpr double kFarthest_m = 1e6, kHighest_m = 1e5;
  return std::abs(T_map_base.x()) > kFarthest_m || std::abs(T_map_base.y()) > kFarthest_m ||
         std::abs(T_map_base.z()) > kHighest_m;
}

void warn_of_skipped(const std::string& path, int scans)
{
  if (scans == 0) return;
  app::print_error(
      "warning: " + path + ": " + std::to_string(scans) +
      (scans == 1 ? " scan was" : " scans were") +
      " skipped: the pose is more than 1000 km away from the origin of the map, or more "
      "than 100 km high; look for it in the trajectory");
}

ScanFrame frame_from(
    SensorPoints& points, const mrpt::poses::CPose3D& T_map_base, SensorNumbers& sensors)
{
  ScanFrame f;
  f.sensor = sensors.number_of(points.sensor_label);
  f.stamp_s = points.stamp_s;
  f.T_map_sensor = f.T_true = pose_from(T_map_base + points.T_base_sensor);
  f.T_base_sensor = pose_from(points.T_base_sensor);
  f.x_m = std::move(points.x_m);
  f.y_m = std::move(points.y_m);
  f.z_m = std::move(points.z_m);
  return f;
}

const std::vector<float>& band(
    const io::LayerStack& stack, const std::string& name, const std::string& path)
{
  const auto* layer = stack.find(name);
  if (!layer)
    throw std::runtime_error(
        "'" + path + "' has no band '" + name +
        "'; give a truth.tif that talus-sim wrote, or labels: the bands ground and label");
  return *layer;
}

}  // namespace

Sequence read_log(const std::string& path, const LogOptions& options)
{
  const std::string& sensor = options.sensor;
  const io::Trajectory poses = app::poses_of_log(path, options.trajectory);
  if (poses.empty())
    throw std::runtime_error("'" + path + "' holds no poses; pass --trajectory FILE");
  const std::size_t memory_bytes = app::memory_for_log(path);
  const auto reader = app::guarded(
      path, app::kLookAtLog, [&] { return std::make_unique<io::RawlogReader>(path); },
      memory_bytes);
  Sequence sequence;
  sequence.name = app::name_of_log(path);
  SensorNumbers sensors;
  int nowhere = 0;
  std::size_t scans = 0;
  const auto is_full = [&]
  { return options.frames && sequence.frames.size() >= static_cast<std::size_t>(*options.frames); };
  while (!is_full())
  {
    const auto obs = app::guarded(
        path, app::kLookAtLog, [&] { return reader->next(); }, memory_bytes);
    if (!obs) break;
    if (!sensor.empty() && obs->sensorLabel != sensor) continue;
    SensorPoints points;
    if (!points_from_observation(*obs, points)) continue;
    ++scans;
    const auto T = poses.at(points.stamp_s, kMaxGap_s);
    if (T && is_nowhere(*T))
      ++nowhere;
    else if (T)
    {
      add_sensor(sequence, points.sensor_label);
      sequence.frames.push_back(frame_from(points, *T, sensors));
      sequence.frames.back().scan = scans - 1;
    }
  }
  warn_of_skipped(path, nowhere);
  if (sequence.frames.empty())
    throw std::runtime_error(
        "'" + path + "' has no 3D scan with a pose" +
        (sensor.empty() ? "" : " and the label '" + sensor + "'") +
        "; check the times in the trajectory and --sensor");
  for (ScanFrame& f : sequence.frames) f.time_s = f.stamp_s - sequence.frames.front().stamp_s;
  return sequence;
}

io::LayerStack read_truth_file(const std::string& path)
{
  return app::guarded(path, app::kCompareWithSource, [&] { return io::read_geotiff(path); });
}

std::vector<GroundTruth> read_labels(const std::string& path, std::size_t points)
{
  constexpr std::uint64_t kMax_bytes = 1ULL << 30;
  const std::string bytes = read_input_file(path, "file of labels", kMax_bytes);
  if (bytes.size() != 4 * points)
    throw std::runtime_error(
        path + ": has " + std::to_string(bytes.size()) + " bytes, and its scan has " +
        std::to_string(points) +
        " points of four bytes each; give the labels of this log, with a file for each of its "
        "scans");
  std::vector<GroundTruth> truth(points);
  for (std::size_t i = 0; i < points; ++i)
  {
    std::uint32_t label = 0;
    for (std::size_t b = 4; b-- > 0;)
      label = label << 8U | static_cast<unsigned char>(bytes[4 * i + b]);
    truth[i] = ground_truth_of(label);
  }
  return truth;
}

std::vector<std::vector<GroundTruth>> read_label_folder(
    const std::string& folder, const Sequence& sequence)
{
  std::error_code none;
  if (!fs::is_directory(folder, none))
    throw std::runtime_error(
        folder + ": is no folder; --labels takes one with a file for each scan, 000000.label ...");
  std::vector<std::vector<GroundTruth>> truth;
  bool has_ground = false;
  for (const ScanFrame& scan : sequence.frames)
  {
    char name[40];
    std::snprintf(name, sizeof name, "%06zu.label", scan.scan);
    truth.push_back(read_labels((fs::path(folder) / name).string(), scan.x_m.size()));
    has_ground |= std::count(truth.back().begin(), truth.back().end(), GroundTruth::Ground) > 0;
  }
  if (!has_ground)
    throw std::runtime_error(
        folder +
        ": no point is labelled as ground: --labels takes the numbers of SemanticKITTI "
        "(road 40, parking 44, sidewalk 48, other ground 49, lane marking 60, terrain 72)");
  return truth;
}

TruthMap truth_from(
    const io::LayerStack& stack, const std::string& path, const Parameters& parameters)
{
  if (std::abs(stack.resolution_m - parameters.resolution_m) > 1e-6)
    throw std::runtime_error(
        "'" + path + "' has cells of " + std::to_string(stack.resolution_m) + " m, the maps of " +
        std::to_string(parameters.resolution_m) + " m; write it again with talus-sim --resolution");
  sim::Truth t;
  t.window = {stack.min_x_m, stack.min_y_m, stack.cells_x, stack.cells_y, parameters.resolution_m};
  t.ground = band(stack, "ground", path);
  t.obstacle_top = band(stack, "obstacle_top", path);
  t.underside = band(stack, "underside", path);
  t.label = band(stack, "label", path);
  t.covered = band(stack, "covered", path);
  t.solid = band(stack, "solid", path);
  return TruthMap(std::move(t), parameters);
}

}  // namespace talus::baselines
