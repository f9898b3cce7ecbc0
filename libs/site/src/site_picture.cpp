#include <talus/site/site_picture.h>

#include "picture_sheet.h"

#include <picture_style.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr int kLegend_px = 600;
constexpr float kPassable = 0.5F;  //!< what is there does not block: it hangs high, or is low
const cv::Vec3b kObstacle(66, 48, 52);
/// @name How much white is in the colours, of 1
/// @{
constexpr float kMild = 0.22F, kPale = 0.62F;  //!< measured, and not
/// @}

cv::Mat3b colours_of_cells(const SiteRaster& r, double pixel_m)
{
  const cv::Mat scale = io::colours_of(io::Palette::Scores);
  const cv::Mat1f shade = hill_shade(r.ground_m, pixel_m);
  cv::Mat3b image(r.ground_m.size(), cv::Vec3b(0, 0, 0));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
    {
      if (r.measured(y, x) == 0) continue;
      const float score = r.score(y, x);
      cv::Vec3b c = std::isnan(score)
                        ? io::not_judged_colour()
                        : scale.at<cv::Vec3b>(cvRound(255 * std::clamp(score, 0.0F, 1.0F)));
      c = mixed(c, kWhite, r.measured(y, x) == 1 ? kPale : kMild);
      const bool blocks = r.obstacle(y, x) != 0 && !(score > kPassable);
      image(y, x) = blocks ? kObstacle : lit(c, shade(y, x));
    }
  return image;
}

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
  const std::string time = time_text(r.newest_s);
  if (!time.empty()) more += ", seen until " + time;
  return {extent, more};
}
}  // namespace

void write_site_picture(const std::string& path, Site& site, int floor, const std::string& title)
{
  const CellBox box = known_box(site, floor);
  if (box.empty())
    throw std::runtime_error(
        path + ": nothing to draw: no cell of floor " + std::to_string(floor) + " is known");
  const RasterPlace place(box, site.resolution_m, kMostPlotPixels);
  const SiteRaster raster(site, floor, place);
  PictureSheet sheet(place, kLegend_px);
  sheet.paint(colours_of_cells(raster, place.pixel_m), raster.measured);
  sheet.draw_ways(site.ways, floor);
  std::string made = "Site map";
  if (floor > 0) made += ", floor " + std::to_string(floor);
  sheet.draw_titles(title.empty() ? made : title, subtitles(site, floor, raster));
  sheet.draw_axes();
  sheet.add_scores();
  sheet.add_swatch(kObstacle, "stands in the way");
  const cv::Vec3b free = io::colours_of(io::Palette::Scores).at<cv::Vec3b>(255);
  sheet.add_swatch(mixed(free, kWhite, kPale), "pale: not measured");
  sheet.add_swatch(mixed(io::not_judged_colour(), kWhite, kPale), "known, not judged");
  sheet.add_swatch(kNotSeen, "not seen");
  if (!site.ways.empty()) sheet.add_ways();
  sheet.add_gap(14);
  sheet.add_scale_bar();
  sheet.add_north(site.origin ? site.origin->heading_deg : 0, site.origin ? "" : "y of the map");
  io::write_png(path, sheet.finish());
}

}  // namespace talus::site
