#include "seen_rays.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace talus::site
{
namespace
{
constexpr std::size_t kBits = 64;  //!< of a word
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

void SeenRays::take(const Frame& frame, int floor, std::size_t number)
{
  number_ = number;
  stamp_s_ = frame.stamp_s;
  x_m_ = frame.T_map_sensor.x();
  y_m_ = frame.T_map_sensor.y();
  z_m_ = static_cast<float>(frame.T_map_sensor.z());
  floor_ = floor;
  // Empty between two scans.
  thread_local std::vector<std::uint16_t> table(
      static_cast<std::size_t>(kColumns) * kRows, kNoRay_cm);
  thread_local std::vector<std::uint64_t> taken(table.size() / kBits);
  put_into(table, taken, frame);
  begins_.clear();
  begins_.reserve(kColumns + 1);
  rows_.clear();
  rows_.reserve(frame.size);
  lengths_cm_.clear();
  lengths_cm_.reserve(frame.size);
  for (std::size_t word = 0; word < taken.size(); ++word)
  {
    if (word % (kRows / kBits) == 0) begins_.push_back(static_cast<std::uint32_t>(rows_.size()));
    for (std::uint64_t& bits = taken[word]; bits != 0; bits &= bits - 1)
    {
      const std::size_t at = word * kBits + static_cast<std::size_t>(__builtin_ctzll(bits));
      rows_.push_back(static_cast<std::uint8_t>(at % kRows));
      lengths_cm_.push_back(std::exchange(table[at], kNoRay_cm));
    }
  }
  begins_.push_back(static_cast<std::uint32_t>(rows_.size()));
}

/** Puts the lengths of a frame's rays into the table, and marks the places that it takes. */
void SeenRays::put_into(
    std::vector<std::uint16_t>& table, std::vector<std::uint64_t>& taken, const Frame& frame) const
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
    const auto at = static_cast<std::size_t>(column_of(dx, dy) * kRows + row);
    table[at] = std::min(table[at], centimetres(length_m));
    taken[at / kBits] |= std::uint64_t{1} << at % kBits;
  }
}

}  // namespace talus::site
