#pragma once
#include "../../common/command_line.h"

#include <talus/sim/drive.h>
#include <talus/sim/truth.h>

#include <functional>
#include <optional>
#include <string>

namespace talus::sim
{
/** Time stamp of the first frame of every drive [s since the epoch]. */
constexpr double kFirstStamp_s = 1700000000.0;

/** What a log says wrongly. */
struct Claims
{
  /** Added to the true mounting of each sensor. */
  std::optional<app::Mounting> mounting_error;
  double clock_error_s = 0;  //!< added to the true stamps
};

/** Every frame as a CObservationPointCloud whose label is the name of its sensor. `progress` gets
 * the frames done. Throws std::runtime_error naming the file, and what `progress` throws. */
void write_rawlog(
    const std::string& path, const World& world, const Drive& drive, const Claims& claims,
    const std::function<void(int)>& progress);

/** The base in the map at each stamp, as TUM text: the truth, or as the drive's pose errors say. */
void write_tum(const std::string& path, const Drive& drive, bool noisy);

/** Six bands: ground, obstacle_top, underside, label, covered, solid. */
void write_truth(const std::string& path, Truth truth, const World& world, double time_s);

}  // namespace talus::sim
