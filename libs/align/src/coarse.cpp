#include "registration.h"

#include <algorithm>
#include <cmath>

namespace talus::align
{
namespace
{
constexpr double kFarthest_m = 1.5, kFarthest_rad = 0.12;
constexpr double kStep_m = 0.1, kSigma_m = 0.15, kSigmaZ_m = 0.05;
constexpr double kPreferred = 0.02;  //!< a metre: of equals the nearest counts
constexpr std::size_t kSamples = 300;  //!< of each kind

Samples thinned(Samples all)
{
  const auto thin = [](auto& of)
  {
    const std::size_t every = of.size() / kSamples + 1;
    std::size_t kept = 0;
    for (std::size_t i = every / 2; i < of.size(); i += every) of[kept++] = of[i];
    of.erase(of.begin() + static_cast<std::ptrdiff_t>(kept), of.end());
  };
  thin(all.ground);
  thin(all.standing);
  return all;
}
}  // namespace

Pose best_nearby(const Task& task, const Pose& start, const Directions& along)
{
  const Samples few = thinned(task.samples);
  const Task quick{task.reference, few, task.pixel_m};
  const double step_m = std::max(kStep_m, task.pixel_m);
  const int steps = static_cast<int>(kFarthest_m / step_m);
  const auto all = static_cast<double>(few.ground.size() + few.standing.size());
  Pose best = start;
  double best_score = -INFINITY;
  const auto look = [&](const Eigen::Vector3d& by)
  {
    Pose pose = start;
    pose.v.head<3>() += by;
    if (std::abs(pose.yaw_rad()) > kFarthest_rad) return;
    pose.v[3] = height_at(quick, pose).median_m;
    const double s = score(quick, pose, kSigma_m, kSigmaZ_m) - kPreferred * by.norm() * all;
    if (s <= best_score) return;
    best_score = s;
    best = pose;
  };
  // All combinations of so many steps along each.
  std::vector<int> at(along.size(), -steps);
  for (bool more = true; more;)
  {
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < along.size(); ++i) by += at[i] * step_m * along[i];
    look(by);
    more = false;
    for (std::size_t i = 0; i < along.size() && !more; ++i)
      if (more = ++at[i] <= steps; !more) at[i] = -steps;
  }
  return best;
}

std::vector<Pose> best_anywhere(const Task& task)
{
  constexpr double kQuarterTurn = 1.57079632679489661923, kRaster_m = 0.2;
  constexpr double kMinMet = 0.3;  // share of what stands: less is chance
  constexpr int kMaxSide = 1000;  // places along an axis
  const Samples few = thinned(task.samples);
  const Grid& grid = task.reference.grid();
  const double side_m = grid.pixel_m * std::max(grid.width, grid.height);
  const double step_m = std::max(kRaster_m, 2 * side_m / kMaxSide);
  std::vector<Pose> best;
  for (int turns = 0; turns < 4 && !few.standing.empty(); ++turns)
  {
    Pose pose;
    pose.turn_rad = turns * kQuarterTurn;
    Eigen::Vector2d middle(0, 0);
    for (const StandingSample& sample : few.standing)
      middle += pose.turned(sample.at_m) / static_cast<double>(few.standing.size());
    double best_score = -1;
    Eigen::Vector2d best_m(0, 0);
    for (double x_m = grid.min_x_m; x_m < grid.min_x_m + side_m; x_m += step_m)
      for (double y_m = grid.min_y_m; y_m < grid.min_y_m + side_m; y_m += step_m)
      {
        pose.v.head<2>() = Eigen::Vector2d(x_m, y_m) - middle;
        double s = 0;
        for (const StandingSample& sample : few.standing)
          if (const double d = task.reference.near_m(pose.place(sample.at_m)); d < 2 * kSigma_m)
            s += std::exp(-0.5 * d * d / (kSigma_m * kSigma_m));
        if (s <= best_score) continue;
        best_score = s;
        best_m = pose.v.head<2>();
      }
    if (best_score > kMinMet * static_cast<double>(few.standing.size()))
      best.push_back(first_pose(task, pose.turn_rad, best_m));
  }
  return best;
}

}  // namespace talus::align
