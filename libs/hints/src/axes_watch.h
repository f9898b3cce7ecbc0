#pragma once
#include <optional>
#include <string>
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** Looks for poses whose axes are not those of the scans: a robot that drives sideways to its
 * heading, and walls that fit where y or the yaw of the poses is mirrored, x and y are swapped, or
 * the sensor is turned by a quarter or half. */
class AxesWatch
{
 public:
  /** Each pose, in the order of time; true: the frame is one to look at. */
  bool wants(double stamp_s, const Pose& T_map_base);
  /** The frame that was asked for. */
  void add(std::vector<Facet> facets) { kept_.back().facets = std::move(facets); }

  /** The angle between the directions in which the robot drives and its x axis, -90 to 90 degrees:
   * where it drives far enough, and always so. */
  std::optional<double> sideways_rad() const;

  /** Of walls that frames see from different positions: how far they lie apart with the poses as
   * given, and with the change of axes that fits best, in words. */
  struct Fit
  {
    double given_m, best_m;
    std::string change;
  };
  std::optional<Fit> better_axes() const;

  /** The same of positions that are multiplied: of walls across the path from one frame to the
   * other, as those along it fit any. */
  std::optional<Fit> better_scale() const;

  /** How far the walls of frames lie apart of a robot that hardly moves by its poses; NaN where it
   * does. */
  double apart_standing_m() const;
  /** Along the steps of the path, the median; 0 where there are few. */
  double speed_mps() const;
  /** Seen from above. */
  double path_m() const { return path_m_; }

 private:
  struct Kept
  {
    double x_m, y_m, heading_rad;
    std::vector<Facet> facets;
  };
  struct Change
  {
    const char* text;  //!< a number that is made of it follows
    bool mirrors_y = false, mirrors_yaw = false, swaps = false;
    double turn_rad = 0, scale = 1;
    bool only_across = false;  //!< walls across the path from one frame to the other
  };
  Change best_change() const;
  double apart_m(const Change& change) const;

  std::vector<Kept> kept_;
  Pose step_begin_;
  double step_begin_s_ = 0;
  std::size_t frames_ = 0;
  std::vector<float> speeds_mps_;
  double path_m_ = 0, cos_sum_ = 0, sin_sum_ = 0;  //!< of twice the angle, by path
};

}  // namespace talus::hints
