// Hints about motion: what frames from different positions, and in turns, show of poses and clocks.
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

#include "judge.h"
#include "thresholds.h"

namespace talus::hints
{
namespace
{
std::string degrees(double rad) { return fixed_text(rad * 180 / M_PI, 0) + " degrees"; }
std::string metres(double m) { return fixed_text(m, 2) + " m"; }

/** What walls show of the times of one sensor's scans. */
std::optional<Hint> wrong_times_of(const SensorFigures& s)
{
  const double now_m = s.lag.apart_m({});
  if (!(now_m > kMinWallsApart_m)) return {};
  Lag backwards;
  backwards.times = -1;
  backwards = s.lag.best_clock(backwards, &Lag::late_s, kMaxLate_s);
  const Lag clock = s.lag.best_clock({}, &Lag::late_s, kMaxLate_s), sweep = s.lag.best_sweep(),
            growth = s.lag.best_clock({}, &Lag::grown_s, kMaxGrown_s);
  const double clock_m = s.lag.apart_m(clock), sweep_m = s.lag.apart_m(sweep),
               growth_m = s.lag.apart_m(growth), backwards_m = s.lag.apart_m(backwards);
  const std::string seen =
      "walls that are seen in different turns lie " + metres(now_m) + " apart, and ";
  if (!s.is_deskewed && sweep_m < kSweepFits * std::min(now_m, clock_m))
  {
    const double turned_rad = s.lag.fastest_rps() * std::abs(sweep.sweep_s);
    if (turned_rad < kMinSkew_deg * M_PI / 180) return {};
    return Hint{
        Kind::NotDeskewed, "the scans are not deskewed: the robot turns by up to " +
                               degrees(turned_rad) + " during a sweep; " + seen + metres(sweep_m) +
                               " where each point has its own time: record the times of the "
                               "points (talus-map deskews scans that have them), or turn slower"};
  }
  if (s.is_deskewed && backwards_m < kSweepFits * std::min({now_m, clock_m, growth_m}))
    return Hint{
        Kind::NotDeskewed,
        "the times of the points run backwards: " + seen + metres(backwards_m) +
            " where the last point of a scan is its first: mend them in the driver of the scanner"};
  if (growth_m < kClockFits * now_m && growth_m < kGrowthFits * clock_m)
    return Hint{
        Kind::LateClock, "the clock of the scans runs " +
                             fixed_text(100 * std::abs(growth.grown_s) / s.lag.duration_s(), 1) +
                             " % " + (growth.grown_s > 0 ? "fast" : "slow") +
                             " against that of the poses: " + seen + metres(growth_m) +
                             " without it: record both by one clock"};
  if (clock_m > kClockFits * now_m || std::abs(clock.late_s) < kMinLate_s) return {};
  return Hint{
      Kind::LateClock, "the clock of the scans is " + fixed_text(std::abs(clock.late_s), 2) +
                           " s " + (clock.late_s > 0 ? "late" : "early") +
                           " against that of the poses: " + seen + metres(clock_m) +
                           " without it: talus-calibrate says how to shift the stamps"};
}
}  // namespace

std::optional<Hint> wrong_axes(const Figures& f)
{
  for (const SensorFigures& s : f.sensors)
  {
    if (s.axes.speed_mps() > kFastest_mps)
      return Hint{
          Kind::WrongAxes, "the robot drives at " + fixed_text(s.axes.speed_mps(), 0) +
                               " m/s: are the positions of the poses in millimetres or "
                               "centimetres? They are read as metres"};
    if (s.axes.apart_standing_m() > kMinMovedWalls_m)
      return Hint{
          Kind::WrongAxes,
          "the robot stands still by its poses, and walls move in the scans, by " +
              metres(s.axes.apart_standing_m()) +
              " on average: are these the poses of this log, in metres? Pass those of the drive "
              "(--trajectory), not --static"};
    if (f.level.climb_m() > std::max(kMinClimb_m, s.axes.path_m()))
      return Hint{
          Kind::WrongAxes,
          "the robot moves up and down by " + metres(f.level.climb_m()) + ", and " +
              metres(s.axes.path_m()) +
              " seen from above: are the axes of the poses those of a camera, whose z points "
              "ahead? z of the map points up"};
    if (s.axes.apart_without_yaw_m() > kMinMovedWalls_m)
      return Hint{
          Kind::WrongAxes,
          "the path turns and the heading stays, and walls lie " +
              metres(s.axes.apart_without_yaw_m()) +
              " apart on average: the poses have no yaw: give a trajectory with the full attitude "
              "(--trajectory)"};
    auto fit = s.axes.better_axes();
    if (!fit) fit = s.axes.better_scale();
    if (fit)
      return Hint{
          Kind::WrongAxes, "walls that are seen from different positions lie " +
                               metres(fit->given_m) + " apart, and " + metres(fit->best_m) +
                               " if " + fit->change +
                               ": check the columns, the unit and the frame of the trajectory, "
                               "and the yaw of sensorPose (--mount)"};
    const auto motions = s.axes.better_motions();
    if (auto times = motions ? wrong_times_of(s) : std::nullopt) return times;
    if (motions)
      return Hint{
          Kind::WrongAxes, "walls lie " + metres(motions->given_m) +
                               " apart from frame to frame by the poses, and " +
                               metres(motions->best_m) +
                               " where the frames are laid upon each other: are these the poses of "
                               "this log, in metres, "
                               "by the clock of its scans? Pass those (--trajectory)"};
  }
  return {};
}

std::optional<Hint> sideways(const Figures& f)
{
  for (const SensorFigures& s : f.sensors)
    if (const auto angle = s.axes.sideways_rad();
        angle && std::abs(*angle) > kMinSideways_deg * M_PI / 180)
      return Hint{
          Kind::Sideways, "the robot drives sideways to its heading, at " + degrees(*angle) +
                              " to the x axis of the base: unless it can, the yaw of a mounting "
                              "(--mount) or of the poses is off by that, or x and y are swapped"};
  return {};
}

std::optional<Hint> pose_jumps(const Figures& f)
{
  const PoseWatch& p = f.poses;
  if (p.jumps() == 0) return {};
  const std::string times = std::to_string(p.jumps()) + (p.jumps() == 1 ? " time" : " times");
  return Hint{
      Kind::PoseJumps, "the poses jump " + times + ", the farthest by " + metres(p.jump_m()) +
                           " and " + fixed_text(p.jump_deg(), 0) + " degrees at " +
                           fixed_text(p.jump_stamp_s(), 3) +
                           " s: smooth the trajectory (--trajectory), or cut the log there"};
}

std::optional<Hint> level_poses(const Figures& f)
{
  const LevelWatch& w = f.level;
  const std::string mend =
      ": the poses have no pitch and roll: give a trajectory with the full attitude (--trajectory)";
  const double slope_rad = w.path_slope_rad();
  const bool climbs = slope_rad > kMinPathSlope_deg * M_PI / 180 &&
                      slope_rad > kSlopeOverNoise * w.noise_slope_rad();
  if (w.pieces() >= kMinPieces && climbs && w.pose_share() < kLevelPoses &&
      w.ground_share() < kLevelGround)
    return Hint{
        Kind::LevelPoses, "the path climbs and falls by " + fixed_text(slope_rad * 180 / M_PI, 0) +
                              " degrees (root mean square), and the poses lean by " +
                              fixed_text(100 * w.pose_share(), 0) + " % of that" +
                              (w.pose_share() > -kLevelPoses
                                   ? mend
                                   : ": x or the pitch of the poses is mirrored: check the axes of "
                                     "the trajectory")};
  const bool is_flat = w.climb_m() < kFlat_m && w.most_lean_rad() < kFlat_deg * M_PI / 180;
  if (is_flat && contradiction(f))
    return Hint{
        Kind::LevelPoses,
        "the poses stay level and at one height, and frames see the same ground " +
            metres(f.ground.difference_m()) + " apart: the ground is not level" + mend};
  return {};
}

std::optional<Hint> wrong_times(const Figures& f)
{
  for (const SensorFigures& s : f.sensors)
    if (auto hint = wrong_times_of(s)) return hint;
  return {};
}

std::optional<Hint> contradiction(const Figures& f)
{
  const ContradictionWatch& g = f.ground;
  if (g.pairs() < kMinPairs || g.difference_m() < kContradiction_m ||
      g.difference_m() < kContradictionRatio * g.spread_m())
    return {};
  return Hint{
      Kind::Contradiction,
      "scans contradict each other: frames see the same ground " + metres(g.difference_m()) +
          " apart (median of " + std::to_string(g.pairs()) + "), each within " +
          metres(g.spread_m()) +
          ": time offset, mounting or poses are wrong: talus-calibrate finds the first two"};
}

}  // namespace talus::hints
