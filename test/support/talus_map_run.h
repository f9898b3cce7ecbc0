#pragma once
// Shared by the specifications of the command talus-map: running it, and logs to feed it.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <cstdio>
#include <string>

#include "command_run.h"

namespace talus::test
{
constexpr double kFirstStamp_s = 1700000000.0;
constexpr double kSensorHeight_m = 0.5;

class TalusMap : public CommandTest
{
 protected:
  nlohmann::json summary(const std::string& folder) const { return json(folder + "/summary.json"); }

  /** How many files and folders the scratch folder holds, hidden ones included. */
  std::size_t entries() const
  {
    namespace fs = std::filesystem;
    const fs::recursive_directory_iterator all(path(""));
    return static_cast<std::size_t>(std::distance(all, fs::recursive_directory_iterator()));
  }

 private:
  /** On the CPU unless the arguments say otherwise. */
  std::string command(const std::string& arguments) const override
  {
    const bool chosen = arguments.find("--backend") != std::string::npos;
    return std::string(TALUS_MAP_EXE) + (chosen ? " " : " --backend cpu ") + arguments;
  }
};

/** A level floor at z = 0 of the base, seen from kSensorHeight_m above it. */
inline std::shared_ptr<mrpt::obs::CObservationPointCloud> floor_scan(
    double time_s, const std::string& label = "lidar")
{
  auto obs = observation_at<mrpt::obs::CObservationPointCloud>(time_s, label);
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = -30; i <= 30; ++i)
    for (int j = -30; j <= 30; ++j)
      points->insertPoint(0.1F * i + 0.02F, 0.1F * j + 0.02F, -static_cast<float>(kSensorHeight_m));
  obs->pointcloud = points;
  obs->sensorPose = mrpt::poses::CPose3D(0, 0, kSensorHeight_m, 0, 0, 0);
  return obs;
}

/** Floor scans at 10 Hz. */
inline Objects floor_scans(int count)
{
  Objects objects;
  for (int i = 0; i < count; ++i) objects.push_back(floor_scan(kFirstStamp_s + 0.1 * i));
  return objects;
}

/** A drive along x at 1 m/s as TUM text, a pose each 0.1 s. */
inline std::string straight_tum(int count, double first_stamp_s = kFirstStamp_s)
{
  std::string text = "# t x y z qx qy qz qw\n";
  for (int i = 0; i < count; ++i)
  {
    char line[120];
    std::snprintf(line, sizeof line, "%.3f %.3f 0 0 0 0 0 1\n", first_stamp_s + 0.1 * i, 0.1 * i);
    text += line;
  }
  return text;
}

}  // namespace talus::test
