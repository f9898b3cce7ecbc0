#pragma once
#include "kernels/rays.h"

#include <talus/frame.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace talus::site
{
/** The rays of one scan, thinned so that those of many scans can be kept: for each direction and
 * step of slope the shortest ray. Directions, slopes and distances are as in the ray table of the
 * map: points on the border of a square around the sensor, and Chebyshev distances. */
class SeenRays
{
 public:
  /** Takes the rays of a frame in place of those that it has. `floor`: of the site. `number`: of
   * the scans that were taken before. */
  void take(const Frame& frame, int floor, std::size_t number);

  /** A ray that passes a position and ends behind it; heights in the map frame. */
  struct Passing
  {
    float height_m, end_height_m, behind_m;
  };
  /** Of the sensor, map frame [m]. */
  double x_m() const { return x_m_; }
  /** See x_m(). */
  double y_m() const { return y_m_; }
  int floor() const { return floor_; }
  double stamp_s() const { return stamp_s_; }
  std::size_t number() const { return number_; }

  /** Calls f(height_m, behind_m) for the rays that go over a position between two heights: their
   * height there, map frame, and how far behind the position they end; negative: before it. */
  template <class F>
  void for_each_over(double x_m, double y_m, float low_m, float high_m, const F& f) const
  {
    const std::optional<Direction> to = towards(x_m, y_m);
    if (!to) return;
    const auto [column, away_m] = *to;
    const int low = row_of((low_m - z_m_) / away_m), high = row_of((high_m - z_m_) / away_m);
    const std::uint8_t* const end = rows_.data() + begins_[column + 1];
    const std::uint8_t* row = std::lower_bound(rows_.data() + begins_[column], end, low);
    for (; row != end && *row <= high; ++row)
    {
      const std::uint16_t length_cm = lengths_cm_[static_cast<std::size_t>(row - rows_.data())];
      f(z_m_ + slope_of_row(*row) * away_m, metres(length_cm) - away_m);
    }
  }

  /** The lowest ray of those that go on behind a position by more than `by_m`. */
  std::optional<Passing> lowest_behind(double x_m, double y_m, float by_m) const
  {
    const std::optional<Direction> to = towards(x_m, y_m);
    if (!to) return std::nullopt;
    const auto [column, away_m] = *to;
    std::uint32_t i = begins_[column];
    const std::uint32_t end = begins_[column + 1];
    for (const int min_cm = first_above(away_m + by_m); i < end && lengths_cm_[i] < min_cm;) ++i;
    if (i == end) return std::nullopt;
    const float length_m = metres(lengths_cm_[i]);
    return Passing{
        z_m_ + slope_of_row(rows_[i]) * away_m, z_m_ + slope_of_row(rows_[i]) * length_m,
        length_m - away_m};
  }

 private:
  static constexpr float kNearest_m = 0.5F;  //!< nearer rays end at the robot
  static constexpr int kPerSide = 256, kColumns = 4 * kPerSide, kRows = 128;
  static constexpr float kRowsPerBin = static_cast<float>(kRows) / kernels::kSlopeBins;

  static const std::array<float, kRows> kSlopes;

  struct Direction
  {
    std::size_t column;
    float away_m;
  };
  /** Nothing of positions at the robot. */
  std::optional<Direction> towards(double x_m, double y_m) const
  {
    const auto dx = static_cast<float>(x_m - x_m_), dy = static_cast<float>(y_m - y_m_);
    const float away_m = kernels::chebyshev(dx, dy);
    if (!(away_m > kNearest_m)) return std::nullopt;
    return Direction{static_cast<std::size_t>(column_of(dx, dy)), away_m};
  }
  static int column_of(float dx, float dy)
  {
    const int column = kernels::floor_to_int(kernels::direction_in_bins(dx, dy, kPerSide));
    return column < kColumns ? column : 0;
  }
  /** Steeper slopes than those that are kept are outside [0, kRows). */
  static int row_of(float slope)
  {
    return kernels::floor_to_int(kernels::slope_bin(slope) * kRowsPerBin);
  }
  static float slope_of_row(std::size_t row) { return kSlopes[row]; }
  static float metres(int length_cm) { return static_cast<float>(length_cm) * 0.01F; }
  /** The smallest number of centimetres that is more than a length. */
  static int first_above(float length_m)
  {
    int cm = static_cast<int>(length_m * 100);
    while (metres(cm) > length_m) --cm;
    while (!(metres(cm) > length_m)) ++cm;
    return cm;
  }
  struct Rays;
  void put_into(
      std::vector<std::uint16_t>& table, std::vector<std::uint64_t>& taken,
      const Frame& frame) const;

  double stamp_s_ = 0, x_m_ = 0, y_m_ = 0;
  float z_m_ = 0;
  int floor_ = 0;
  std::size_t number_ = 0;
  std::vector<std::uint32_t> begins_;  //!< of each column in the two lists, and their end
  std::vector<std::uint8_t> rows_;  //!< ascending in a column
  std::vector<std::uint16_t> lengths_cm_;
};

using Scans = std::vector<const SeenRays*>;

}  // namespace talus::site
