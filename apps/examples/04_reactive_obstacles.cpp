// Obstacles for MRPT's reactive navigators. A whole robot between map and navigator: my_robot.h.
#include <mrpt/maps/CSimplePointsMap.h>
#include <talus/interleaved_points.h>
#include <talus/mrpt/obstacles.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "made_up_scans.h"

int main()
{
  talus::ElevationMapper map;
  talus::InterleavedPoints points;
  mrpt::poses::CPose3D T_map_base;
  for (int i = 0; i < 10; i++)
  {
    T_map_base = mrpt::poses::CPose3D(0.1 * i, 0, 0, 0, 0, 0);
    const Cloud cloud = scan_of_road(T_map_base.x());
    talus::Frame frame = points.frame(cloud.data(), cloud.size());
    frame.T_base_sensor.emplace().m[11] = kSensorHeight_m;
    frame.T_map_sensor.m[3] = T_map_base.x();
    frame.T_map_sensor.m[11] = kSensorHeight_m;
    map.update(frame);
  }

  // What CRobot2NavInterface::senseObstacles() does:
  talus::ObstacleOptions options;
  options.unseen = talus::Unseen::Free;  // else what was not seen near by is an obstacle
  mrpt::maps::CSimplePointsMap obstacles;  // frame of the robot, x ahead
  talus::obstacles_2d(map, T_map_base, options, obstacles);

  double nearest_m = INFINITY, x_m = 0, y_m = 0;
  for (std::size_t i = 0; i < obstacles.size(); i++)
  {
    float x, y, z;
    obstacles.getPoint(i, x, y, z);
    if (std::hypot(x, y) >= nearest_m) continue;
    nearest_m = std::hypot(x, y);
    x_m = x;
    y_m = y;
  }
  std::printf("%s obstacles\n", obstacles.empty() ? "no" : "some");
  std::printf("nearest %.1f m away, %.1f m ahead, %.1f m to the left\n", nearest_m, x_m, y_m);
}
