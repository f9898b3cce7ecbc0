#include "site_raster.h"

#include "known_cells.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::site
{
namespace
{
constexpr double kRoom = 0.015;  //!< around what is seen, of its longer side
constexpr double kMinRoom_m = 0.3;
/// @name Pixels of a page
/// @{
constexpr double kMaxLong_px = 3000, kMaxArea_px = 6e6;
constexpr double kWanted_px = 1200;  //!< its long side, where there are few cells
constexpr int kMaxPerCell_px = 8;
/// @}

int cells_per_pixel_of(double width_cells, double height_cells)
{
  const double by_length = std::max(width_cells, height_cells) / kMaxLong_px;
  const double by_area = std::sqrt(width_cells * height_cells / kMaxArea_px);
  return std::max(1, static_cast<int>(std::ceil(std::max(by_length, by_area))));
}

cv::Matx22d turning(double rad)
{
  return {std::cos(rad), -std::sin(rad), std::sin(rad), std::cos(rad)};
}
}  // namespace

RasterPlace::RasterPlace(const CellBox& box, const PageTurn& turn, double resolution_m)
    : turn_rad(turn.turn_rad)
{
  const double longest = std::max(turn.max_x - turn.min_x, turn.max_y - turn.min_y);
  const double room = std::ceil(std::max(kRoom * longest, kMinRoom_m / resolution_m));
  const double wide = turn.max_x - turn.min_x + 2 * room;
  const double high = turn.max_y - turn.min_y + 2 * room;
  cells_per_pixel = cells_per_pixel_of(wide, high);
  if (cells_per_pixel == 1)
    pixels_per_cell =
        std::clamp(static_cast<int>(kWanted_px / std::max(wide, high)), 1, kMaxPerCell_px);
  pixel_m = cells_per_pixel * resolution_m;
  // Not turned, the raster is the page, and cells fall on whole pixels.
  const bool is_turned = turn_rad != 0;
  const auto margin = is_turned ? std::int64_t{2} : static_cast<std::int64_t>(room);
  left_cell_ = box.min_x - margin;
  top_cell_ = box.max_y + margin;
  width = column_of(box.max_x + margin) + 1;
  height = row_of(box.min_y - margin) + 1;
  page_left_m_ = (is_turned ? turn.min_x - room : static_cast<double>(left_cell_)) * resolution_m;
  page_top_m_ = (is_turned ? turn.max_y + room : static_cast<double>(top_cell_ + 1)) * resolution_m;
  const double px_per_cell = static_cast<double>(pixels_per_cell) / cells_per_pixel;
  page = is_turned ? cv::Size(cvCeil(wide * px_per_cell), cvCeil(high * px_per_cell))
                   : cv::Size(width * pixels_per_cell, height * pixels_per_cell);
}

int RasterPlace::column_of(std::int64_t cell_x) const
{
  return static_cast<int>((cell_x - left_cell_) / cells_per_pixel);
}
int RasterPlace::row_of(std::int64_t cell_y) const
{
  return static_cast<int>((top_cell_ - cell_y) / cells_per_pixel);
}

cv::Point2d RasterPlace::drawn(double x_m, double y_m) const
{
  const cv::Vec2d turned = turning(turn_rad) * cv::Vec2d(x_m, y_m);
  return cv::Point2d(turned[0] - page_left_m_, page_top_m_ - turned[1]) * page_px_per_m();
}

cv::Point2d RasterPlace::place_of(const cv::Point2d& drawn) const
{
  const cv::Point2d turned_m(
      page_left_m_ + drawn.x / page_px_per_m(), page_top_m_ - drawn.y / page_px_per_m());
  return cv::Point2d(turning(-turn_rad) * cv::Vec2d(turned_m.x, turned_m.y));
}

cv::Mat RasterPlace::on_page(const cv::Mat& raster, int interpolation) const
{
  cv::Mat image;
  cv::resize(raster, image, {}, pixels_per_cell, pixels_per_cell, cv::INTER_NEAREST);
  if (turn_rad == 0) return image;
  // From where the corners of the raster lie on the page.
  const double resolution_m = pixel_m / cells_per_pixel;
  const double left_m = static_cast<double>(left_cell_) * resolution_m;
  const double top_m = static_cast<double>(top_cell_ + 1) * resolution_m;
  const cv::Point2f raster_corners[3]{
      {-0.5F, -0.5F},
      {static_cast<float>(image.cols) - 0.5F, -0.5F},
      {-0.5F, static_cast<float>(image.rows) - 0.5F}};
  const cv::Point2d half(0.5, 0.5);
  const cv::Point2f page_corners[3]{
      drawn(left_m, top_m) - half, drawn(left_m + width * pixel_m, top_m) - half,
      drawn(left_m, top_m - height * pixel_m) - half};
  cv::Mat turned;
  cv::warpAffine(
      image, turned, cv::getAffineTransform(raster_corners, page_corners), page, interpolation,
      cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return turned;
}

SiteRaster::SiteRaster(Site& site, int floor, const RasterPlace& place)
    : io::Terrain{
          cv::Mat1f(place.height, place.width, 0.0F),
          cv::Mat1f(place.height, place.width, std::numeric_limits<float>::quiet_NaN()),
          cv::Mat1b(place.height, place.width, uchar{0}),
          cv::Mat1b(place.height, place.width, uchar{0})}
{
  cv::Mat1f count(place.height, place.width, 0.0F);
  cv::Mat1b unreached(place.height, place.width, uchar{0});
  bool any_reached = false;
  for_each_known(
      site, floor,
      [&](std::int64_t x, std::int64_t y, const SiteCell& s)
      {
        const CellRecord& c = s.cell;
        const cv::Point at(place.column_of(x), place.row_of(y));
        const bool measures = is_measured(s);
        ++known_cells;
        measured_cells += measures ? 1 : 0;
        lowest_m = std::min(lowest_m, c.ground_m);
        highest_m = std::max(highest_m, c.ground_m);
        newest_s = std::max(newest_s, s.seen_s);
        count(at) += 1;
        ground_m(at) += (c.ground_m - ground_m(at)) / count(at);  // the mean
        score(at) = std::fmin(score(at), c.traversability);  // the worst
        const bool reached = is_reached(c);
        any_reached |= reached;
        if (measures && !reached) unreached(at) = 1;
        measured(at) = std::max(measured(at), static_cast<uchar>(measures && reached ? 2 : 1));
        if (c.elevation_m - c.ground_m > io::kMinObstacle_m) obstacle(at) = 1;
      });
  if (!any_reached) measured.setTo(2, unreached);  // nothing was known around the robot
  ground_m.setTo(std::numeric_limits<float>::quiet_NaN(), measured == 0);
}

}  // namespace talus::site
