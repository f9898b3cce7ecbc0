#pragma once
#include <site_reader.h>

#include <opencv2/core.hpp>

namespace talus::align
{
/** Pixels on the ground; row 0 is the southernmost. */
struct Grid
{
  double min_x_m = 0, min_y_m = 0, pixel_m = 0;
  int width = 0, height = 0;

  /** In pixels; the middle of pixel (i, k) is at (i, k). */
  cv::Point2d at(double x_m, double y_m) const
  {
    return {(x_m - min_x_m) / pixel_m - 0.5, (y_m - min_y_m) / pixel_m - 0.5};
  }
  cv::Point2d place_m(int column, int row) const
  {
    return {min_x_m + (column + 0.5) * pixel_m, min_y_m + (row + 0.5) * pixel_m};
  }
};

/** What is measured of one or several maps, on a grid. */
class Sketch
{
 public:
  explicit Sketch(const Grid& grid);

  /** Adds a map. Throws as SiteReader. */
  void add(site::MovedReader& map);

  const Grid& grid() const { return grid_; }
  const cv::Mat1f& ground_m() const { return ground_m_; }  //!< mean; NaN where none is measured
  const cv::Mat1b& stands() const { return stands_; }  //!< 1 where something does

 private:
  void add(std::int64_t cell_x, std::int64_t cell_y, double resolution_m, const site::SiteCell& s);

  Grid grid_;
  cv::Mat1f ground_m_, count_;
  cv::Mat1b stands_;
};

}  // namespace talus::align
