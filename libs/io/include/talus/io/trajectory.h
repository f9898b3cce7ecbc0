#pragma once
#include <mrpt/poses/CPose3D.h>

#include <optional>
#include <string>
#include <vector>

namespace talus::io
{
/** Poses of the robot's base in the map frame over time, in ascending order of time. */
class Trajectory
{
 public:
  /** A pose at a time. */
  struct Entry
  {
    double time_s = 0;  //!< seconds since the epoch
    /** Of the base in the map frame. */
    mrpt::poses::CPose3D T_map_base;
  };

  Trajectory() = default;
  /** Sorts by time; of entries with the same time the last stays. Throws std::invalid_argument for
   * a time or a pose that is not finite. */
  explicit Trajectory(std::vector<Entry> entries);

  /** TUM text (`t x y z qx qy qz qw` a line, # comments), or an MRPT .simplemap[.gz] by its ending.
   * Throws std::runtime_error that names the file, the line and what is wrong; also where two lines
   * give different poses for one time. */
  static Trajectory load(const std::string& path);

  /** The pose at a time: interpolated (linear and slerp) between neighbours no more than
   * `max_gap_s` apart. Inside a longer gap and outside the trajectory: the pose of an entry no more
   * than 1 ms away (stamps may have been rounded), else nothing. */
  std::optional<mrpt::poses::CPose3D> at(double time_s, double max_gap_s) const;

  /** Turned about its first position until the base stands upright on average over the path, as on
   * level ground: for poses in the frame of a tilted sensor. `turned_rad` gets the angle. */
  Trajectory levelled(double& turned_rad) const;

  /** Whether it has no poses. */
  bool empty() const { return entries_.empty(); }
  /** In ascending order of time. */
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

/** A pose as a line of TUM text, with all digits; its time as logs keep it, in steps of 100 ns. */
std::string tum_line(const Trajectory::Entry& entry);
/** A pose as it is once it was written by tum_line() and read again; then it stays as it is. */
Trajectory::Entry as_in_tum(const Trajectory::Entry& entry);

}  // namespace talus::io
