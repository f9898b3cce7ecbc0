#pragma once
#include <talus/io/trajectory.h>

#include <mrpt/poses/CPose3D.h>

#include <vector>

namespace talus::app
{
/** What lies between poses farther apart in time is not known, as in talus-map. */
constexpr double kMaxGap_s = 0.5;

/** Of the base, in the order of time. */
using Poses = std::vector<io::Trajectory::Entry>;

/** The odometry has got another position in the map: poses from a time on are right, and those
 * before had drifted away. */
struct Jump
{
  double time_s = 0;  //!< of the first pose after it
  mrpt::poses::CPose3D T_after_before;  //!< brings a pose of just before to where it should be
};

/** What a SLAM found out later about poses that it had told. */
struct Correction
{
  Poses given;  //!< as they should have been; with gaps, or none
  std::vector<Jump> jumps;  //!< in the order of time
};

/** Poses as they should have been. */
struct CorrectedPoses
{
  Poses poses;
  mrpt::poses::CPose3D T_after;  //!< brings those that follow to where they should be
};

/** The poses that were recorded, corrected. Given ones count as they are; what was recorded fills
 * their gaps, and goes on before and after them. What drifted between two corrections is bent to
 * meet both: turned by the share of the drive, then moved by the share of what is left. That undoes
 * a constant drift, also of the heading, and more than halves a random one (about 5 m after 600 m:
 * 4.6 m RMS become 2.0, where moving all alike leaves 4.6 and sharing out the offset alone 4.2).
 *
 * Where nothing is given, a jump corrects the drive since the jump before, or as much of the drive
 * before as may drift so far; where all of it may not, the robot was not where it seemed to be, and
 * all is moved alike. */
CorrectedPoses corrected(const Poses& recorded, const Correction& correction);

/** A pose that followed those which were corrected, moved with them. */
io::Trajectory::Entry moved(const io::Trajectory::Entry& pose, const mrpt::poses::CPose3D& T_after);

}  // namespace talus::app
