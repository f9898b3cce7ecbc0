#include "seen_rays.h"

#include <algorithm>
#include <array>
#include <limits>

namespace talus::site
{
namespace
{
constexpr std::uint16_t kNoRay_cm = std::numeric_limits<std::uint16_t>::max();

std::uint16_t centimetres(float length_m)
{
  return static_cast<std::uint16_t>(std::min(length_m * 100, static_cast<float>(kNoRay_cm - 1)));
}

using Matrix = std::array<float, 12>;

/** The pose, its shift counted from the place of the frame's sensor. */
Matrix from_sensor(const Pose& pose, const Frame& frame)
{
  Matrix m;
  for (std::size_t i = 0; i < m.size(); ++i)
    m[i] = static_cast<float>(pose.m[i] - (i % 4 == 3 ? frame.T_map_sensor.m[i] : 0));
  return m;
}

/** Where the sensor was at the times of the points: the pose of its path that comes next. */
class PoseOfPoint
{
 public:
  explicit PoseOfPoint(const Frame& frame)
      : frame_(frame), pose_(from_sensor(frame.T_map_sensor, frame))
  {
  }
  const Matrix& operator()(std::size_t point)
  {
    const auto& path = frame_.path;
    if (path.empty() || !frame_.time_s) return pose_;
    const float time_s = frame_.time_s[point];
    const auto is_before = [](const TimedPose& p, float t) { return p.time_s < t; };
    const auto next = std::lower_bound(path.begin(), path.end() - 1, time_s, is_before);
    if (&*next != next_) pose_ = from_sensor((next_ = &*next)->T_map_sensor, frame_);
    return pose_;
  }

 private:
  const Frame& frame_;
  Matrix pose_;
  const TimedPose* next_ = nullptr;
};
}  // namespace

void SeenRays::take(const Frame& frame, int floor)
{
  stamp_s_ = frame.stamp_s;
  x_m_ = frame.T_map_sensor.x();
  y_m_ = frame.T_map_sensor.y();
  z_m_ = static_cast<float>(frame.T_map_sensor.z());
  floor_ = floor;
  thread_local std::vector<std::uint16_t> table;
  table.assign(static_cast<std::size_t>(kColumns) * kRows, kNoRay_cm);
  put_into(table, frame);
  begins_.clear();
  begins_.reserve(kColumns + 1);
  rows_.clear();
  rows_.reserve(frame.size);
  lengths_cm_.clear();
  lengths_cm_.reserve(frame.size);
  for (std::size_t i = 0; i < table.size(); ++i)
  {
    if (i % kRows == 0) begins_.push_back(static_cast<std::uint32_t>(rows_.size()));
    if (table[i] == kNoRay_cm) continue;
    rows_.push_back(static_cast<std::uint8_t>(i % kRows));
    lengths_cm_.push_back(table[i]);
  }
  begins_.push_back(static_cast<std::uint32_t>(rows_.size()));
}

void SeenRays::put_into(std::vector<std::uint16_t>& table, const Frame& frame) const
{
  PoseOfPoint pose_of(frame);
  for (std::size_t i = 0; i < frame.size; ++i)
  {
    const Matrix& m = pose_of(i);
    const float x = frame.x_m[i], y = frame.y_m[i], z = frame.z_m[i];
    const float dx = m[0] * x + m[1] * y + m[2] * z + m[3];
    const float dy = m[4] * x + m[5] * y + m[6] * z + m[7];
    const float dz = m[8] * x + m[9] * y + m[10] * z + m[11];
    const float length_m = kernels::chebyshev(dx, dy);
    if (!(length_m > kNearest_m && kernels::is_finite(length_m + dz))) continue;
    const int row = row_of(dz / length_m);
    if (row < 0 || row >= kRows) continue;
    std::uint16_t& at = table[static_cast<std::size_t>(column_of(dx, dy) * kRows + row)];
    at = std::min(at, centimetres(length_m));
  }
}

}  // namespace talus::site
