#include "export_files.h"

#include "export_formats.h"

#include <talus/formats/page.h>
#include <talus/io/geotiff.h>
#include <talus/io/qgis_style.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
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
  std::string file, stem;
  LayerStack layers;

  std::string path(const char* ending) const { return stem + ending; }
};

Map read_map(const std::string& file, const std::string& folder)
{
  std::vector<std::string> bands = kBands;
  for (const std::string& name : channel_bands(io::bands_of_geotiff(file))) bands.push_back(name);
  Map map{file, (fs::path(folder) / fs::path(file).stem()).string(), io::read_geotiff(file, bands)};
  if (map.layers.layers.empty())
    throw std::runtime_error(
        file + ": has none of the bands of a map: give a map.tif or site.tif of talus-map");
  return map;
}

/** Whether a file is one of a site as it was written: no map of a window, nor a part cut out. */
bool is_site(const std::string& file)
{
  try
  {
    return site::floor_of_site(file) >= 0;
  }
  catch (const std::runtime_error&)
  {
    return false;
  }
}

/** A site has all its floors and islands. */
std::vector<std::string> files_of(const std::string& file)
{
  if (!is_site(file)) return {file};
  std::vector<std::string> files;
  for (const site::SitePart& part : site::parts_of_site(file, 0)) files.push_back(part.path);
  return files;
}

std::vector<std::vector<PagePoint>> ways_of(const Map& map)
{
  std::vector<std::vector<PagePoint>> ways;
  if (!is_site(map.file)) return ways;
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
  page.origin = io::origin_of_geotiff(map.file);
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

std::vector<std::string> files_of_export(
    const std::string& geotiff, const std::string& folder, const ExportOptions& options)
{
  std::vector<std::string> files;
  for (const std::string& file : files_of(geotiff))
    for (const ExportFormat& format : export_formats())
      if (std::count(options.formats.begin(), options.formats.end(), format.name) > 0)
        for (const std::string& ending : format.endings)
          files.push_back((fs::path(folder) / (fs::path(file).stem().string() + ending)).string());
  return files;
}

std::vector<std::string> export_files(
    const std::string& geotiff, const std::string& folder, const std::string& title,
    const ExportOptions& options)
{
  std::vector<std::string> files;
  if (options.formats.empty()) return files;
  for (const std::string& file : files_of(geotiff))
  {
    const Map map = read_map(file, folder);
    const std::string part =
        fs::path(file).stem().string().substr(fs::path(geotiff).stem().string().size());
    for (const std::string& format : options.formats)
      files.push_back(write_as(format, map, title + part, options));
  }
  return files;
}

}  // namespace talus::app
