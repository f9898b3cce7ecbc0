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

/** What the map of a whole drive costs. */
struct WholeCost
{
  double frame_s = 0;  //!< mean processor time of a frame
  double memory_MB = 0, file_MB = 0;  //!< at the end; of the heap, and of what it is saved as
};
/** One way to map the same 100 m of road, with cells of the same size. */
struct WholeDrive
{
  std::string name;
  std::function<WholeCost()> run;
};
/** Talus and OctoMap, which gets the same scans; and once more without what lies outside of talus's
 * window, so that both know the same cells. None where talus is built without MRPT. */
std::vector<WholeDrive> whole_drives();

}  // namespace talus::bench
