#include "field.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace talus::align
{
namespace
{
constexpr std::size_t kMax = 5000;  //!< of each kind
constexpr double kAround_m = 0.5;  //!< how much of a wall is looked at
constexpr double kLineRatio = 12;  //!< of the variances along and across it

template <class T>
void thin(std::vector<T>& all)
{
  const std::size_t every = all.size() / kMax + 1;
  std::vector<T> kept;
  kept.reserve(all.size() / every + 1);
  for (std::size_t i = every / 2; i < all.size(); i += every) kept.push_back(all[i]);
  all = std::move(kept);
}

/** Looks whether a wall goes through a pixel where something stands. */
void look_around(const Sketch& sketch, StandingSample& sample)
{
  const Grid& grid = sketch.grid();
  const cv::Point2d p = grid.at(sample.at_m.x(), sample.at_m.y());
  const int x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
  const int reach = std::max(3, static_cast<int>(std::lround(kAround_m / grid.pixel_m)));
  Eigen::Vector2d sum(0, 0);
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  int count = 0;
  for (int k = std::max(0, y - reach); k <= std::min(grid.height - 1, y + reach); ++k)
    for (int i = std::max(0, x - reach); i <= std::min(grid.width - 1, x + reach); ++i)
    {
      if (!sketch.stands()(k, i)) continue;
      const Eigen::Vector2d d(i - x, k - y);
      sum += d;
      squares += d * d.transpose();
      ++count;
    }
  const Eigen::Vector2d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      squares / count - mean * mean.transpose());
  const double across = axes.eigenvalues()[0], along = axes.eigenvalues()[1];
  sample.is_line = along > kLineRatio * across && along > 4;  // in pixels
  sample.normal = axes.eigenvectors().col(0);
}
}  // namespace

Samples::Samples(const Sketch& sketch)
{
  const Grid& grid = sketch.grid();
  constexpr float kNone = 0.02F;
  const cv::Mat1f distance_m = signed_distances_m(sketch.stands(), grid.pixel_m);
  const cv::Mat1f blurred = blurred_edges(sketch.stands());
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
    {
      const cv::Point2d at = grid.place_m(x, y);
      const float height_m = sketch.ground_m()(y, x);
      if (!std::isnan(height_m)) ground.push_back({{at.x, at.y}, height_m});
      if (sketch.stands()(y, x))
        standing.push_back({{at.x, at.y}, distance_m(y, x), false, {0, 0}});
      if (blurred(y, x) > kNone) edges.push_back({{at.x, at.y}, blurred(y, x)});
    }
  thin(ground);
  thin(standing);
  thin(edges);
  for (StandingSample& s : standing) look_around(sketch, s);
}

}  // namespace talus::align
