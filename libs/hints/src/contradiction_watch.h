#pragma once
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** Compares what frames from different places say of the height of the same pieces of ground. */
class ContradictionWatch
{
 public:
  /** Points and ground plane of one frame in the frame of its base. */
  void add(const std::vector<Vec3>& points, const NearPlane& ground, const Pose& T_map_base);

  std::size_t pairs() const { return pairs_; }
  /** Median difference of two frames' mean heights of a cell [m]. */
  double difference_m() const { return median_m(differences_); }
  /** Median spread (standard deviation) of a cell's heights within one frame [m]. */
  double spread_m() const { return median_m(spreads_); }

 private:
  struct Hit
  {
    std::uint64_t cell;
    double z_m;  //!< map frame
  };
  struct Seen
  {
    double mean_m, x_m, y_m;  //!< where the robot was
  };
  static constexpr double kBin_m = 0.002;
  using Histogram = std::array<std::uint32_t, 250>;
  static void count(Histogram& histogram, double value_m);
  double median_m(const Histogram& histogram) const;
  void compare(std::size_t from, std::size_t to, const Pose& T_map_base);

  std::vector<Hit> hits_;
  std::unordered_map<std::uint64_t, Seen> seen_;
  Histogram differences_{}, spreads_{};
  std::size_t pairs_ = 0;
};

}  // namespace talus::hints
