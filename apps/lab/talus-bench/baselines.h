#pragma once
#include "setting.h"

#include <functional>
#include <string>
#include <vector>

namespace talus::bench
{
/** What talus is compared with. */
struct Baseline
{
  std::string name;
  std::function<double(const Setting&)> frame_s;  //!< median processor time of a frame [s]
};

/** OctoMap, CHeightGridMap2D, and a Kalman elevation map with window traversability; none where
 * talus is built without MRPT. */
std::vector<Baseline> baselines();

}  // namespace talus::bench
