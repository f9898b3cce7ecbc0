#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>

#include "needed_layer.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace talus::formats
{
namespace
{
constexpr int kMaxPixels = 4097;
constexpr float kWhite = 65535;

/** f(column, row, its ground) of each cell, rows from the south. */
template <class F>
void for_each_ground(const MapStrips& map, F f)
{
  map.for_each(
      [&](const Strip& strip)
      {
        const auto& ground = needed_layer(strip.map, Layer::GroundElevation);
        for_each_cell(
            strip, [&](std::size_t i, int ix, int iy) { f(ix, strip.first_row + iy, ground[i]); });
      });
}

/** The rectangle of cells whose ground is known; its rows count from the south. */
cv::Rect known_cells(const MapStrips& map)
{
  cv::Rect box;
  for_each_ground(
      map,
      [&](int ix, int iy, float ground)
      {
        if (!std::isnan(ground)) box |= cv::Rect(ix, iy, 1, 1);
      });
  return box;
}

/** The least 2^n + 1 that is not less. */
int side_for(int cells)
{
  int side = 2;
  while (side + 1 < cells) side *= 2;
  return side + 1;
}

/** The ground of a square whose south-west cell is `corner`, as a picture: its first row is the
 * northernmost. NaN where it is unknown. */
cv::Mat1f square_of(const MapStrips& map, const cv::Point& corner, int side)
{
  cv::Mat1f square(side, side, std::numeric_limits<float>::quiet_NaN());
  for_each_ground(
      map,
      [&](int ix, int iy, float ground)
      {
        const int x = ix - corner.x, y = iy - corner.y;
        if (x >= 0 && y >= 0 && x < side && y < side) square(side - 1 - y, x) = ground;
      });
  return square;
}

/** Gives each unknown pixel the height of the nearest known one. */
void fill_from_nearest(cv::Mat1f& square)
{
  cv::Mat1b unknown(square.size());
  for (int y = 0; y < square.rows; ++y)
    for (int x = 0; x < square.cols; ++x) unknown(y, x) = std::isnan(square(y, x)) ? 1 : 0;
  cv::Mat1f distance;
  cv::Mat1i label;
  cv::distanceTransform(
      unknown, distance, label, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<float> height_of(square.total() + 1);
  for (int y = 0; y < square.rows; ++y)
    for (int x = 0; x < square.cols; ++x)
      if (!unknown(y, x)) height_of[static_cast<std::size_t>(label(y, x))] = square(y, x);
  for (int y = 0; y < square.rows; ++y)
    for (int x = 0; x < square.cols; ++x)
      square(y, x) = height_of[static_cast<std::size_t>(label(y, x))];
}

std::string json_of(const HeightmapPlace& p)
{
  const auto n = [](double v) { return fixed_text(v, 4); };
  return "{\n  \"size_m\": [" + n(p.size_m) + ", " + n(p.size_m) + ", " + n(p.height_m) +
         "],\n  \"pos_m\": [" + n(p.center_x_m) + ", " + n(p.center_y_m) + ", " + n(p.lowest_m) +
         "],\n  \"side_pixels\": " + std::to_string(p.side_pixels) + "\n}\n";
}
}  // namespace

HeightmapPlace write_heightmap(const std::string& path, const MapStrips& map)
{
  cv::Rect box;
  const auto fits = [&box](const MapStrips& m)
  {
    box = known_cells(m);
    return std::max(box.width, box.height) <= kMaxPixels;
  };
  const MapStrips joined = joined_until(fits, map);
  const io::LayerStack& shown = joined.frame();
  if (box.empty()) throw std::runtime_error(path + ": the ground of no cell is known");
  HeightmapPlace place;
  const int side = place.side_pixels = side_for(std::max(box.width, box.height));
  const cv::Point corner(box.x - (side - box.width) / 2, box.y - (side - box.height) / 2);
  cv::Mat1f square = square_of(joined, corner, side);
  fill_from_nearest(square);
  double lowest = 0, highest = 0;
  cv::minMaxLoc(square, &lowest, &highest);
  place.lowest_m = lowest;
  place.height_m = std::max(highest - lowest, 1e-3);  // engines refuse none
  // A pixel is a place, not a square: the outermost lie on the border.
  place.size_m = (side - 1) * shown.resolution_m;
  place.center_x_m = middle_x_m(shown, corner.x + (side - 1) / 2);
  place.center_y_m = middle_y_m(shown, corner.y + (side - 1) / 2);
  cv::Mat picture;
  square.convertTo(picture, CV_16U, kWhite / place.height_m, -lowest * kWhite / place.height_m);
  io::write_png(path, picture);
  io::write_file(std::filesystem::path(path).replace_extension(".json").string(), json_of(place));
  return place;
}

}  // namespace talus::formats
