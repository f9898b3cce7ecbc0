// A map from a point cloud.
#include <talus/interleaved_points.h>
#include <talus/map_view.h>

#include <array>
#include <cstdio>
#include <vector>

int main()
{
  // A floor 0.7 m below the sensor, and a block on it [m, frame of the sensor].
  std::vector<std::array<float, 3>> cloud;
  for (int x = -80; x < 80; x++)
    for (int y = -80; y < 80; y++)
    {
      const bool is_block = x >= 40 && x < 50 && y >= -10 && y < 10;
      cloud.push_back({0.04F * x, 0.04F * y, is_block ? -0.3F : -0.7F});
    }

  talus::InterleavedPoints points;
  talus::Frame frame = points.frame(cloud.data(), cloud.size(), sizeof(cloud[0]));
  frame.T_map_sensor.m[11] = 0.7;  // the pose of the sensor: 0.7 m above the origin of the map
  talus::ElevationMapper map;
  map.update(frame);

  using talus::Layer;
  const talus::MapView view(map);
  for (const double x_m : {1.0, 1.8, 50.0})
    std::printf(
        "x = %4.1f m: ground %.2f m, top %.2f m, traversability %.1f\n", x_m,
        view.at(Layer::GroundElevation, x_m, 0), view.at(Layer::Elevation, x_m, 0),
        view.at(Layer::Traversability, x_m, 0));
}
