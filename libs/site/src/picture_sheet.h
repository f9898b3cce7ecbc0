#pragma once
#include "site_raster.h"

#include <picture_canvas.h>
#include <picture_legend.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::site
{
/** What is the same on all pictures of a site: paper, axes, title, and a legend: below a map that
 * is wide, right of one that is high. */
class PictureSheet
{
 public:
  explicit PictureSheet(const RasterPlace& place);

  /** `cells`: a colour for each pixel of the raster, kept where `known` is not 0. */
  void paint(const cv::Mat3b& cells, const cv::Mat1b& known);
  /** Those points of each way that are on the floor. */
  void draw_ways(const std::vector<std::vector<WayPoint>>& ways, int floor);
  /** To which all that the colours mean is added. */
  io::Legend& legend() { return legend_; }
  /** Length and, where the axes do not show it, north; last. */
  void add_scale_and_north(const std::optional<GeoOrigin>& origin);
  /** The page; the lines stand below the title. */
  cv::Mat finish(const std::string& title, const std::vector<std::string>& lines);

 private:
  int px(double unscaled) const;
  std::vector<double> x_ticks() const;
  std::vector<double> y_ticks() const;
  void draw_grid();
  void draw_titles(
      io::Canvas& page, const std::string& title, const std::vector<std::string>& lines) const;
  void draw_axes(io::Canvas& page, const cv::Rect& plot) const;
  /** Where the line x = t (or y = t) of the map meets the lower (or left) edge; NaN: nowhere. */
  double on_edge(bool is_x, double t) const;

  RasterPlace place_;
  double scale_;  //!< of text and marks
  io::Canvas map_;
  io::Legend legend_;
  double least_x_m_, most_x_m_, least_y_m_, most_y_m_;  //!< on the page
};

/** Driven on a floor. */
double length_m(const std::vector<std::vector<WayPoint>>& ways, int floor);
/** "12.3 m2", with as many digits as matter. */
std::string area_text(double area_m2);

}  // namespace talus::site
