#pragma once
#include "known_cells.h"

#include <picture_relief.h>

#include <cstdint>
#include <vector>

namespace talus::site
{
/** How a map lies on its page: north up, or turned where that leaves much less of it empty. */
struct PageTurn
{
  double turn_rad = 0;  //!< of the map on the page, counter-clockwise, at most 45 degrees
  /** What is to be seen, in cells of the turned map: x to the right, y upwards. */
  double min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};

PageTurn page_turn(Site& site, int floor);

/** Where the cells of a floor lie on a raster, north up, and where that lies on a page. */
struct RasterPlace
{
  RasterPlace(const CellBox& box, const PageTurn& turn, double resolution_m);

  int width = 0, height = 0;  //!< of the raster
  int cells_per_pixel = 1;
  int pixels_per_cell = 1;  //!< of the page, for a pixel of the raster
  double pixel_m = 0;  //!< of the raster
  double turn_rad = 0;
  cv::Size page;

  int row_of(std::int64_t cell_y) const;
  int column_of(std::int64_t cell_x) const;
  bool contains(const cv::Point& p) const { return cv::Rect(0, 0, width, height).contains(p); }
  /** On the page, of a place of the map [m]. */
  cv::Point2d drawn(double x_m, double y_m) const;
  /** And back. */
  cv::Point2d place_of(const cv::Point2d& drawn) const;
  double page_px_per_m() const { return pixels_per_cell / pixel_m; }
  /** An image of the raster on the page. */
  cv::Mat on_page(const cv::Mat& raster, int interpolation) const;

 private:
  cv::Matx23d page_from_map() const;

  std::int64_t left_cell_, top_cell_;
  double page_left_m_, page_top_m_;  //!< of the turned map
};

/** What is shown of a floor. */
struct SiteRaster : io::Terrain
{
  SiteRaster(Site& site, int floor, const RasterPlace& place);

  std::size_t known_cells = 0, measured_cells = 0;
  float lowest_m = INFINITY, highest_m = -INFINITY;  //!< ground
  std::uint32_t newest_s = 0;
};

}  // namespace talus::site
