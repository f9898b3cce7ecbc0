#include "contradiction_watch.h"

#include <algorithm>
#include <cmath>

#include "thresholds.h"

namespace talus::hints
{
namespace
{
constexpr std::size_t kMaxCells = 100000;  // of a long drive the first are enough

std::uint64_t cell_of(double x_m, double y_m)
{
  const auto index = [](double v) { return static_cast<std::int64_t>(std::floor(v / kCell_m)); };
  return (static_cast<std::uint64_t>(index(x_m)) << 32) ^
         (static_cast<std::uint64_t>(index(y_m)) & 0xffffffffU);
}
}  // namespace

void ContradictionWatch::add(
    const std::vector<Vec3>& points, const NearPlane& ground, const Pose& T_map_base)
{
  hits_.clear();
  for (const Vec3& p : points)
  {
    if (std::abs(ground.distance_m(p)) > kGroundBand_m) continue;
    if (p.x * p.x + p.y * p.y > kContradictionReach_m * kContradictionReach_m) continue;
    const Vec3 at = moved(T_map_base, p);
    hits_.push_back({cell_of(at.x, at.y), at.z});
  }
  std::sort(
      hits_.begin(), hits_.end(),
      [](const Hit& a, const Hit& b)
      { return a.cell != b.cell ? a.cell < b.cell : a.z_m < b.z_m; });
  for (std::size_t from = 0, to = 0; from < hits_.size(); from = to)
  {
    while (to < hits_.size() && hits_[to].cell == hits_[from].cell) ++to;
    if (to - from >= kMinHits) compare(from, to, T_map_base);
  }
}

void ContradictionWatch::compare(std::size_t from, std::size_t to, const Pose& T_map_base)
{
  double sum = 0, squares = 0;
  for (std::size_t i = from; i < to; ++i) sum += hits_[i].z_m;
  const double n = static_cast<double>(to - from), mean = sum / n;
  for (std::size_t i = from; i < to; ++i) squares += (hits_[i].z_m - mean) * (hits_[i].z_m - mean);
  const Seen now{mean, T_map_base.x(), T_map_base.y()};
  const auto found = seen_.find(hits_[from].cell);
  if (found == seen_.end())
  {
    if (seen_.size() < kMaxCells) seen_.emplace(hits_[from].cell, now);
    return;
  }
  Seen& before = found->second;
  if (std::hypot(now.x_m - before.x_m, now.y_m - before.y_m) < kMinApart_m) return;
  count(differences_, std::abs(mean - before.mean_m));
  count(spreads_, std::sqrt(squares / (n - 1)));
  ++pairs_;
  before = now;
}

void ContradictionWatch::count(Histogram& histogram, double value_m)
{
  const double bin = std::min(value_m / kBin_m, static_cast<double>(histogram.size()) - 1);
  ++histogram[static_cast<std::size_t>(bin)];
}

double ContradictionWatch::median_m(const Histogram& histogram) const
{
  std::size_t below = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i)
  {
    below += histogram[i];
    if (2 * below >= pairs_) return (static_cast<double>(i) + 0.5) * kBin_m;
  }
  return 0;
}

}  // namespace talus::hints
