#pragma once
#include <talus/frame.h>
#include <talus/sim/drive.h>

#include <cstdint>
#include <optional>
#include <functional>
#include <string>
#include <vector>

namespace talus::baselines
{
/** One scan with its pose. */
struct ScanFrame
{
  double stamp_s = 0;  //!< since the epoch
  double time_s = 0;  //!< since the first frame
  Pose T_map_sensor;  //!< as the maps get it
  std::optional<Pose> T_base_sensor;  //!< where the sensor is on the robot, if that is known
  std::uint32_t sensor = 0;  //!< which of several
  std::size_t scan = 0;  //!< its number among the scans of its log, also those without a pose
  Pose T_true;  //!< where the sensor really was; the same where nobody knows better
  std::vector<float> x_m, y_m, z_m;  //!< sensor frame

  Frame view() const;
};

/** All scans of a log or of a simulated drive. */
struct Sequence
{
  std::string name;
  std::vector<ScanFrame> frames;
  std::string sensor{};  //!< what took the scans: the scanners of a world, the labels of a log
};

/** Names a sensor of the sequence, once. */
void add_sensor(Sequence& sequence, const std::string& name);

/** Scans a world. The poses have the errors of the drive's options. */
Sequence simulate(
    const sim::World& world, const sim::Drive& drive,
    const std::function<void(int done, int total)>& progress = {});

}  // namespace talus::baselines
