#pragma once
#include "site_raster.h"

#include <picture_canvas.h>

#include <functional>
#include <string>
#include <vector>

namespace talus::site
{
constexpr int kMostPlotPixels = 1340;  //!< the long side of the map alone

inline const cv::Vec3b kWhite(255, 255, 255), kNotSeen(236, 238, 240);  //!< BGR

/** Of two colours. */
cv::Vec3b mixed(const cv::Vec3b& a, const cv::Vec3b& b, float part_b);
/** A colour in a light as hill_shade() tells it: level ground keeps its colour. */
cv::Vec3b lit(const cv::Vec3b& colour, float shade);

/** What is the same on all pictures of a site: paper, axes, title, and a column at the right. */
class PictureSheet
{
 public:
  /** The map is drawn in the size of `place`; the column has room for `legend_px` pixels. */
  PictureSheet(const RasterPlace& place, int legend_px);

  /** `cells`: a colour for each pixel of the raster, kept where `known` is not 0. */
  void paint(const cv::Mat3b& cells, const cv::Mat1b& known);
  /** Those points of each way that are on the floor. */
  void draw_ways(const std::vector<std::vector<WayPoint>>& ways, int floor);
  /** Below the title: two lines at most. */
  void draw_titles(const std::string& title, const std::vector<std::string>& lines);
  void draw_axes();

  /** @name The column, from its top downwards @{ */
  void add_heading(const std::string& text);
  void add_swatch(const cv::Vec3b& colour, const std::string& words);
  void add_scores();  //!< the scale of traversability
  void add_ways();
  void add_scale_bar();
  /** `heading_deg`: of the x axis, counter-clockwise from east. */
  void add_north(double heading_deg, const std::string& words);
  void add_gap(int pixels) { next_y_ += pixels; }
  /** @} */

  /** Puts the map onto the paper and gives all, as high as map and column need. */
  cv::Mat finish();

 private:
  RasterPlace place_;
  cv::Rect plot_;
  io::Canvas canvas_;
  cv::Mat3b map_;
  int next_y_;
};

/** Driven on a floor. */
double length_m(const std::vector<std::vector<WayPoint>>& ways, int floor);
/** "12.3 m2", with as many digits as matter. */
std::string area_text(double area_m2);
/** Day and minute in UTC where the clock is one since 1970, else empty. */
std::string time_text(std::uint32_t seen_s);

}  // namespace talus::site
