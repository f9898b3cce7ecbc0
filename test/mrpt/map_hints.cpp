// CDualElevationMap tells once what looks wrongly set, and nothing where all is well.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <cmath>
#include <string>

#include "message_of.h"

using namespace talus;
using mrpt::poses::CPose3D;

namespace
{
constexpr double kHeight_m = 0.8;

/** A level floor and a post around the robot; the floor's points lie `below_m` under the sensor. */
mrpt::obs::CObservationPointCloud floor_scan(int frame, double below_m)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < 72; ++i)
    for (int ring = 0; ring < 8; ++ring)
    {
      const double angle = i * 2 * M_PI / 72, r = 1.6 + 0.5 * ring;
      points->insertPoint(
          static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
          static_cast<float>(-below_m));
    }
  for (int i = 0; i < 10; ++i) points->insertPoint(3, 1, static_cast<float>(0.1 * i - below_m));
  mrpt::obs::CObservationPointCloud obs;
  obs.pointcloud = points;
  obs.sensorLabel = "lidar";
  obs.sensorPose = CPose3D(0, 0, kHeight_m, 0, 0, 0);
  obs.timestamp = mrpt::Clock::fromDouble(1700000000.0 + 0.1 * frame);
  return obs;
}

/** What two maps say on stderr while each takes so many frames. */
std::string told(int frames, double below_m)
{
  testing::internal::CaptureStderr();
  for (int m = 0; m < 2; ++m)
  {
    CDualElevationMap map({}, Backend::Cpu);
    for (int f = 0; f < frames; ++f)
      map.insertObservation(floor_scan(f, below_m), CPose3D(0.1 * f, 0, 0, 0, 0, 0));
  }
  return testing::internal::GetCapturedStderr();
}
}  // namespace

TEST(MapHints, says_nothing_of_a_sound_configuration) { EXPECT_EQ(told(70, kHeight_m), ""); }

TEST(MapHints, says_nothing_before_it_is_certain) { EXPECT_EQ(told(20, 0), ""); }

TEST(MapHints, tells_a_cause_once)
{
  const std::string text = told(140, 0);
  const auto first = text.find("hint: ");
  ASSERT_NE(first, std::string::npos) << text;
  EXPECT_TRUE(has(text, "begin in the ground"));
  EXPECT_EQ(text.find("hint: ", first + 1), std::string::npos) << text;
}
