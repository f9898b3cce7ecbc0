#include <talus/baselines/fills.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

namespace talus::baselines
{
namespace
{
/** Telea's method adds up to about one unit of the values a cell, whatever they are: in metres that
 * would be a metre. */
constexpr float kInpaintUnitsPerMetre = 1e4f;
constexpr double kPi = 3.14159265358979323846;

/** Kernel weights of all offsets up to `radius` cells. */
std::vector<float> kernel_table(int radius, double length_m, double resolution_m)
{
  std::vector<float> table;
  for (int dy = -radius; dy <= radius; ++dy)
    for (int dx = -radius; dx <= radius; ++dx)
      table.push_back(
          static_cast<float>(sparse_kernel(std::hypot(dx, dy) * resolution_m, length_m)));
  return table;
}

/** Weighted mean of the known cells around (ix, iy). */
float infer(const SparseGround& s, const std::vector<float>& kernel, int radius, int ix, int iy)
{
  const int n = s.window.cells, side = 2 * radius + 1;
  double weights = 0, sum = 0;
  for (int y = std::max(iy - radius, 0); y <= std::min(iy + radius, n - 1); ++y)
    for (int x = std::max(ix - radius, 0); x <= std::min(ix + radius, n - 1); ++x)
    {
      const float h = s.ground_m[y * n + x];
      if (h != h) continue;
      const int k = (y - iy + radius) * side + x - ix + radius;
      weights += kernel[k];
      sum += static_cast<double>(kernel[k]) * h;
    }
  return weights > 0 ? static_cast<float>(sum / weights) : NAN;
}

float lowest_neighbour(const std::vector<float>& ground_m, int n, int ix, int iy)
{
  float lowest = NAN;
  for (int y = std::max(iy - 1, 0); y <= std::min(iy + 1, n - 1); ++y)
    for (int x = std::max(ix - 1, 0); x <= std::min(ix + 1, n - 1); ++x)
      lowest = std::fmin(lowest, ground_m[y * n + x]);
  return lowest;
}

/** Every unknown cell gets the height of the nearest known one: at the border of the image
 * cv::inpaint reads cells that it has not filled yet. */
cv::Mat nearest_known(const SparseGround& s, const cv::Mat& unknown)
{
  const int n = s.window.cells;
  cv::Mat distance, labels, heights(n, n, CV_32F);
  cv::distanceTransform(
      unknown, distance, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<float> height_of(static_cast<std::size_t>(n * n) + 1);
  const auto label = [&](int k) { return static_cast<std::size_t>(labels.at<int>(k / n, k % n)); };
  for (int k = 0; k < n * n; ++k)
    if (!unknown.at<std::uint8_t>(k / n, k % n)) height_of[label(k)] = s.ground_m[k];
  for (int k = 0; k < n * n; ++k) heights.at<float>(k / n, k % n) = height_of[label(k)];
  return heights;
}

std::vector<float> inpaint(const SparseGround& s, double radius_cells, int algorithm)
{
  const int n = s.window.cells;
  cv::Mat unknown(n, n, CV_8U), filled;
  for (int k = 0; k < n * n; ++k)
    unknown.at<std::uint8_t>(k / n, k % n) = std::isnan(s.ground_m[k]) ? 255 : 0;
  if (cv::countNonZero(unknown) == n * n) return s.ground_m;
  cv::inpaint(
      nearest_known(s, unknown) * kInpaintUnitsPerMetre, unknown, filled, radius_cells, algorithm);
  filled /= kInpaintUnitsPerMetre;
  return {filled.begin<float>(), filled.end<float>()};
}

}  // namespace

SparseGround measured_ground(const Surfaces& s)
{
  SparseGround sparse{s.window, s.ground_m};
  for (std::size_t i = 0; i < s.size(); ++i)
    if (s.state[i] != static_cast<std::uint8_t>(CellState::Measured)) sparse.ground_m[i] = NAN;
  return sparse;
}

double sparse_kernel(double distance_m, double length_m)
{
  const double d = distance_m / length_m, a = 2 * kPi * d;
  return d >= 1 ? 0.0 : (2 + std::cos(a)) / 3 * (1 - d) + std::sin(a) / (2 * kPi);
}

std::vector<float> fill_bgk(const SparseGround& s, double length_m)
{
  const int n = s.window.cells;
  const auto radius = static_cast<int>(std::ceil(length_m / s.window.resolution_m));
  const auto kernel = kernel_table(radius, length_m, s.window.resolution_m);
  std::vector<float> filled = s.ground_m;
  for (int i = 0; i < n * n; ++i)
    if (std::isnan(filled[i])) filled[i] = infer(s, kernel, radius, i % n, i / n);
  return filled;
}

std::vector<float> fill_min_filter(const SparseGround& s, int iterations)
{
  const int n = s.window.cells;
  std::vector<float> filled = s.ground_m;
  for (int pass = 0; pass < iterations; ++pass)
  {
    const std::vector<float> before = filled;
    for (int i = 0; i < n * n; ++i)
      if (std::isnan(before[i])) filled[i] = lowest_neighbour(before, n, i % n, i / n);
  }
  return filled;
}

std::vector<float> fill_inpaint_navier_stokes(const SparseGround& s, double radius_cells)
{
  return inpaint(s, radius_cells, cv::INPAINT_NS);
}

std::vector<float> fill_inpaint_telea(const SparseGround& s, double radius_cells)
{
  return inpaint(s, radius_cells, cv::INPAINT_TELEA);
}

const std::vector<FillMethod>& fill_methods()
{
  static const std::vector<FillMethod> list{
      {"bgk", "neighbourhood BGK, sparse kernel of 1 m",
       [](const SparseGround& s) { return fill_bgk(s); }},
      {"min_filter", "3 x 3 minimum, 30 times",
       [](const SparseGround& s) { return fill_min_filter(s); }},
      {"navier_stokes", "OpenCV inpaint, Navier-Stokes, radius 3 cells",
       [](const SparseGround& s) { return fill_inpaint_navier_stokes(s); }},
      {"telea", "OpenCV inpaint, Telea, radius 3 cells",
       [](const SparseGround& s) { return fill_inpaint_telea(s); }}};
  return list;
}

}  // namespace talus::baselines
