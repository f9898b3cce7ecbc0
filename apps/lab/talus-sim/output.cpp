#include "output.h"

#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3DQuat.h>
#include <talus/io/atomic_file.h>
#include <talus/io/geotiff.h>
#include <talus/io/packed_log.h>
#include <talus/mrpt/observation_points.h>
#include <talus/mrpt/version_compat.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace talus::sim
{
namespace
{
/** Stamp of a frame: whole microseconds, so that texts hold it exactly. */
mrpt::Clock::time_point stamp_of(const Drive& drive, int frame)
{
  const auto since_start = std::chrono::microseconds(std::llround(drive.time_s(frame) * 1e6));
  return mrpt::Clock::fromDouble(kFirstStamp_s) + since_start;
}

mrpt::poses::CPose3D claimed_mounting(const SensorSetup& sensor, const Claims& claims)
{
  const auto T = to_mrpt(sensor.T_base_sensor);
  const app::Mounting e = claims.mounting_error.value_or(app::Mounting{});
  return {
      T.x() + e[0],
      T.y() + e[1],
      T.z() + e[2],
      T.yaw() + radians(e[3]),
      T.pitch() + radians(e[4]),
      T.roll() + radians(e[5])};
}

mrpt::obs::CObservationPointCloud observation(
    const World& world, const Drive& drive, const Claims& claims, int frame)
{
  const Scan scan = drive.scan(frame);
  const auto points = talus::detail::make_cloud_with_intensity(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i)
  {
    points->setPointFast(i, scan.x_m[i], scan.y_m[i], scan.z_m[i]);
    talus::detail::set_intensity(*points, i, scan.intensity[i]);
  }
  mrpt::obs::CObservationPointCloud obs;
  obs.pointcloud = points;
  const SensorSetup& sensor = world.sensors[drive.sensor(frame)];
  obs.sensorLabel = sensor.name;
  obs.sensorPose = claimed_mounting(sensor, claims);
  obs.timestamp =
      stamp_of(drive, frame) + std::chrono::microseconds(std::llround(claims.clock_error_s * 1e6));
  return obs;
}

}  // namespace

void write_rawlog(
    const std::string& path, const World& world, const Drive& drive, const Claims& claims,
    const std::function<void(int)>& progress)
{
  io::PackedLog log(path);
  for (int i = 0; i < drive.frames(); ++i)
  {
    log.write(observation(world, drive, claims, i));
    progress(i + 1);
  }
  log.close();
}

void write_tum(const std::string& path, const Drive& drive, bool noisy)
{
  std::string text = "# t[s] x[m] y[m] z[m] qx qy qz qw of the base in the map\n";
  for (int i = 0; i < drive.frames(); ++i)
  {
    if (i > 0 && stamp_of(drive, i) == stamp_of(drive, i - 1)) continue;  // of another sensor
    const mrpt::poses::CPose3DQuat p(
        to_mrpt(noisy ? drive.T_map_base_noisy(i) : drive.T_map_base(i)));
    const auto& q = p.quat();
    char line[256];
    std::snprintf(
        line, sizeof(line), "%.6f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
        mrpt::Clock::toDouble(stamp_of(drive, i)), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.r());
    text += line;
  }
  io::write_file(path, text);
}

void write_truth(const std::string& path, Truth truth, const World& world, double time_s)
{
  io::LayerStack stack;
  stack.cells_x = truth.window.cells_x;
  stack.cells_y = truth.window.cells_y;
  stack.resolution_m = truth.window.resolution_m;
  stack.min_x_m = truth.window.min_x_m;
  stack.min_y_m = truth.window.min_y_m;
  stack.names = {"ground", "obstacle_top", "underside", "label", "covered", "solid"};
  for (auto* layer :
       {&truth.ground, &truth.obstacle_top, &truth.underside, &truth.label, &truth.covered,
        &truth.solid})
    stack.layers.push_back(std::move(*layer));
  io::write_geotiff(path, stack, {{"world", world.name}, {"time_s", std::to_string(time_s)}});
}

}  // namespace talus::sim
