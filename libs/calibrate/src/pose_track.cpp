#include <talus/calibrate/pose_track.h>

#include <algorithm>
#include <cmath>

namespace talus::calibrate
{
namespace
{
using Value = Eigen::Matrix<double, 7, 1>;

constexpr double kStep_s = 1e-3;  // of the central difference that gives the velocity
constexpr double kStampTolerance_s = 1e-3;

Eigen::Matrix3d rotation_of(const Value& v)
{
  return Eigen::Quaterniond(Eigen::Vector4d(v.tail<4>().normalized())).toRotationMatrix();
}

Value value_of(const mrpt::poses::CPose3D& T, const Eigen::Vector3d& origin)
{
  mrpt::math::CQuaternionDouble q;
  T.getAsQuaternion(q);
  Value v;
  v << T.x() - origin.x(), T.y() - origin.y(), T.z() - origin.z(), q.x(), q.y(), q.z(), q.r();
  return v;
}
}  // namespace

PoseTrack::PoseTrack(const io::Trajectory& trajectory, double max_gap_s) : max_gap_s_(max_gap_s)
{
  for (const auto& e : trajectory.entries())
  {
    const auto& first = trajectory.entries().front().T_map_base;
    Value v = value_of(e.T_map_base, {first.x(), first.y(), first.z()});
    // q and -q are the same rotation: stay on one side.
    if (!knots_.empty() && v.tail<4>().dot(knots_.back().value.tail<4>()) < 0) v.tail<4>() *= -1;
    knots_.push_back({e.time_s, v, Value::Zero()});
  }
  const auto joined = [&](std::size_t i)
  { return i + 1 < knots_.size() && knots_[i + 1].time_s - knots_[i].time_s <= max_gap_s_; };
  for (std::size_t i = 0; i < knots_.size(); ++i)
  {
    const bool before = i > 0 && joined(i - 1), after = joined(i);
    if (before && after)
    {
      // The parabola through three poses.
      const double a = knots_[i].time_s - knots_[i - 1].time_s;
      const double b = knots_[i + 1].time_s - knots_[i].time_s;
      knots_[i].slope = (chord(i - 1, i) * b + chord(i, i + 1) * a) / (a + b);
    }
    else if (before || after)
      knots_[i].slope = before ? chord(i - 1, i) : chord(i, i + 1);
  }
}

Value PoseTrack::chord(std::size_t from, std::size_t to) const
{
  return (knots_[to].value - knots_[from].value) / (knots_[to].time_s - knots_[from].time_s);
}

std::vector<PoseTrack::Knot>::const_iterator PoseTrack::knot_after(double time_s) const
{
  return std::upper_bound(
      knots_.begin(), knots_.end(), time_s, [](double t, const Knot& k) { return t < k.time_s; });
}

double PoseTrack::next_s(double time_s) const
{
  const auto after = knot_after(time_s);
  return after == knots_.end() ? HUGE_VAL : after->time_s;
}

/** Index of the pose before the time; the first or last but one beyond the ends. */
std::size_t PoseTrack::segment_of(double time_s) const
{
  const auto i = std::max<std::ptrdiff_t>(knot_after(time_s) - knots_.begin() - 1, 0);
  return std::min(static_cast<std::size_t>(i), knots_.size() - 2);
}

bool PoseTrack::covers(double time_s) const
{
  if (knots_.size() < 2 || !std::isfinite(time_s)) return false;
  if (time_s < first_s() - kStampTolerance_s || time_s > last_s() + kStampTolerance_s) return false;
  const std::size_t i = segment_of(time_s);
  const auto near = [&](std::size_t k)
  { return std::abs(knots_[k].time_s - time_s) <= kStampTolerance_s; };
  return knots_[i + 1].time_s - knots_[i].time_s <= max_gap_s_ || near(i) || near(i + 1);
}

Value PoseTrack::value_at(double time_s) const
{
  const std::size_t i = segment_of(time_s);
  const Knot &a = knots_[i], &b = knots_[i + 1];
  if (time_s <= a.time_s) return a.value + a.slope * (time_s - a.time_s);
  if (time_s >= b.time_s) return b.value + b.slope * (time_s - b.time_s);
  const double h = b.time_s - a.time_s, w = (time_s - a.time_s) / h, w2 = w * w, w3 = w2 * w;
  return a.value * (2 * w3 - 3 * w2 + 1) + a.slope * (h * (w3 - 2 * w2 + w)) +
         b.value * (3 * w2 - 2 * w3) + b.slope * (h * (w3 - w2));
}

TrackPose PoseTrack::at(double time_s) const
{
  const Value now = value_at(time_s), before = value_at(time_s - kStep_s),
              after = value_at(time_s + kStep_s);
  TrackPose pose;
  pose.R = rotation_of(now);
  pose.t_m = now.head<3>();
  pose.dR = (rotation_of(after) - rotation_of(before)) / (2 * kStep_s);
  pose.dt_mps = (after.head<3>() - before.head<3>()) / (2 * kStep_s);
  return pose;
}

double PoseTrack::length_m() const
{
  double sum = 0;
  for (std::size_t i = 1; i < knots_.size(); ++i)
    sum += (knots_[i].value - knots_[i - 1].value).head<3>().norm();
  return sum;
}

double PoseTrack::turn_rad() const
{
  double most = 0;
  for (const Knot& k : knots_)
  {
    const double cosine = std::abs(k.value.tail<4>().dot(knots_.front().value.tail<4>()));
    most = std::max(most, 2 * std::acos(std::min(1.0, cosine)));
  }
  return most;
}

}  // namespace talus::calibrate
