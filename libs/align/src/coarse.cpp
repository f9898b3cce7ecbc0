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

}  // namespace talus::align
