#pragma once
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** When the points of a scan were really taken: so much before its stamp, and by their direction.
 */
struct Lag
{
  double late_s = 0;  //!< the stamp is later than the first point
  double sweep_s = 0;  //!< from the first point to the last; negative: turns clockwise; 0: at once
  double first_rad = 0;  //!< direction of the first point
  double grown_s = 0;  //!< later by so much more at the last frame kept than at the first pose
  double times = 1;  //!< of the points; -1: they run backwards
};

/** Looks for scans whose times are wrong while the robot turns: walls that frames see while it
 * turns this way and that way then lie in different places. Which lag brings them together says
 * whether the clock is late, or each scan is a sweep that was taken for one moment. */
class LagWatch
{
 public:
  /** Each pose, in the order of time; true: the frame is one to look at. */
  bool wants(double stamp_s, const Pose& T_map_base);
  /** The frame that was asked for. */
  void add(std::vector<Facet> facets);

  /** Fastest turn of the frames that were kept [rad/s]. */
  double fastest_rps() const;
  /** How far walls lie apart if the scans lag by so much: mean of what counts [m]. NaN: there is
   * nothing to compare. */
  double apart_m(const Lag& lag) const;
  /** That which brings walls together best, of those that differ from this one by `changed` [s]. */
  Lag best_clock(const Lag& from, double Lag::*changed, double max_s) const;
  /** From the first pose to the last frame that was kept. */
  double duration_s() const { return kept_.back().stamp_s - path_.front().stamp_s; }
  /** The same of sweeps. */
  Lag best_sweep() const;

 private:
  struct Stop
  {
    double stamp_s, x_m, y_m, heading_rad;
  };
  struct Kept
  {
    double stamp_s, turn_rps;
    std::vector<Facet> facets;
  };
  bool keeps(double stamp_s, double turn_rps);
  Stop place_at(double stamp_s) const;
  std::vector<WallLine> lines_of(const Kept& kept, const Lag& lag) const;
  std::vector<std::size_t> partners_of(std::size_t kept) const;
  Lag refined(Lag lag, double Lag::*changed, double step_s) const;

  std::vector<Stop> path_;
  std::vector<Kept> kept_;
  std::size_t turning_ = 0, of_turn_ = 0;
  double last_rps_ = 0;
};

}  // namespace talus::hints
