#pragma once
#include <talus/parameters.h>

#include <memory>

namespace talus
{
namespace kernels
{
struct Config;
}

/** The map's own test of single points, for those who must leave out what the map leaves out. */
class PointFilter
{
 public:
  explicit PointFilter(const Parameters& parameters);
  ~PointFilter();

  /** Whether a point of the sensor frame [m] passes range, body box and height band: stage 1 but
   * for what depends on the window or on other points. False for one that is not finite. */
  bool accepts(float x_m, float y_m, float z_m) const;

 private:
  std::unique_ptr<const kernels::Config> config_;
};

}  // namespace talus
