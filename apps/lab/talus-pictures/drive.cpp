#include "sheet.h"

#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include <picture_legend.h>
#include <picture_relief.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>

namespace talus::pictures
{
namespace
{
const std::vector<std::string> kLayers{"elevation", "ground_elevation", "state", "traversability"};

/** All maps on one grid. */
class Mosaic
{
 public:
  /** Room for these. */
  explicit Mosaic(const std::vector<io::LayerStack>& maps)
  {
    double max_x_m = -std::numeric_limits<double>::infinity(), max_y_m = max_x_m;
    all_ = {0, 0, maps.front().resolution_m, -max_x_m, -max_x_m, kLayers, {}};
    for (const auto& m : maps)
    {
      all_.min_x_m = std::min(all_.min_x_m, m.min_x_m);
      all_.min_y_m = std::min(all_.min_y_m, m.min_y_m);
      max_x_m = std::max(max_x_m, m.min_x_m + m.cells_x * m.resolution_m);
      max_y_m = std::max(max_y_m, m.min_y_m + m.cells_y * m.resolution_m);
    }
    all_.cells_x = cells(max_x_m - all_.min_x_m);
    all_.cells_y = cells(max_y_m - all_.min_y_m);
    const auto count = static_cast<std::size_t>(all_.cells_x) * all_.cells_y;
    for (const auto& name : kLayers)
      all_.layers.emplace_back(
          count, name == "state" ? 0.0F : std::numeric_limits<float>::quiet_NaN());
  }

  /** What a map knows replaces what was there. */
  void add(const io::LayerStack& map)
  {
    const auto& states = *map.find("state");
    const int x0 = cells(map.min_x_m - all_.min_x_m), y0 = cells(map.min_y_m - all_.min_y_m);
    for (std::size_t l = 0; l < kLayers.size(); ++l)
    {
      const auto& from = *map.find(kLayers[l]);
      for (int y = 0; y < map.cells_y; ++y)
        for (int x = 0; x < map.cells_x; ++x)
        {
          const auto i = static_cast<std::size_t>(y) * map.cells_x + x;
          if (states[i] >= 1)
            all_.layers[l][static_cast<std::size_t>(y0 + y) * all_.cells_x + x0 + x] = from[i];
        }
    }
  }

  const io::LayerStack& map() const { return all_; }

 private:
  int cells(double length_m) const
  {
    return static_cast<int>(std::lround(length_m / all_.resolution_m));
  }

  io::LayerStack all_;
};

std::vector<io::LayerStack> read_maps(
    const std::vector<std::string>& files, std::vector<std::string>& names)
{
  std::vector<io::LayerStack> maps;
  for (const std::string& file : files)
  {
    const io::GeotiffFile map(file);
    maps.push_back(map.read());
    names.push_back(
        map.item("LOG") + ", " + io::date_text(number_from(map.item("STAMP_S")).value_or(0)));
    for (const std::string& layer : kLayers)
      if (!maps.back().find(layer)) throw std::runtime_error(file + ": has no layer " + layer);
  }
  if (maps.empty()) throw std::runtime_error("no maps to draw");
  return maps;
}

/** The drive above what its colours mean. */
cv::Mat with_legend(const cv::Mat& drive, const std::string& title)
{
  constexpr int kEdge = 24, kBelow = 74;
  io::Legend legend;
  io::add_terrain(legend);
  legend.way_line(io::palette::kPath.name);
  legend.heading(title);
  io::Canvas page(drive.cols, drive.rows + kBelow);
  page.paste(drive, 0, 0);
  legend.draw(page, {kEdge, drive.rows + 13}, drive.cols - 2 * kEdge);
  return page.image();
}

cv::Point2d middle_of(const io::LayerStack& m)
{
  return {m.min_x_m + m.cells_x * m.resolution_m / 2, m.min_y_m + m.cells_y * m.resolution_m / 2};
}
}  // namespace

void write_drive(
    const std::vector<std::string>& files, const Camera& camera, const std::string& folder)
{
  std::vector<std::string> names;
  const auto maps = read_maps(files, names);
  Mosaic mosaic(maps);
  RobotBox robot;
  std::vector<cv::Point2d> way;
  double driven_m = 0;
  for (std::size_t i = 0; i < maps.size(); ++i)
  {
    mosaic.add(maps[i]);
    robot.at_m = middle_of(maps[i]);
    if (!way.empty())
    {
      const cv::Point2d moved = robot.at_m - way.back();
      driven_m += cv::norm(moved);
      if (cv::norm(moved) > maps[i].resolution_m) robot.yaw_rad = std::atan2(moved.y, moved.x);
    }
    way.push_back(robot.at_m);
    char name[40];
    std::snprintf(name, sizeof name, "/drive_%03zu.png", i);
    io::write_png(
        folder + name, with_legend(
                           draw_oblique(mosaic.map(), camera, way, robot),
                           names[i] + ", " + fixed_text(driven_m, 0) + " m of the drive"));
  }
}

}  // namespace talus::pictures
