#include <talus/site/site_files.h>

#include "picture_sheet.h"

#include <picture_relief.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include <stdexcept>

namespace talus::site
{
namespace
{
std::vector<std::string> subtitles(const Site& site, int floor, const SiteRaster& r)
{
  const double cell_m2 = site.resolution_m * site.resolution_m;
  const double driven_m = length_m(site.ways, floor);
  std::string extent;
  if (driven_m > 0) extent = fixed_text(driven_m, 0) + " m driven, ";
  extent += area_text(static_cast<double>(r.known_cells) * cell_m2) + " known, " +
            area_text(static_cast<double>(r.measured_cells) * cell_m2) + " of it measured";
  const int decimals = r.highest_m - r.lowest_m < 1 ? 2 : 1;
  std::string more = "ground from " + fixed_text(r.lowest_m, decimals) + " to " +
                     fixed_text(r.highest_m, decimals) + " m, cells of " +
                     number_text(site.resolution_m, 3) + " m";
  return {extent, more};
}
void add_legend(io::Legend& legend, bool has_ways)
{
  io::add_terrain(legend);
  if (has_ways) legend.way("path driven: start, end");
}
}  // namespace

void write_site_picture(const std::string& path, Site& site, int floor, const std::string& part)
{
  const CellBox box = known_box(site, floor);
  if (box.empty())
    throw std::runtime_error(
        path + ": nothing to draw: no cell of floor " + std::to_string(floor) + " is known");
  const RasterPlace place(box, page_turn(site, floor), site.resolution_m);
  const SiteRaster raster(site, floor, place);
  PictureSheet sheet(place);
  sheet.paint(io::paint_terrain(raster, place.pixel_m), raster.measured);
  sheet.draw_ways(site.ways, floor);
  add_legend(sheet.legend(), !site.ways.empty());
  sheet.add_scale_and_north(site.origin);
  std::string title = site.name.empty() ? "Whole map" : site.name;
  if (floor > 0) title += ", floor " + std::to_string(floor);
  if (!part.empty()) title += ", " + part;
  const std::string date = io::date_text(raster.newest_s);
  if (!date.empty()) title += ", " + date;
  io::write_png(path, sheet.finish(title, subtitles(site, floor, raster)));
}

}  // namespace talus::site
