// What observations bring to their points besides places: the channels of a map.
#include <talus/map_view.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/observation_points.h>
#include <talus/mrpt/version_compat.h>

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>

#include "log_files.h"
#include "velodyne_packets.h"

using namespace mrpt::obs;
using talus::SensorPoints;
using namespace talus::test;

namespace
{
using Values = std::vector<float>;

/** The values of that name; each as many as there are points, or none. */
Values values_of(const CObservation& obs, const std::string& name = "intensity")
{
  SensorPoints points;
  points.channel_names = {"nothing", name};
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(talus::points_from_observation(obs, points));
  EXPECT_EQ(points.channels.size(), 2U);
  EXPECT_TRUE(points.channels[0].empty());
  const Values& values = points.channels[1];
  EXPECT_TRUE(values.empty() || values.size() == points.x_m.size());
  const auto frame = talus::frame_from(points, {});
  EXPECT_EQ(frame.channels[0], nullptr);
  EXPECT_EQ(frame.channels[1], values.empty() ? nullptr : values.data());
  return values;
}
}  // namespace

TEST(ChannelsOfAnObservation, AreTheIntensitiesOfACloud)
{
  auto obs = observation_at<CObservationPointCloud>(1);
  const auto cloud = talus::detail::make_cloud_with_intensity(2);
  for (std::size_t i = 0; i < 2; ++i)
  {
    cloud->setPointFast(i, 1, 2, 3);
    talus::detail::set_intensity(*cloud, i, 0.5F + static_cast<float>(i));
  }
  obs->pointcloud = cloud;
  EXPECT_EQ(values_of(*obs), (Values{0.5F, 1.5F}));
  EXPECT_TRUE(values_of(*obs, "red").empty());
}

TEST(ChannelsOfAnObservation, AreNoneOfACloudWithoutFields)
{
  auto obs = observation_at<CObservationPointCloud>(1);
  auto cloud = mrpt::maps::CSimplePointsMap::Create();
  cloud->insertPoint(1, 2, 3);
  obs->pointcloud = cloud;
  EXPECT_TRUE(values_of(*obs).empty());
}

#if MRPT_VERSION < 0x030000
TEST(ChannelsOfAnObservation, AreTheColoursOfACloudIn256Steps)
{
  auto obs = observation_at<CObservationPointCloud>(1);
  auto cloud = mrpt::maps::CColouredPointsMap::Create();
  cloud->resize(1);
  cloud->setPointFast(0, 1, 2, 3);
  cloud->setPointColor(0, 1, 0, 0.2F);
  obs->pointcloud = cloud;
  EXPECT_EQ(values_of(*obs, "red"), (Values{255}));
  EXPECT_EQ(values_of(*obs, "green"), (Values{0}));
  ASSERT_EQ(values_of(*obs, "blue").size(), 1U);
  EXPECT_NEAR(values_of(*obs, "blue")[0], 51, 0.01);
}
#endif

TEST(ChannelsOfAnObservation, AreTheIntensitiesOfAPlanarScanWithoutItsGaps)
{
  auto obs = observation_at<CObservation2DRangeScan>(1);
  obs->resizeScanAndAssign(3, 2.0F, true);
  EXPECT_TRUE(values_of(*obs).empty());
  obs->setScanHasIntensity(true);
  for (std::size_t i = 0; i < 3; ++i) obs->setScanIntensity(i, static_cast<int>(10 * i));
  obs->setScanRangeValidity(1, false);
  EXPECT_EQ(values_of(*obs), (Values{0, 20}));
}

TEST(ChannelsOfAnObservation, AreTheIntensitiesOfARotatingScan)
{
  auto obs = observation_at<CObservationRotatingScan>(1);
  obs->rangeImage.setZero(1, 3);
  obs->rangeResolution = 0.01;
  obs->azimuthSpan = 1;
  obs->minRange = 0;
  obs->maxRange = 100;
  obs->rangeImage(0, 0) = 100;
  obs->rangeImage(0, 2) = 200;
  EXPECT_TRUE(values_of(*obs).empty());
  obs->intensityImage.setZero(1, 3);
  obs->intensityImage(0, 0) = 7;
  obs->intensityImage(0, 2) = 250;
  EXPECT_EQ(values_of(*obs), (Values{7, 250}));
  auto& second = obs->rangeOtherLayers["SECOND"];
  second.setZero(1, 3);
  second(0, 1) = 50;
  const Values both = values_of(*obs);
  ASSERT_EQ(both.size(), 3U);
  EXPECT_TRUE(std::isnan(both[2])) << "the image is that of the first return";
}

TEST(ChannelsOfAnObservation, AreTheIntensitiesOfTheReturnsOfAVelodyne)
{
  auto scan = empty_scan(1, 1, 40, kStrongest, kVlp16, 12 * 2 * 55.296);
  scan.calibration = flat_calibration(16);
  PacketWriter packet(scan.scan_packets[0]);
  for (const int k : {0, 5, 31})
  {
    packet.set_return(2, k, 1000);
    packet.set_intensity(2, k, static_cast<std::uint8_t>(100 + k));
  }
  EXPECT_EQ(values_of(scan), (Values{100, 105, 131}));
}

TEST(ChannelsOfAnObservation, AreThoseOfAVelodyneThatWasStoredDecoded)
{
  CObservationVelodyneScan scan;
  scan.point_cloud.x = scan.point_cloud.y = scan.point_cloud.z = {1, 2};
  EXPECT_TRUE(values_of(scan).empty());
  scan.point_cloud.intensity = {3, 255};
  EXPECT_EQ(values_of(scan), (Values{3, 255}));
}

/** By the options of the map, as an INI file has them. */
TEST(ChannelsOfAnObservation, AndTheirCostsAreInTheMapOfMrpt)
{
  constexpr float kSensor_m = 0.5F;
  const auto cloud = talus::detail::make_cloud_with_intensity(61 * 61);
  for (std::size_t i = 0; i < cloud->size(); ++i)
  {
    const float x_m = 0.1F * static_cast<float>(i % 61) - 2.98F,
                y_m = 0.1F * static_cast<float>(i / 61) - 2.98F;
    cloud->setPointFast(i, x_m, y_m, -kSensor_m);
    talus::detail::set_intensity(*cloud, i, y_m < 0 ? 3.0F : 5.0F);
  }
  auto obs = observation_at<CObservationPointCloud>(1);
  obs->pointcloud = cloud;
  obs->sensorPose = mrpt::poses::CPose3D(0, 0, kSensor_m, 0, 0, 0);
  talus::CDualElevationMap map;
  talus::set_parameter(map.insertionOptions, "channels", "intensity:vote");
  talus::set_parameter(map.insertionOptions, "channel_cost", "intensity:3=0");
  ASSERT_TRUE(map.insertObservation(*obs));
  EXPECT_EQ(map.view().at("intensity", 1.02, -1.08), 3);
  EXPECT_EQ(map.view().at("intensity", 1.02, 1.02), 5);
  EXPECT_EQ(map.view().at(talus::Layer::Traversability, 1.02, -1.08), 0);
  EXPECT_GT(map.view().at(talus::Layer::Traversability, 1.02, 1.02), 0.9F);
}
