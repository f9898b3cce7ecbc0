#include "export_files.h"

#include <talus/formats/page.h>
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/site/site_geotiff.h>

#include <filesystem>
#include <stdexcept>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using namespace talus::formats;
using io::LayerStack;

const std::vector<std::string> kBands{"traversability", "ground_elevation", "elevation", "state",
                                      "reached",        "sparsity",         "age"};

/** One map, and how its files begin. */
struct Map
{
  Map(const std::string& path, const std::string& folder)
      : file(path), stem((fs::path(folder) / fs::path(path).stem()).string())
  {
    std::vector<std::string> bands = kBands;
    for (const std::string& name : channel_bands(file.bands())) bands.push_back(name);
    layers = file.read(bands);
    if (layers.layers.empty())
      throw std::runtime_error(
          path + ": has none of the bands of a map: give a map.tif or site.tif of talus-map");
  }

  io::GeotiffFile file;
  std::string stem;
  LayerStack layers;

  std::string path(const char* ending) const { return stem + ending; }
};

std::vector<std::vector<PagePoint>> ways_of(const Map& map)
{
  std::vector<std::vector<PagePoint>> ways;
  for (const auto& way : site::ways_of_site(map.file))
  {
    auto& points = ways.emplace_back();
    for (const site::WayPoint& p : way) points.push_back({p.x_m, p.y_m, p.z_m});
  }
  return ways;
}

void write_html(
    const std::string& path, const Map& map, const std::string& title, const ExportOptions& o)
{
  PageOptions page;
  page.title = title;
  page.ways = ways_of(map);
  page.origin = map.file.origin();
  page.max_bytes = o.max_mb << 20;
  LayerStack changes;
  if (!o.changes.empty())
  {
    changes = io::read_geotiff(o.changes);
    page.changes = &changes;
  }
  write_page(path, map.layers, page);
}

std::string write_as(
    const std::string& format, const Map& map, const std::string& title, const ExportOptions& o)
{
  const auto written = [&map](const char* ending, const auto& write)
  {
    std::string path = map.path(ending);
    write(path, map.layers);
    return path;
  };
  if (format == "ros")
    return written(
        ".yaml", [&](auto& p, auto& m) { write_ros_map(p, m, o.ros_mode, o.blocked_at); });
  if (format == "gridmap")
    return written(".gridmap.gz", [&](auto& p, auto& m) { write_gridmap(p, m, o.blocked_at); });
  if (format == "octomap")
    return written(".bt", [&](auto& p, auto& m) { write_octomap(p, m, o.clearance_m); });
  if (format == "ply")
    return written(".ply", [&](auto& p, auto& m) { write_mesh(p, m, o.max_faces); });
  if (format == "heightmap")
    return written("_height.png", [](auto& p, auto& m) { write_heightmap(p, m); });
  if (format == "qgis") return written(".qml", [](auto& p, auto&) { io::write_qgis_style(p); });
  return written(".html", [&](auto& p, auto&) { write_html(p, map, title, o); });
}
}  // namespace

std::vector<std::string> export_files(
    const std::string& geotiff, const std::string& folder, const std::string& title,
    const ExportOptions& options)
{
  std::vector<std::string> files;
  if (options.formats.empty()) return files;
  const Map map(geotiff, folder);
  for (const std::string& format : options.formats)
    files.push_back(write_as(format, map, title, options));
  return files;
}

}  // namespace talus::app
