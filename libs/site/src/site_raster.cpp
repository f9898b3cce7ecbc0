#include "site_raster.h"

#include "cell_evidence.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::site
{
namespace
{
constexpr double kRoom = 0.03;  //!< around the box, of its longer side
constexpr double kLeastRoom_m = 0.3;
constexpr double kLeastObstacle_m = 0.05;  //!< lower than that it is a rough ground
constexpr double kSmoothed_m = 0.15;  //!< standard deviation, against the noise of single cells
constexpr float kSteepness = 3;  //!< heights are shown so many times as high

int most_pixels_per_cell(std::int64_t cells, int most_pixels)
{
  return static_cast<int>(std::clamp<std::int64_t>(most_pixels / cells, 1, 8));
}
}  // namespace

RasterPlace::RasterPlace(const CellBox& box, double resolution_m, int most_pixels)
{
  const std::int64_t longest = std::max(box.max_x - box.min_x, box.max_y - box.min_y) + 1;
  const auto room = static_cast<std::int64_t>(
      std::ceil(std::max(kRoom * static_cast<double>(longest), kLeastRoom_m / resolution_m)));
  const std::int64_t cells = longest + 2 * room;
  cells_per_pixel = static_cast<int>((cells + most_pixels - 1) / most_pixels);
  pixels_per_cell = most_pixels_per_cell(cells, most_pixels);
  pixel_m = cells_per_pixel * resolution_m;
  left_cell_ = box.min_x - room;
  top_cell_ = box.max_y + room;
  width = column_of(box.max_x + room) + 1;
  height = row_of(box.min_y - room) + 1;
  min_x_m = static_cast<double>(left_cell_) * resolution_m;
  max_y_m = static_cast<double>(top_cell_ + 1) * resolution_m;
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
  const double scale = pixels_per_cell / pixel_m;
  return {(x_m - min_x_m) * scale, (max_y_m - y_m) * scale};
}

SiteRaster::SiteRaster(Site& site, int floor, const RasterPlace& place)
    : ground_m(place.height, place.width, 0.0F),
      score(place.height, place.width, std::numeric_limits<float>::quiet_NaN()),
      obstacle(place.height, place.width, uchar{0}),
      measured(place.height, place.width, uchar{0})
{
  cv::Mat1f count(place.height, place.width, 0.0F);
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
        ground_m(at) += (c.ground_m - ground_m(at)) / count(at);
        score(at) = std::fmin(score(at), c.traversability);
        measured(at) = std::max(measured(at), static_cast<uchar>(measures ? 2 : 1));
        if (c.elevation_m - c.ground_m > kLeastObstacle_m) obstacle(at) = 1;
      });
  ground_m.setTo(std::numeric_limits<float>::quiet_NaN(), measured == 0);
}

cv::Mat1f hill_shade(const cv::Mat1f& ground_m, double pixel_m)
{
  cv::Mat1f weight(ground_m.size()), height(ground_m.size());
  for (int y = 0; y < ground_m.rows; ++y)
    for (int x = 0; x < ground_m.cols; ++x)
    {
      weight(y, x) = std::isnan(ground_m(y, x)) ? 0.0F : 1.0F;
      height(y, x) = std::isnan(ground_m(y, x)) ? 0.0F : ground_m(y, x);
    }
  const double sigma = std::max(0.8, kSmoothed_m / pixel_m);
  cv::GaussianBlur(height, height, {}, sigma);
  cv::GaussianBlur(weight, weight, {}, sigma);
  cv::Mat1f smooth(ground_m.size());
  for (int y = 0; y < ground_m.rows; ++y)
    for (int x = 0; x < ground_m.cols; ++x)
      smooth(y, x) = weight(y, x) > 1e-3F ? height(y, x) / weight(y, x) : 0.0F;
  cv::Mat1f shade(ground_m.size(), 0.7F);
  const auto step = static_cast<float>(2 * pixel_m);
  for (int y = 1; y + 1 < ground_m.rows; ++y)
    for (int x = 1; x + 1 < ground_m.cols; ++x)
    {
      if (!(weight(y, x - 1) > 1e-3F && weight(y, x + 1) > 1e-3F && weight(y - 1, x) > 1e-3F &&
            weight(y + 1, x) > 1e-3F))
        continue;
      const float east = kSteepness * (smooth(y, x + 1) - smooth(y, x - 1)) / step;
      const float north = kSteepness * (smooth(y - 1, x) - smooth(y + 1, x)) / step;
      // The light stands 45 degrees high in the north-west.
      const float cosine =
          (0.5F * east - 0.5F * north + 0.7071F) / std::sqrt(1 + east * east + north * north);
      shade(y, x) = std::clamp(cosine, 0.0F, 1.0F);
    }
  return shade;
}

}  // namespace talus::site
