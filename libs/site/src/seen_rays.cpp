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

/** The pose, its shift counted from the position of the frame's sensor. */
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
  /** For all points. */
  bool is_one() const { return frame_.path.empty() || !frame_.time_s; }
  const Matrix& operator()(std::size_t point)
  {
    const auto& path = frame_.path;
    if (is_one()) return pose_;
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

const std::array<float, SeenRays::kRows> SeenRays::kSlopes = []
{
  std::array<float, kRows> slopes;
  for (std::size_t row = 0; row < slopes.size(); ++row)
    slopes[row] = kernels::slope_at_bin((static_cast<float>(row) + 0.5F) / kRowsPerBin);
  return slopes;
}();

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

/** Some rays, side by side: the loops become vector code. */
struct SeenRays::Rays
{
  static constexpr std::size_t kMax = 256;
  std::array<float, kMax> dx_m, dy_m, dz_m;  //!< from the sensor to the points, map frame
  std::array<std::int32_t, kMax> indices;  //!< in the table; -1: none
  std::array<std::int32_t, kMax> lengths_cm;
  std::size_t n = 0;

  void turn(const Frame& frame, std::size_t first, PoseOfPoint& pose_of)
  {
    const std::size_t together = pose_of.is_one() ? n : 1;
    for (std::size_t i = 0; i < n; i += together)
    {
      const Matrix m = pose_of(first + i);
      turn(frame, first, i, i + together, m);
    }
  }
  void turn(
      const Frame& frame, std::size_t first, std::size_t begin, std::size_t end, const Matrix& m)
  {
    for (std::size_t i = begin; i < end; ++i)
    {
      const float x = frame.x_m[first + i], y = frame.y_m[first + i], z = frame.z_m[first + i];
      dx_m[i] = m[0] * x + m[1] * y + m[2] * z + m[3];
      dy_m[i] = m[4] * x + m[5] * y + m[6] * z + m[7];
      dz_m[i] = m[8] * x + m[9] * y + m[10] * z + m[11];
    }
  }
  void find_indices()
  {
    const float *const dxs = dx_m.data(), *const dys = dy_m.data(), *const dzs = dz_m.data();
    std::int32_t *const at = indices.data(), *const cm = lengths_cm.data();
    const auto end = static_cast<int>(n);
    for (int i = 0; i < end; ++i)
    {
      const float far_m = kernels::chebyshev(dxs[i], dys[i]), slope = dzs[i] / far_m;
      const bool is_ray = (far_m > kNearest_m) & kernels::is_finite(far_m + dzs[i] + slope);
      const float dx = kernels::select(is_ray, dxs[i], 1.0F);
      const float dy = kernels::select(is_ray, dys[i], 0.0F);
      const int row = row_of(kernels::select(is_ray, slope, 0.0F));
      const bool is_kept = is_ray & (row >= 0) & (row < kRows);
      at[i] = kernels::select(is_kept, column_of(dx, dy) * kRows + row, -1);
      cm[i] = centimetres(kernels::select(is_ray, far_m, 0.0F));
    }
  }
};

/** Puts the lengths of a frame's rays into the table, and marks what it takes. */
void SeenRays::put_into(
    std::vector<std::uint16_t>& table, std::vector<std::uint64_t>& taken, const Frame& frame) const
{
  PoseOfPoint pose_of(frame);
  Rays rays;
  for (std::size_t first = 0; first < frame.size; first += rays.n)
  {
    rays.n = std::min(frame.size - first, Rays::kMax);
    rays.turn(frame, first, pose_of);
    rays.find_indices();
    for (std::size_t i = 0; i < rays.n; ++i)
    {
      if (rays.indices[i] < 0) continue;
      const auto at = static_cast<std::size_t>(rays.indices[i]);
      table[at] = std::min(table[at], static_cast<std::uint16_t>(rays.lengths_cm[i]));
      taken[at / kBits] |= std::uint64_t{1} << at % kBits;
    }
  }
}

}  // namespace talus::site
