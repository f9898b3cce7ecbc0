#include "export_files.h"

#include "../crash_context.h"
#include "export_formats.h"

#include <talus/formats/page.h>
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using namespace talus::formats;
using io::LayerStack;

constexpr const char* kLessMap = "Cut out a part of the map with gdal_translate";

/** One map, as far as a format shows it. */
struct Map
{
  std::string path;
  const io::GeotiffFile& file;
  LayerStack layers;
};

void require_bands(const std::string& path, const std::vector<std::string>& bands)
{
  if (bands.empty())
    throw std::runtime_error(
        path + ": has none of the bands of a map: give a map.tif or site.tif of talus-map");
}

void require_sound_cells_of(const std::string& path, const LayerStack& cells)
{
  try
  {
    require_sound_cells(cells);
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(path + ": " + e.what());
  }
}

/** What a format shows of it, and no more: a band of a large site takes a GB. A page reads it
 * itself, part by part. */
Map read_map(const std::string& path, const io::GeotiffFile& file, const ExportFormat& format)
{
  Map map{path, file, {}};
  if (format.name == "html") return map;
  map.layers = file.read(format.bands);
  require_bands(path, map.layers.names);
  require_sound_cells_of(path, map.layers);
  return map;
}

/** Of these bands, as far as the file has them. */
PageMap page_map_of(
    const std::string& path, const io::GeotiffFile& file, const std::vector<std::string>& bands)
{
  PageMap map{file.place(), {}};
  auto& names = map.place.names;
  const auto is_other = [&](const std::string& name)
  { return std::count(bands.begin(), bands.end(), name) == 0; };
  names.erase(std::remove_if(names.begin(), names.end(), is_other), names.end());
  map.read = [&file, path](int x, int y, int cells_x, int cells_y, const auto& wanted)
  {
    LayerStack part = file.read_part(x, y, cells_x, cells_y, wanted);
    require_sound_cells_of(path, part);
    return part;
  };
  return map;
}

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
    const std::string& path, const Map& map, std::vector<std::string> bands,
    const std::string& title, const ExportOptions& o)
{
  PageOptions page;
  page.title = title;
  for (const char* item : {"STAMP_S", "TALUS_SEEN_S"})  // of a window, of a site
    if (const auto seen_s = number_from(map.file.item(item))) page.date = io::date_text(*seen_s);
  page.ways = ways_of(map);
  page.origin = map.file.origin();
  page.max_bytes = o.max_mb << 20;
  for (const std::string& name : channel_bands(map.file.bands())) bands.push_back(name);
  const PageMap shown = page_map_of(map.path, map.file, bands);
  require_bands(map.path, shown.place.names);
  if (o.changes.empty()) return write_page(path, shown, page);
  const io::GeotiffFile changes(o.changes);
  const PageMap of_changes = page_map_of(o.changes, changes, {"kind", "change_m"});
  page.changes = &of_changes;
  write_page(path, shown, page);
}

/** A note on it; "": none. */
std::string write_as(
    const ExportFormat& as, const std::string& path, const Map& map, const FileOrigin& origin,
    const std::string& title, const ExportOptions& o)
{
  const std::string& format = as.name;
  const LayerStack& m = map.layers;
  if (format == "octomap") return write_octomap(path, m, o.clearance_m, origin);
  if (format == "ros") write_ros_map(path, m, o.ros_mode, o.occupancy);
  if (format == "occupancy") write_occupancy_grid(path, m, o.occupancy);
  if (format == "ply") write_mesh(path, m, o.max_faces, origin);
  if (format == "heightmap") write_heightmap(path, m);
  if (format == "qgis") io::write_qgis_style(path);
  if (format == "html") write_html(path, map, as.bands, title, o);
  return "";
}

/** All files of a format, or none. */
void write_or_report(
    const ExportFormat& format, const std::string& path, const io::GeotiffFile& file,
    const std::string& stem, const std::string& title, const ExportOptions& o, Exported& exported)
{
  const std::string written = stem + format.endings.front();
  try
  {
    const Map map = read_map(path, file, format);
    const FileOrigin origin = o.origin.value_or(origin_for(map.layers));
    const std::string note = write_as(format, written, map, origin, title, o);
    if (!note.empty()) exported.notes.push_back(note);
    if (!o.origin && format.has_origin && (origin.x_m != 0 || origin.y_m != 0))
      exported.notes.push_back(
          written + ": its coordinates are less by " + number_text(origin.x_m) + ", " +
          number_text(origin.y_m) +
          " m, since floats of 32 bit would be rounded: --origin 0,0,0 of "
          "talus-export leaves them as they are");
  }
  catch (const std::exception& e)
  {
    std::error_code none;
    for (const std::string& ending : format.endings) fs::remove(stem + ending, none);
    exported.errors.push_back(failure_text(e, written, kLessMap));
  }
}

std::vector<ExportFormat> formats_of(const ExportOptions& options)
{
  std::vector<ExportFormat> formats;
  for (const ExportFormat& format : export_formats())
    if (std::count(options.formats.begin(), options.formats.end(), format.name) > 0)
      formats.push_back(format);
  return formats;
}

/** All formats of a file of a map. */
void export_file(
    const std::string& path, const std::string& stem, const std::string& title,
    const ExportOptions& o, Exported& exported)
{
  try
  {
    const io::GeotiffFile file(path);
    for (const ExportFormat& format : formats_of(o))
      write_or_report(format, path, file, stem, title, o, exported);
  }
  catch (const std::exception& e)
  {
    exported.errors.push_back(failure_text(e, path, kLessMap));
  }
}
}  // namespace

std::vector<std::string> files_of_map(const std::string& geotiff)
{
  if (!site::is_site(io::GeotiffFile(geotiff))) return {geotiff};
  std::vector<std::string> files;
  for (const site::SitePart& part : site::parts_of_site(geotiff, 0)) files.push_back(part.path);
  return files;
}

std::vector<std::string> files_of_export(
    const std::vector<std::string>& map, const std::string& folder, const ExportOptions& options)
{
  std::vector<std::string> files;
  for (const std::string& file : map)
    for (const ExportFormat& format : formats_of(options))
      for (const std::string& ending : format.endings)
        files.push_back((fs::path(folder) / (fs::path(file).stem().string() + ending)).string());
  return files;
}

void require_exportable(const ExportOptions& options)
{
  const auto& formats = options.formats;
  if (std::count(formats.begin(), formats.end(), "html") > 0) require_leaflet();
}

Exported export_files(
    const std::vector<std::string>& map, const std::string& folder, const std::string& title,
    const ExportOptions& options)
{
  Exported exported;
  const std::size_t named = fs::path(map.front()).stem().string().size();
  for (const std::string& path : map)
  {
    const std::string name = fs::path(path).stem().string();
    export_file(
        path, (fs::path(folder) / name).string(), title + name.substr(named), options, exported);
  }
  return exported;
}

CLI::Option* add_formats(
    CLI::App& app, const std::string& name, ExportOptions& options, const std::string& help)
{
  std::vector<std::string> names;
  for (const ExportFormat& format : export_formats()) names.push_back(format.name);
  return app.add_option(name, options.formats, help)
      ->delimiter(',')
      ->check(
          [](const std::string& format) {
            return format == "gridmap" ? "gridmap: MRPT's occupancy grid is called occupancy" : "";
          })
      ->check(CLI::IsMember(names))
      ->type_name("FORMAT,...");
}

}  // namespace talus::app
