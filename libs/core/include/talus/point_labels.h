#pragma once
#include <talus/elevation_mapper.h>
#include <talus/frame.h>

#include <array>
#include <cstdint>
#include <vector>

namespace talus
{
/** What the map says of a point; numbers in files: 0 is SemanticKITTI's "unlabelled". */
enum class PointLabel : std::uint32_t
{
  NotTaken = 0,  //!< the map takes no such point: it is not finite, beyond the range or the height
                 //!< band, or on the robot itself
  Ground = 1,  //!< on the ground, or on what the robot drove over
  Stands = 2,  //!< of what stands on the ground, also where the ground below it is not known
  Hangs = 3,  //!< above a gap in which the robot has room (clearance_m)
  MovedAway = 4,  //!< above the ground or above what stands there, where nothing is any more; a hit
                  //!< that the map does not believe, such as a snowflake
  BelowGround = 5,  //!< below the ground: a reflection
  Outside = 6  //!< outside of the window, or where the map knows no ground
};
constexpr int kPointLabelCount = 7;

/** Names of the labels in files. */
constexpr std::array<const char*, kPointLabelCount> kPointLabelNames{
    "not_taken", "ground", "stands", "hangs", "moved_away", "below_ground", "outside"};

/** A label for each point of a frame, in the order of its points, by the map as it is now: by both
 * surfaces of the point's cell, and by what rays and hits showed of it. So put the frame into the
 * map first. An older frame may be asked about, too; then what was there and has left since is
 * MovedAway. The map does not change, and the frame may have any pose.
 *
 * The bits are the same on cores and on devices. Points that only the voxel filter left out get a
 * label as all others. Throws as ElevationMapper::start() for a frame that is none, and
 * std::logic_error while a frame is in flight. */
std::vector<PointLabel> label_points(const ElevationMapper& map, const Frame& frame);

}  // namespace talus
