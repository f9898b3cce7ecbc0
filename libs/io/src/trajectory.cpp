#include <talus/io/trajectory.h>

#include <mrpt/math/slerp.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "archive.h"

using mrpt::poses::CPose3D;

namespace talus::io
{
namespace
{
/** Stamps written with fewer digits than they were taken with still meet their pose. */
constexpr double kStampTolerance_s = 1e-3;

CPose3D interpolate(const Trajectory::Entry& a, const Trajectory::Entry& b, double time_s)
{
  const double t = (time_s - a.time_s) / (b.time_s - a.time_s);
  mrpt::math::CQuaternionDouble qa, qb, q;
  a.T_map_base.getAsQuaternion(qa);
  b.T_map_base.getAsQuaternion(qb);
  mrpt::math::slerp(qa, qb, t, q);
  q.normalize();
  const auto between = [t](double from, double to) { return from + t * (to - from); };
  return CPose3D(
      q, between(a.T_map_base.x(), b.T_map_base.x()), between(a.T_map_base.y(), b.T_map_base.y()),
      between(a.T_map_base.z(), b.T_map_base.z()));
}

}  // namespace

Trajectory::Trajectory(std::vector<Entry> entries) : entries_(std::move(entries))
{
  for (const Entry& e : entries_)
    if (!std::isfinite(e.time_s) || !is_finite(e.T_map_base))
      throw std::invalid_argument("a time or a pose of a trajectory is not finite");
  std::stable_sort(
      entries_.begin(), entries_.end(),
      [](const Entry& a, const Entry& b) { return a.time_s < b.time_s; });
  // From the back: the first that unique() meets, the one that stays, is the last that was given.
  const auto last = std::unique(
      entries_.rbegin(), entries_.rend(),
      [](const Entry& a, const Entry& b) { return a.time_s == b.time_s; });
  entries_.erase(entries_.begin(), last.base());
}

Trajectory Trajectory::levelled(double& turned_rad) const
{
  mrpt::math::TPoint3D up(0, 0, 0);
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    constexpr double kStanding_m = 1e-6;  // what stands still counts where nothing moves
    const CPose3D& T = entries_[i].T_map_base;
    const double path_m = kStanding_m + (i > 0 ? T.distanceTo(entries_[i - 1].T_map_base) : 0);
    up += (T.composePoint({0, 0, 1}) - mrpt::math::TPoint3D(T.asTPose())) * path_m;
  }
  turned_rad = 0;
  const double length = up.norm(), across = std::hypot(up.x, up.y);
  if (!(across > 1e-9 * length) || !(up.z > -0.9 * length)) return *this;
  turned_rad = std::atan2(across, up.z);
  const double s = std::sin(turned_rad / 2) / across;
  const CPose3D turn(
      mrpt::math::CQuaternionDouble(std::cos(turned_rad / 2), up.y * s, -up.x * s, 0), 0, 0, 0);
  const auto& first = entries_.front().T_map_base;
  const CPose3D about(first.x(), first.y(), first.z(), 0, 0, 0);
  auto entries = entries_;
  for (Entry& e : entries) e.T_map_base = about + turn + ((-about) + e.T_map_base);
  return Trajectory(std::move(entries));
}

std::optional<CPose3D> Trajectory::at(double time_s, double max_gap_s) const
{
  if (!std::isfinite(time_s)) return std::nullopt;
  const auto after = std::lower_bound(
      entries_.begin(), entries_.end(), time_s,
      [](const Entry& e, double t) { return e.time_s < t; });
  const bool has_after = after != entries_.end();
  const bool has_before = after != entries_.begin();
  if (has_after && after->time_s == time_s) return after->T_map_base;
  if (has_after && has_before && after->time_s - (after - 1)->time_s <= max_gap_s)
    return interpolate(*(after - 1), *after, time_s);

  const double to_after = has_after ? after->time_s - time_s : HUGE_VAL;
  const double to_before = has_before ? time_s - (after - 1)->time_s : HUGE_VAL;
  if (std::min(to_after, to_before) > kStampTolerance_s) return std::nullopt;
  return to_after < to_before ? after->T_map_base : (after - 1)->T_map_base;
}

}  // namespace talus::io
