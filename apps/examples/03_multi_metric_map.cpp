// The map in a CMultiMetricMap, beside a point map: initializers, scans, mapByClass, a costmap.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/obstacles.h>

#include <cstdio>
#include <string>

#include "made_up_scans.h"

namespace
{
const std::string kIni =  // or mrpt::config::CConfigFile("maps.ini")
    "[Maps]\n"
    "pointsMap_count = 1\n"
    "terrain_count   = 1\n"
    "[Maps_terrain_00_creationOpts]\n"
    "resolution = 0.10\n"
    "window     = 12\n"
    "[Maps_terrain_00_insertOpts]\n"
    "clearance_m = 0.6\n";

mrpt::obs::CObservationPointCloud observation(double x_m)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (const auto& p : scan_of_road(x_m)) points->insertPoint(p[0], p[1], p[2]);
  mrpt::obs::CObservationPointCloud obs;
  obs.pointcloud = points;
  obs.sensorPose = mrpt::poses::CPose3D(0, 0, kSensorHeight_m, 0, 0, 0);  // on the robot
  obs.timestamp = mrpt::Clock::now();
  obs.sensorLabel = "lidar";
  return obs;
}
}  // namespace

int main()
{
  mrpt::maps::TSetOfMetricMapInitializers initializers;
  initializers.loadFromConfigFile(mrpt::config::CConfigFileMemory(kIni), "Maps");
  mrpt::maps::CMultiMetricMap maps(initializers);

  mrpt::poses::CPose3D T_map_base;
  for (int i = 0; i < 5; i++)
  {
    T_map_base = mrpt::poses::CPose3D(0.2 * i, 0, 0, 0, 0, 0);
    maps.insertObservation(observation(T_map_base.x()), T_map_base);
  }

  const auto terrain = maps.mapByClass<talus::CDualElevationMap>();
  mrpt::maps::COccupancyGridMap2D costmap;  // for mrpt::nav::PlannerSimple2D
  talus::costmap_from_map(terrain->view(), T_map_base, talus::ObstacleOptions(), costmap);
  std::printf("%zu maps\n", maps.maps.size());
  std::printf("costmap %u x %u cells\n", costmap.getSizeX(), costmap.getSizeY());
  for (const double y_m : {-1.0, 0.5})
    std::printf(
        "free at (2.75, %4.1f): %.2f\n", y_m, costmap.getPos(2.75F, static_cast<float>(y_m)));
}
