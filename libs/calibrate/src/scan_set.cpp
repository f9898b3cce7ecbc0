#include <talus/calibrate/scan_set.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
constexpr double kSlice_s = 0.005;  // points within it share a pose
constexpr float kLongestScan_s = 1e4F;

std::uint64_t mix(std::uint64_t v)
{
  v += 0x9E3779B97F4A7C15ull;  // splitmix64
  v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9ull;
  v = (v ^ (v >> 27)) * 0x94D049BB133111EBull;
  return v ^ (v >> 31);
}
}  // namespace

double chance(std::uint64_t a, std::uint64_t b)
{
  return static_cast<double>(mix(mix(a) ^ b) >> 11) * 0x1.0p-53;
}

ScanSet::ScanSet(
    const Thinning& thinning, const mrpt::poses::CPose3D& T_base_sensor, double base_height_m)
    : thinning_(thinning),
      mounting_(mounting_pose(vector_of(T_base_sensor))),
      base_height_m_(base_height_m)
{
}

bool ScanSet::held_out(int frame) const
{
  const int every = thinning_.hold_out_every;
  return every > 0 && frame % every == every / 2;
}

bool ScanSet::may_be_ground(const Eigen::Vector3f& p) const
{
  const float range = p.norm();
  if (!(range >= thinning_.min_range_m && range <= thinning_.max_range_m)) return false;  // or NaN
  const double height = mounting_.R.row(2).dot(p.cast<double>()) + mounting_.t_m.z();
  return std::abs(height + base_height_m_) <= thinning_.band_m + thinning_.band_slope * range;
}

void ScanSet::add(
    double stamp_s, const float* x_m, const float* y_m, const float* z_m, const float* time_s,
    std::size_t size)
{
  struct Kept
  {
    int slice;
    Eigen::Vector3f p;
  };
  std::vector<Kept> kept;
  const auto at = [&](std::size_t i) { return Eigen::Vector3f(x_m[i], y_m[i], z_m[i]); };
  std::size_t candidates = 0;
  for (std::size_t i = 0; i < size; ++i) candidates += may_be_ground(at(i));
  const double share =
      candidates ? static_cast<double>(thinning_.points_per_frame) / candidates : 0;
  const int frame = frames();
  for (std::size_t i = 0; i < size; ++i)
  {
    if (!may_be_ground(at(i)) || chance(static_cast<std::uint64_t>(frame), i) >= share) continue;
    if (time_s && !(std::abs(time_s[i]) < kLongestScan_s)) continue;
    kept.push_back({time_s ? static_cast<int>(std::lround(time_s[i] / kSlice_s)) : 0, at(i)});
  }
  std::stable_sort(
      kept.begin(), kept.end(), [](const Kept& a, const Kept& b) { return a.slice < b.slice; });
  for (std::size_t k = 0; k < kept.size(); ++k)
  {
    if (k == 0 || kept[k].slice != kept[k - 1].slice)
      views_.push_back(
          {stamp_s + kSlice_s * kept[k].slice, frame, static_cast<std::uint32_t>(points_.size()),
           0});
    ++views_.back().count;
    points_.push_back(kept[k].p);
  }
  stamps_s_.push_back(stamp_s);
  points_in_ += size;
  if (points_.size() > thinning_.most_points) halve();
}

/** Leaves out half of the points of every view, and takes half as many from now on. */
void ScanSet::halve()
{
  std::uint32_t kept = 0;
  for (View& view : views_)
  {
    const std::uint32_t first = kept;
    for (std::uint32_t k = view.first; k < view.first + view.count; ++k)
      if (chance(k, thinning_.points_per_frame) < 0.5) points_[kept++] = points_[k];
    view.first = first;
    view.count = kept - first;
  }
  points_.resize(kept);
  thinning_.points_per_frame /= 2;
}

}  // namespace talus::calibrate
