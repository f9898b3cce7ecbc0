#pragma once
#include <optional>
#include <string>
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** Looks for poses whose axes are not those of the scans: a robot that drives sideways to its
 * heading, and walls that fit where y or the yaw of the poses is mirrored, x and y are swapped,
 * the sensor is turned, or they are not those of the base. */
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

  /** The same of positions in other units: of walls across the path from one frame to the other, as
   * those along it fit any. */
  std::optional<Fit> better_scale() const;

  /** The same of a path that turns while the heading stays; NaN else. */
  double apart_without_yaw_m() const;
  /** The same of frames that follow each other, laid upon each other by any motion: the median. */
  std::optional<Fit> better_motions() const;

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
    double x_mps, y_mps, turn_rps;
    std::vector<Facet> facets;
  };
  struct Change
  {
    const char* text;  //!< a number that is made of it follows; of a scale empty
    bool mirrors_y = false, mirrors_yaw = false, swaps = false;
    double turn_rad = 0, scale = 1;
    bool only_across = false;  //!< walls across the path from one frame to the other
    bool inverts = false;
    double ahead_m = 0, left_m = 0;  //!< of the base is what the poses are of
  };
  static bool is_lever(const Change& c) { return c.ahead_m != 0 || c.left_m != 0; }
  static Kept changed(const Kept& kept, const Change& change, double time_s);
  Change best_change() const;
  double apart_m(const Change& change) const;

  std::vector<Kept> kept_;
  Pose step_begin_;
  double step_begin_s_ = 0;
  Pose last_;
  double last_s_ = 0;
  std::size_t frames_ = 0;
  std::vector<float> speeds_mps_;
  double first_heading_rad_ = 0, most_turned_rad_ = 0;  //!< away from it
  double path_m_ = 0, cos_sum_ = 0, sin_sum_ = 0;  //!< of twice the angle, by path
};

}  // namespace talus::hints
