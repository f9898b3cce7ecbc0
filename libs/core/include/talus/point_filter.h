#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>

#include <memory>
#include <optional>

namespace talus
{
/** The map's own test of single points of a frame, for programs that must drop the same points. */
class PointFilter
{
 public:
  /** The poses of the frame, see Frame. */
  PointFilter(
      const Parameters& parameters, const Pose& T_map_sensor,
      const std::optional<Pose>& T_base_sensor);
  ~PointFilter();

  /** Whether a point of the sensor frame [m] passes range, body boxes and height band: stage 1
   * without deskewing, window and voxels. False for a point that is not finite. */
  bool accepts(float x_m, float y_m, float z_m) const;

  /** Height of a point above the sensor, along the map's z, as the height band uses it [m]. */
  float rise_m(float x_m, float y_m, float z_m) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace talus
