#pragma once
#include "known_cells.h"

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

namespace talus::site
{
/** Where the cells of a box lie on an image, north up, with some room around. */
struct RasterPlace
{
  RasterPlace(const CellBox& box, double resolution_m, int most_pixels);

  int width = 0, height = 0;
  int cells_per_pixel = 1;
  int pixels_per_cell = 1;  //!< when it is drawn
  double pixel_m = 0;  //!< of the raster
  double min_x_m = 0, max_y_m = 0;  //!< its upper left corner

  int row_of(std::int64_t cell_y) const;
  int column_of(std::int64_t cell_x) const;
  /** On the image as it is drawn. */
  cv::Point2d drawn(double x_m, double y_m) const;
  cv::Size drawn_size() const { return {width * pixels_per_cell, height * pixels_per_cell}; }

 private:
  std::int64_t left_cell_, top_cell_;
};

/** What is shown of a floor; unknown is NaN and 0. */
struct SiteRaster
{
  SiteRaster(Site& site, int floor, const RasterPlace& place);

  cv::Mat1f ground_m;  //!< mean
  cv::Mat1f score;  //!< worst traversability
  cv::Mat1b obstacle;  //!< whether something stands there
  cv::Mat1b measured;  //!< 1: only filled, 2: measured
  std::size_t known_cells = 0, measured_cells = 0;
  float lowest_m = INFINITY, highest_m = -INFINITY;  //!< ground
  std::uint32_t newest_s = 0;
};

/** Light from the north-west on a ground, 0..1; 1 - something where the ground is unknown is not
 * defined. Small roughness is smoothed away. */
cv::Mat1f hill_shade(const cv::Mat1f& ground_m, double pixel_m);

}  // namespace talus::site
