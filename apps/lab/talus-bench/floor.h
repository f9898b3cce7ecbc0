#pragma once
#include "setting.h"

#include <optional>
#include <vector>

namespace talus::bench
{
/** The least that any mapper must do for a frame on one core: transform and bin its points, and
 * pass once over the window for each layer that goes back. What each line's time is compared with;
 * timed in the same run, a few times between the frames, so that both meet the same machine. */
class CpuFloor
{
 public:
  explicit CpuFloor(const Setting& setting);

  /** Times both loops, warm. */
  void sample();

  /// @name Medians over all samples [s]
  /// @{
  double points_s() const;  //!< transform and bin the points of one scan
  double pass_s() const;  //!< one pass over the window
  double frame_s() const;  //!< the points, and a pass for each layer
  /// @}

 private:
  void transform_and_bin();
  void pass();

  const Setting& setting_;
  std::vector<int> count_;
  std::vector<float> height_, out_;
  std::vector<double> points_samples_s_, pass_samples_s_;
};

/** On the device: a graph with one upload of the points, as many empty kernels as a frame has
 * stages and passes, and one download of the layers; pinned memory. Median [s], or nothing where
 * there is no device. */
std::optional<double> cuda_floor_s(std::size_t points, int cells, int layers);

}  // namespace talus::bench
