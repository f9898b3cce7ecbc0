#pragma once
#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** The first clouds of a topic, to find out whether another has the points of the same sensor: a
 * pipeline writes them again without the ground, thinned out, or in another frame. */
class FirstClouds
{
 public:
  /** Pose of a frame on the base at a time [ns]; nothing where it is not known. */
  using Mounting =
      std::function<std::optional<mrpt::poses::CPose3D>(const std::string& frame, std::int64_t)>;

  void add(const ScanFile& cloud, const std::string& frame, std::int64_t stamp_ns);
  std::size_t points() const;
  /** Whether all clouds that have the stamps of those of `whole` lie on points of these. */
  bool are_in(const FirstClouds& whole, const Mounting& mounting) const;

 private:
  struct Cloud
  {
    std::string frame;
    std::int64_t stamp_ns;
    std::vector<std::array<float, 3>> points_m;
  };
  std::vector<Cloud> clouds_;
};

/** Where the first clouds of a sensor all have a point, bit by bit, that stands alone or comes
 * several times: a driver that brings its points into another frame puts there what gave no return.
 * At the origin the map leaves these out by their range. */
class NoReturns
{
 public:
  /** False: these were enough. */
  bool add(const ScanFile& cloud);
  /** None where there are more than a few, as where nothing moves in front of an exact sensor. */
  std::vector<std::array<double, 3>> points() const;

 private:
  std::size_t clouds_ = 0;
  std::vector<std::array<double, 3>> points_;  //!< of all clouds so far
};

}  // namespace talus::import
