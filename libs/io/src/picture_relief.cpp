#include "picture_relief.h"

#include "picture_style.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::io
{
namespace
{
constexpr double kSmoothed_m = 0.15;  //!< standard deviation, against the noise of single cells
constexpr float kSteepness = 3;  //!< heights are shown so many times as high
constexpr float kLevel = 0.7071F;  //!< light on level ground
constexpr float kPassable = 0.5F;  //!< what is there does not block: it hangs high, or is low
constexpr float kMinWeight = 1e-3F;

/** In pixels. */
double deviation(double pixel_m) { return std::max(0.8, kSmoothed_m / pixel_m); }

/** Means of the known ground around each pixel; 0 where none is near, as `weight` is there. */
cv::Mat1f smoothed(const cv::Mat1f& ground_m, double pixel_m, cv::Mat1f& weight)
{
  cv::Mat1f height(ground_m.size());
  weight.create(ground_m.size());
  for (int y = 0; y < ground_m.rows; ++y)
    for (int x = 0; x < ground_m.cols; ++x)
    {
      const float z = ground_m(y, x);
      weight(y, x) = std::isfinite(z) ? 1.0F : 0.0F;
      height(y, x) = std::isfinite(z) ? z : 0.0F;
    }
  const double sigma = deviation(pixel_m);
  cv::GaussianBlur(height, height, {}, sigma);
  cv::GaussianBlur(weight, weight, {}, sigma);
  for (int y = 0; y < ground_m.rows; ++y)
    for (int x = 0; x < ground_m.cols; ++x)
      height(y, x) = weight(y, x) > kMinWeight ? height(y, x) / weight(y, x) : 0.0F;
  return height;
}
}  // namespace

cv::Vec3b mixed(const cv::Vec3b& a, const cv::Vec3b& b, float part_b)
{
  cv::Vec3b m;
  for (int k = 0; k < 3; ++k) m[k] = cv::saturate_cast<uchar>((1 - part_b) * a[k] + part_b * b[k]);
  return m;
}

cv::Vec3b lit(const cv::Vec3b& colour, float shade)
{
  constexpr float kDarkest = 0.4F;
  cv::Vec3b c;
  for (int k = 0; k < 3; ++k)
    c[k] = cv::saturate_cast<uchar>(colour[k] * (kDarkest + (1 - kDarkest) * shade / kLevel));
  return c;
}

int reach_of_shade(double pixel_m)
{
  return static_cast<int>(std::ceil(4 * deviation(pixel_m))) + 2;  // OpenCV cuts the bell there
}

cv::Mat1f hill_shade(const cv::Mat1f& ground_m, double pixel_m)
{
  cv::Mat1f weight;
  const cv::Mat1f smooth = smoothed(ground_m, pixel_m, weight);
  cv::Mat1f shade(ground_m.size(), kLevel);
  const auto step = static_cast<float>(2 * pixel_m);
  for (int y = 1; y + 1 < ground_m.rows; ++y)
    for (int x = 1; x + 1 < ground_m.cols; ++x)
    {
      if (!(weight(y, x - 1) > kMinWeight && weight(y, x + 1) > kMinWeight &&
            weight(y - 1, x) > kMinWeight && weight(y + 1, x) > kMinWeight))
        continue;
      const float east = kSteepness * (smooth(y, x + 1) - smooth(y, x - 1)) / step;
      const float north = kSteepness * (smooth(y - 1, x) - smooth(y + 1, x)) / step;
      // The light stands 45 degrees high in the upper left.
      const float cosine =
          (0.5F * east - 0.5F * north + kLevel) / std::sqrt(1 + east * east + north * north);
      shade(y, x) = std::clamp(cosine, 0.0F, 1.0F);
    }
  return shade;
}

Terrain terrain_of(const LayerStack& s, bool is_part)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const cv::Size size(s.cells_x, s.cells_y);
  Terrain t{
      cv::Mat1f(size, nan), cv::Mat1f(size, nan), cv::Mat1b(size, uchar{0}),
      cv::Mat1b(size, uchar{0})};
  const auto* ground = s.find(layer_name(Layer::GroundElevation));
  const auto* top = s.find(layer_name(Layer::Elevation));
  const auto* score = s.find(layer_name(Layer::Traversability));
  const auto* state = s.find(layer_name(Layer::State));
  // A single scan may tell nothing of the ground around the robot, so that nothing is reached.
  const auto* reached = s.find(layer_name(Layer::Reached));
  if (reached && !is_part && std::count(reached->begin(), reached->end(), 1.0F) == 0)
    reached = nullptr;
  // Of a whole drive rays have proved what goes on from one side; of a window nothing has.
  const bool is_window = state && !s.find("age");
  const auto is_guessed_free = [&](std::size_t i)
  { return (*state)[i] == static_cast<float>(CellState::FilledOneSided) && (*score)[i] > 0; };
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
    {
      const auto i = static_cast<std::size_t>(size.height - 1 - y) * size.width + x;
      t.score(y, x) = is_window && is_guessed_free(i) ? nan : (*score)[i];
      if (ground) t.ground_m(y, x) = (*ground)[i];
      const bool known = state ? (*state)[i] >= 1 : std::isfinite(t.score(y, x));
      const bool measured = (!state || (*state)[i] == 1) && !(reached && (*reached)[i] == 0);
      t.measured(y, x) = static_cast<uchar>(!known ? 0 : measured ? 2 : 1);
      t.obstacle(y, x) = ground && top && (*top)[i] - (*ground)[i] > kMinObstacle_m ? 1 : 0;
    }
  return t;
}

cv::Mat3b paint_terrain(const Terrain& t, double pixel_m)
{
  const cv::Mat1f shade = hill_shade(t.ground_m, pixel_m);
  cv::Mat3b image(t.score.size(), bgr(palette::kNotSeen.rgb));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
    {
      if (t.measured(y, x) == 0) continue;
      const float score = t.score(y, x);
      const bool blocks = t.obstacle(y, x) != 0 && !(score > kPassable);
      const bool is_filled = t.measured(y, x) == 1;
      // The relief of a guess is not worth much contrast.
      const float light = is_filled ? (shade(y, x) + kLevel) / 2 : shade(y, x);
      const Rgb colour = score_colour(score);
      image(y, x) =
          blocks ? bgr(palette::kStands.rgb) : lit(bgr(is_filled ? pale(colour) : colour), light);
    }
  return image;
}

}  // namespace talus::io
