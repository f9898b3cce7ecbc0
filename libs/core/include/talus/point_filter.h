#pragma once
#include <talus/frame.h>
#include <talus/parameters.h>

#include <memory>
#include <optional>

namespace talus
{
/** The map's own test of single points of a frame, for those who must leave out what the map leaves
 * out. */
class PointFilter
{
 public:
  /** The poses are those of the frame, see Frame. */
  PointFilter(
      const Parameters& parameters, const Pose& T_map_sensor,
      const std::optional<Pose>& T_base_sensor);
  ~PointFilter();

  /** Whether a point of the sensor frame [m] passes range, body boxes and height band: stage 1 but
   * for motion during the scan and what depends on the window or on other points. False for one
   * that is not finite. */
  bool accepts(float x_m, float y_m, float z_m) const;

  /** Its height above the sensor, along the map's z: what the height band is about. */
  float rise_m(float x_m, float y_m, float z_m) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace talus
