// A whole drive as one map, and a query far back on it, where the window has long left.
#include <talus/interleaved_points.h>
#include <talus/map_view.h>
#include <talus/site/floor_map.h>
#include <talus/site/site_files.h>
#include <talus/site/site_mapper.h>

#include <cstdio>
#include <filesystem>

#include "made_up_scans.h"

int main(int argc, char** argv)
{
  talus::Parameters parameters;
  parameters.resolution_m = 0.1;
  talus::ElevationMapper map(parameters);
  talus::site::Site site(parameters.resolution_m, 64 << 20, ".");  // 64 MB, then files in "."
  talus::site::SiteMapper mapper(site);
  talus::InterleavedPoints points;
  double x_m = 0;
  for (int i = 0; i <= 100; i++)
  {
    x_m = 0.3 * i;
    const Cloud cloud = scan_of_road(x_m);
    talus::Frame frame = points.frame(cloud.data(), cloud.size());
    frame.stamp_s = 0.1 * i;
    frame.T_map_sensor.m[3] = x_m;
    frame.T_map_sensor.m[11] = kSensorHeight_m;
    mapper.update(map, frame);  // instead of map.update(frame)
  }
  mapper.keep_window(map);  // at the end, and before a query
  mapper.look_back(map);  // at the end: what moved is no obstacle

  constexpr int kMaxCells = 4096;  // along a side of the map of a floor
  talus::site::FloorMap floor;
  const talus::MapView whole = floor.update(site, mapper.floor(), parameters, kMaxCells, x_m, 0);
  for (const double back_m : {27.2, 26.0})
    std::printf(
        "%.1f m back: window %.1f, whole drive %.1f\n", back_m,
        talus::MapView(map).at(talus::Layer::Traversability, x_m - back_m, 0.5),
        whole.at(talus::Layer::Traversability, x_m - back_m, 0.5));
  if (argc < 2) return 0;
  std::filesystem::path picture = argv[1];  // "site.tif", for talus-map --resume
  talus::site::write_site_files(argv[1], picture.replace_extension(".png").string(), site);
}
