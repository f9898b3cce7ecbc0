#include "near_ground.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace talus::hints
{
namespace
{
/** Without leaps at half a turn. */
std::vector<double> headings_of(const std::vector<Pose>& poses)
{
  std::vector<double> headings;
  for (const Pose& T : poses)
  {
    const double heading = std::atan2(T.m[4], T.m[0]);
    const double before = headings.empty() ? heading : headings.back();
    headings.push_back(before + std::remainder(heading - before, 2 * M_PI));
  }
  return headings;
}

/** Turned for each metre driven, from the frame before to the frame after. */
std::vector<double> bends_of(const std::vector<Pose>& poses, const std::vector<double>& headings)
{
  std::vector<double> bends;
  for (std::size_t i = 0; i < poses.size(); ++i)
  {
    const std::size_t a = i > 0 ? i - 1 : i, b = std::min(i + 1, poses.size() - 1);
    const double path_m = length(origin_of(poses[b]) - origin_of(poses[a]));
    bends.push_back((headings[b] - headings[a]) / std::max(path_m, 0.01));
  }
  return bends;
}

FrameSplit thirds_of(const std::vector<double>& values)
{
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(
      order.begin(), order.end(),
      [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  FrameSplit split;
  for (std::size_t i = 0; i < order.size() / 3; ++i)
  {
    split.one |= std::uint64_t{1} << order[i];
    split.other |= std::uint64_t{1} << order[order.size() - 1 - i];
  }
  return split;
}
}  // namespace

double heading_span_rad(const std::vector<Pose>& poses)
{
  const auto headings = headings_of(poses);
  if (headings.empty()) return 0;
  const auto [low, high] = std::minmax_element(headings.begin(), headings.end());
  return *high - *low;
}

std::vector<FrameSplit> splits_by_heading(const std::vector<Pose>& poses)
{
  const auto headings = headings_of(poses);
  return {thirds_of(headings), thirds_of(bends_of(poses, headings))};
}

}  // namespace talus::hints
