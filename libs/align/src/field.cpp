#include "field.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace talus::align
{
namespace
{
constexpr double kSmoothed_m = 0.1;  //!< standard deviation
constexpr float kMinWeight = 0.5f;  //!< of known ground around a pixel
constexpr double kDeepest_m = 0.15;  //!< what is deeper inside of a thing was seen by chance
constexpr double kLevel = 0.04;  //!< what a slope must exceed: the noise of cells has less

cv::Mat1f smoothed(const cv::Mat1f& ground_m, double pixel_m)
{
  cv::Mat1f height(ground_m.size(), 0.0F), weight(ground_m.size(), 0.0F);
  const cv::Mat1b known = ground_m == ground_m;
  ground_m.copyTo(height, known);
  weight.setTo(1.0F, known);
  const double sigma = std::max(0.7, kSmoothed_m / pixel_m);
  cv::GaussianBlur(height, height, {}, sigma);
  cv::GaussianBlur(weight, weight, {}, sigma);
  cv::Mat1f smooth = height / weight;
  smooth.setTo(std::numeric_limits<float>::quiet_NaN(), (weight < kMinWeight) | ~known);
  return smooth;
}

/** Nothing outside of the grid. */
std::optional<double> nearest(const cv::Mat1f& field, const Grid& grid, const Eigen::Vector2d& at_m)
{
  const cv::Point2d p = grid.at(at_m.x(), at_m.y());
  const int x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
  const bool inside = x >= 0 && y >= 0 && x < grid.width && y < grid.height;
  return inside ? std::optional<double>(field(y, x)) : std::nullopt;
}
}  // namespace

cv::Mat1f signed_distances_m(const cv::Mat1b& stands, double pixel_m)
{
  cv::Mat1f outside, inside;
  cv::distanceTransform(stands == 0, outside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(stands != 0, inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::min(inside, kDeepest_m / pixel_m, inside);
  cv::Mat1f distance = outside - 0.5F;  // the edge lies between two pixels
  cv::Mat1f(0.5F - inside).copyTo(distance, stands);
  return distance * pixel_m;
}

cv::Mat1f blurred_edges(const cv::Mat1b& stands)
{
  constexpr double kBlurred = 1.5;  // pixels
  cv::Mat1f edges = stands;
  cv::GaussianBlur(edges, edges, {}, kBlurred);
  return edges;
}

FieldValue value_at(const cv::Mat1f& field, const Grid& grid, const Eigen::Vector2d& at_m)
{
  const cv::Point2d p = grid.at(at_m.x(), at_m.y());
  FieldValue v;
  if (!(p.x >= 0 && p.y >= 0 && p.x < grid.width - 1 && p.y < grid.height - 1)) return v;
  const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
  const double u = p.x - x, w = p.y - y;
  const double a = field(y, x), b = field(y, x + 1), c = field(y + 1, x), d = field(y + 1, x + 1);
  v.value = (1 - w) * ((1 - u) * a + u * b) + w * ((1 - u) * c + u * d);
  v.slope = {
      ((1 - w) * (b - a) + w * (d - c)) / grid.pixel_m,
      ((1 - u) * (c - a) + u * (d - b)) / grid.pixel_m};
  return v;
}

Reference::Reference(const Sketch& sketch)
    : grid_(sketch.grid()),
      measured_m_(sketch.ground_m()),
      smooth_m_(smoothed(sketch.ground_m(), sketch.grid().pixel_m)),
      distance_m_(signed_distances_m(sketch.stands(), sketch.grid().pixel_m)),
      edges_(blurred_edges(sketch.stands()))
{
}

FieldValue Reference::ground(const Eigen::Vector2d& at_m) const
{
  FieldValue v = value_at(smooth_m_, grid_, at_m);
  if (!(v.slope.norm() > kLevel)) v.slope.setZero();
  return v;
}

double Reference::ground_as_measured(const Eigen::Vector2d& at_m) const
{
  return nearest(measured_m_, grid_, at_m).value_or(NAN);
}

double Reference::near_m(const Eigen::Vector2d& at_m) const
{
  return std::max(0.0, nearest(distance_m_, grid_, at_m).value_or(INFINITY));
}

FieldValue Reference::distance_m(const Eigen::Vector2d& at_m) const
{
  return value_at(distance_m_, grid_, at_m);
}

}  // namespace talus::align
