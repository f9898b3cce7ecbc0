#include "export_files.h"

#include "../crash_context.h"
#include "export_formats.h"

#include <talus/formats/page.h>
#include <talus/formats/map_strips.h>
#include <talus/io/geotiff.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
using namespace talus::formats;
using io::LayerStack;

constexpr const char* kLessMap = "Cut out a part of the map with gdal_translate";

/** A page reads it part by part. */
PageMap page_map_of(const io::GeotiffFile& file, const LayerStack& frame)
{
  PageMap map{frame, {}};
  map.read = [&file](int x, int y, int cells_x, int cells_y, const auto& wanted)
  {
    LayerStack part = file.read_part(x, y, cells_x, cells_y, wanted);
    require_sound_cells(part, file.path());
    return part;
  };
  return map;
}

/** When its newest cell was seen; nothing where it does not say. */
std::optional<double> seen_s(const io::GeotiffFile& file)
{
  const auto of_site = number_from(file.item("TALUS_SEEN_S"));
  return of_site ? of_site : number_from(file.item("STAMP_S"));  // of a window
}

/** Those that come over the map: a part of it, or one that was moved, tells of all that was driven.
 */
std::vector<std::vector<PagePoint>> ways_of(const io::GeotiffFile& file, const LayerStack& place)
{
  std::vector<std::vector<PagePoint>> ways;
  for (const auto& way : site::ways_of_site(file))
  {
    std::vector<PagePoint> points;
    bool is_here = false;
    for (const site::WayPoint& p : way)
    {
      points.push_back({p.x_m, p.y_m, p.z_m});
      is_here |= p.x_m >= place.min_x_m && p.y_m >= place.min_y_m &&
                 p.x_m <= place.min_x_m + place.cells_x * place.resolution_m &&
                 p.y_m <= place.min_y_m + place.cells_y * place.resolution_m;
    }
    if (is_here) ways.push_back(std::move(points));
  }
  return ways;
}

/** Changes of another site would be none of this one. */
void require_common_place(const LayerStack& a, const LayerStack& b, const std::string& path)
{
  const auto apart = [](double a_m, double a_wide_m, double b_m, double b_wide_m)
  { return a_m + a_wide_m <= b_m || b_m + b_wide_m <= a_m; };
  if (apart(a.min_x_m, a.cells_x * a.resolution_m, b.min_x_m, b.cells_x * b.resolution_m) ||
      apart(a.min_y_m, a.cells_y * a.resolution_m, b.min_y_m, b.cells_y * b.resolution_m))
    throw std::runtime_error(path + ": lies elsewhere than this map: are these changes of it?");
}

void write_html(
    const std::string& path, const io::GeotiffFile& file, std::vector<std::string> bands,
    const std::string& title, const ExportOptions& o)
{
  PageOptions page;
  page.title = title;
  if (const auto stamp_s = seen_s(file)) page.date = io::date_text(*stamp_s);
  page.origin = file.origin();
  page.max_bytes = o.max_mb << 20;
  for (const std::string& name : channel_bands(file.bands())) bands.push_back(name);
  const PageMap shown = page_map_of(file, MapStrips(file, bands).frame());
  page.ways = ways_of(file, shown.place);
  if (o.changes.empty()) return write_page(path, shown, page);
  const io::GeotiffFile changes(o.changes);
  LayerStack frame = changes.frame();
  frame.names = changes.bands();
  const PageMap of_changes = page_map_of(changes, frame);
  require_common_place(shown.place, of_changes.place, o.changes);
  page.changes = &of_changes;
  write_page(path, shown, page);
}

/** A note on it; "": none. */
std::string write_as(
    const std::string& format, const std::string& path, const io::GeotiffFile& file,
    const MapStrips& m, const FileOrigin& origin, const ExportOptions& o)
{
  if (format == "octomap") return write_octomap(path, m, o.clearance_m, origin);
  if (format == "gridmap") return write_grid_map(path, m, seen_s(file).value_or(0));
  if (format == "ros") write_ros_map(path, m, o.ros_mode, o.occupancy);
  if (format == "occupancy") write_occupancy_grid(path, m, o.occupancy, origin);
  if (format == "ply") write_mesh(path, m, o.max_faces, origin);
  if (format == "heightmap") write_heightmap(path, m);
  if (format == "qgis") io::write_qgis_style(path);
  return "";
}

/** All files of a format, or none. */
void write_or_report(
    const ExportFormat& format, const io::GeotiffFile& file, const std::string& stem,
    const std::string& title, const ExportOptions& o, Exported& exported)
{
  const std::string written = stem + format.endings.front();
  try
  {
    if (format.name == "html") return write_html(written, file, format.bands, title, o);
    const MapStrips map(file, format.bands);
    const FileOrigin origin = o.origin.value_or(origin_for(map.frame()));
    const std::string note = write_as(format.name, written, file, map, origin, o);
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
      write_or_report(format, file, stem, title, o, exported);
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
      ->check(CLI::IsMember(names))
      ->type_name("FORMAT,...");
}

}  // namespace talus::app
