#include "corrected_poses.h"

#include <mrpt/math/slerp.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

using mrpt::poses::CPose3D;

namespace talus::app
{
namespace
{
using Entry = io::Trajectory::Entry;

/** A pose that is known to be right. */
struct Knot
{
  Entry right;
  CPose3D smooth;  //!< the same, as the odometry has it
  double driven_m = 0;  //!< until then
  bool is_given = false;

  /** Brings the odometry of then to where it should be. */
  CPose3D T_right_smooth() const { return right.T_map_base + (-smooth); }
};

/** What was recorded, without its jumps. */
class Odometry
{
 public:
  Odometry(const Poses& recorded, const std::vector<Jump>& jumps)
  {
    auto jump = jumps.begin();
    for (const auto& pose : recorded)
    {
      for (; jump != jumps.end() && jump->time_s <= pose.time_s; ++jump)
        T_smooth_recorded_ = T_smooth_recorded_ + (-jump->T_after_before);
      add({pose.time_s, T_smooth_recorded_ + pose.T_map_base});
    }
    trajectory_ = io::Trajectory(poses_);
  }

  const Poses& poses() const { return poses_; }
  double driven_m(std::size_t i) const { return driven_m_[i]; }
  /** Of the last pose. */
  const CPose3D& T_smooth_recorded() const { return T_smooth_recorded_; }
  bool knows(double time_s) const
  {
    return !poses_.empty() && time_s >= poses_.front().time_s && time_s <= poses_.back().time_s;
  }
  /** The first pose after a time. */
  std::size_t after(double time_s) const
  {
    const auto is_before = [](double t, const Entry& pose) { return t < pose.time_s; };
    return static_cast<std::size_t>(
        std::upper_bound(poses_.begin(), poses_.end(), time_s, is_before) - poses_.begin());
  }
  /** Of a time that it knows. */
  Knot knot(const Entry& right, bool is_given) const
  {
    const std::size_t before = after(right.time_s) - 1;
    return {right, *trajectory_.at(right.time_s, HUGE_VAL), driven_m_[before], is_given};
  }

 private:
  /** What is less than a step is noise of a robot that stands. */
  void add(const Entry& pose)
  {
    constexpr double kStep_m = 0.05;
    if (poses_.empty()) counted_ = pose.T_map_base;
    const double step_m = counted_.distanceTo(pose.T_map_base);
    driven_m_.push_back(poses_.empty() ? 0 : driven_m_.back());
    if (step_m >= kStep_m)
    {
      driven_m_.back() += step_m;
      counted_ = pose.T_map_base;
    }
    poses_.push_back(pose);
  }

  Poses poses_;
  std::vector<double> driven_m_;
  CPose3D counted_, T_smooth_recorded_;
  io::Trajectory trajectory_;
};

CPose3D turned(const CPose3D& rotation, double share)
{
  mrpt::math::CQuaternionDouble none, whole, part;
  rotation.getAsQuaternion(whole);
  mrpt::math::slerp(none, whole, share, part);
  part.normalize();
  return CPose3D(part, 0, 0, 0);
}

CPose3D rotation_of(CPose3D pose)
{
  pose.x(0), pose.y(0), pose.z(0);
  return pose;
}

CPose3D shifted(const CPose3D& pose, const CPose3D& from, const CPose3D& to, double share)
{
  CPose3D moved = pose;
  moved.x_incr(share * (to.x() - from.x()));
  moved.y_incr(share * (to.y() - from.y()));
  moved.z_incr(share * (to.z() - from.z()));
  return moved;
}

/** Adds the odometry between two knots, bent to meet both. */
void add_between(const Odometry& odometry, const Knot& a, const Knot& b, Poses& out)
{
  const CPose3D T_a = a.T_right_smooth();
  const CPose3D turn =
      rotation_of(b.right.T_map_base) + (-rotation_of(T_a + b.smooth));  // all of it, at b
  const auto share_at = [&](double driven_m, double time_s)
  {
    const double length_m = b.driven_m - a.driven_m;
    return length_m > 0 ? std::clamp((driven_m - a.driven_m) / length_m, 0.0, 1.0)
                        : (time_s - a.right.time_s) / (b.right.time_s - a.right.time_s);
  };
  CPose3D before = a.right.T_map_base, bent = before;
  const auto go_on = [&](const CPose3D& smooth, double share)
  {
    const CPose3D pose = T_a + smooth, part = turned(turn, share);
    const CPose3D step =
        part +
        CPose3D(pose.x() - before.x(), pose.y() - before.y(), pose.z() - before.z(), 0, 0, 0);
    const double x = bent.x() + step.x(), y = bent.y() + step.y(), z = bent.z() + step.z();
    bent = part + rotation_of(pose);
    bent.x(x), bent.y(y), bent.z(z);
    before = pose;
  };
  const std::size_t first = out.size();
  std::vector<double> shares;
  for (std::size_t i = odometry.after(a.right.time_s); i < odometry.poses().size(); ++i)
  {
    const Entry& smooth = odometry.poses()[i];
    if (smooth.time_s >= b.right.time_s) break;
    shares.push_back(share_at(odometry.driven_m(i), smooth.time_s));
    go_on(smooth.T_map_base, shares.back());
    out.push_back({smooth.time_s, bent});
  }
  go_on(b.smooth, 1);
  for (std::size_t i = 0; i < shares.size(); ++i)
  {
    auto& pose = out[first + i];
    pose.T_map_base = shifted(pose.T_map_base, bent, b.right.T_map_base, shares[i]);
    pose = io::as_in_tum(pose);
  }
}

/** Where nothing better is known. */
void add_jumps(
    const Poses& recorded, const Odometry& odometry, const std::vector<Jump>& jumps,
    std::vector<Knot>& knots)
{
  constexpr double kMaxDrift = 0.1;  //!< a metre a metre: more is none
  const double from_s = knots.empty() ? recorded.front().time_s : knots.back().right.time_s;
  if (knots.empty()) knots.push_back(odometry.knot(recorded.front(), false));
  for (const auto& jump : jumps)
  {
    if (jump.time_s <= from_s || !odometry.knows(jump.time_s)) continue;
    const std::size_t i = odometry.after(jump.time_s) - 1;
    const Knot knot = odometry.knot(recorded[i], false);
    const auto is_drift_since = [&](const Knot& before)
    {
      const CPose3D seemed = before.T_right_smooth() + knot.smooth;
      return seemed.distanceTo(knot.right.T_map_base) <=
             kMaxDrift * (knot.driven_m - before.driven_m);
    };
    while (!knots.empty() && !knots.back().is_given && !is_drift_since(knots.back()))
      knots.pop_back();
    knots.push_back(knot);
  }
}
}  // namespace

Entry moved(const Entry& pose, const CPose3D& T_after)
{
  return T_after == CPose3D() ? pose : io::as_in_tum({pose.time_s, T_after + pose.T_map_base});
}

CorrectedPoses corrected(const Poses& recorded, const Correction& correction)
{
  if (recorded.empty()) return {};
  const Odometry odometry(recorded, correction.jumps);
  std::vector<Knot> knots;
  for (const auto& pose : correction.given)
    if (odometry.knows(pose.time_s)) knots.push_back(odometry.knot(io::as_in_tum(pose), true));
  add_jumps(recorded, odometry, correction.jumps, knots);

  CorrectedPoses out;
  const CPose3D T_first = knots.front().T_right_smooth();
  for (std::size_t i = 0; odometry.poses()[i].time_s < knots.front().right.time_s; ++i)
    out.poses.push_back(moved(odometry.poses()[i], T_first));
  for (std::size_t k = 0; k < knots.size(); ++k)
  {
    out.poses.push_back(knots[k].right);
    if (k + 1 == knots.size()) break;
    const Knot &a = knots[k], &b = knots[k + 1];
    if (!a.is_given || !b.is_given || b.right.time_s - a.right.time_s > kMaxGap_s)
      add_between(odometry, a, b, out.poses);
  }
  const Knot& last = knots.back();
  if (last.is_given) out.T_after = last.T_right_smooth() + odometry.T_smooth_recorded();
  for (std::size_t i = odometry.after(last.right.time_s); i < recorded.size(); ++i)
    out.poses.push_back(moved(recorded[i], out.T_after));
  return out;
}

}  // namespace talus::app
