#pragma once
#include <mrpt/poses/CPose3D.h>

#include <array>
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

}  // namespace talus::import
