// A room, what a sensor sees of it, and the map of it: shared by the specifications of the MRPT
// map.
#pragma once
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <cmath>
#include <vector>

namespace talus_test
{
using mrpt::maps::CSimplePointsMap;
using mrpt::math::TPoint3D;
using mrpt::obs::CObservationPointCloud;
using mrpt::poses::CPose3D;
using talus::CDualElevationMap;
using talus::Layer;

inline CObservationPointCloud cloud(
    const std::vector<TPoint3D>& p_sensor, const CPose3D& T_base_sensor)
{
  CObservationPointCloud obs;
  auto points = CSimplePointsMap::Create();
  for (const auto& p : p_sensor)
    points->insertPoint(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  obs.pointcloud = points;
  obs.sensorPose = T_base_sensor;
  obs.timestamp = mrpt::Clock::fromDouble(1000.0);
  obs.sensorLabel = "lidar";
  return obs;
}

/** The outside of a box that stands on z = 0: its four sides and its top [m, map]. */
inline void add_box(
    std::vector<TPoint3D>& world, double x0, double x1, double y0, double y1, double top)
{
  const double step = 0.03;
  for (double x = x0; x <= x1; x += step)
    for (double y = y0; y <= y1; y += step) world.emplace_back(x, y, top);
  for (double z = 0.02; z < top; z += step)
  {
    for (double x = x0; x <= x1; x += step)
      world.insert(world.end(), {TPoint3D(x, y0, z), TPoint3D(x, y1, z)});
    for (double y = y0; y <= y1; y += step)
      world.insert(world.end(), {TPoint3D(x0, y, z), TPoint3D(x1, y, z)});
  }
}

/** A floor with two boxes, around the origin [m, map]. Their sides lie off the borders of cells. */
inline std::vector<TPoint3D> room()
{
  std::vector<TPoint3D> world;
  const auto inside = [](double x, double y)
  {
    return (x > 1.02 && x < 1.63 && std::abs(y) < 0.52) ||
           (x > -0.98 && x < 0.23 && y > 1.22 && y < 1.73);
  };
  for (double x = -2.5; x < 2.5; x += 0.04)
    for (double y = -2.5; y < 2.5; y += 0.04)
      if (!inside(x, y)) world.emplace_back(x, y, 0.0);
  add_box(world, 1.02, 1.63, -0.52, 0.52, 0.45);
  add_box(world, -0.98, 0.23, 1.22, 1.73, 0.3);
  return world;
}

inline const CPose3D kT_base_sensor(0.1, 0.0, 0.7, 0.2, 0.05, -0.02);

/** What a sensor on the robot sees of the room, without noise. */
inline CObservationPointCloud scan_of_room(const CPose3D& T_map_base)
{
  const CPose3D T_map_sensor = T_map_base + kT_base_sensor;
  std::vector<TPoint3D> p_sensor;
  for (const auto& p : room()) p_sensor.push_back(T_map_sensor.inverseComposePoint(p));
  return cloud(p_sensor, kT_base_sensor);
}

inline talus::Parameters small_window()
{
  talus::Parameters p;
  p.window_m = 6;
  p.min_height_m = -3;
  p.max_height_m = 3;
  return p;
}

inline CDualElevationMap map_of_room(int frames = 3)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  for (int i = 0; i < frames; i++)
  {
    const CPose3D pose(0.03 * i, -0.02 * i, 0, 0.1 * i, 0, 0);
    EXPECT_TRUE(map.insertObservation(scan_of_room(pose), pose));
  }
  return map;
}

/** Of the window, also where the whole is kept. */
inline float at(const CDualElevationMap& map, Layer layer, double x, double y)
{
  return talus::MapView(map.mapper()).at(layer, x, y);
}

}  // namespace talus_test
