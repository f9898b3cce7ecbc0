#include <talus/mrpt/observation_points.h>

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <cmath>

#include "velodyne_packets.h"

using namespace mrpt::obs;
using mrpt::poses::CPose3D;
using talus::points_from_observation;
using talus::SensorPoints;
using namespace talus::test;

namespace
{
const CPose3D kMounting(0.1, -0.2, 1.5, 0.3, 0.2, 0.1);

SensorPoints points_of(const CObservation& obs)
{
  SensorPoints points;
  EXPECT_TRUE(points_from_observation(obs, points));
  EXPECT_EQ(points.x_m.size(), points.y_m.size());
  EXPECT_EQ(points.x_m.size(), points.z_m.size());
  EXPECT_TRUE(points.time_s.empty() || points.time_s.size() == points.x_m.size());
  return points;
}

void expect_point(const SensorPoints& p, std::size_t i, double x, double y, double z, double tol)
{
  ASSERT_LT(i, p.x_m.size());
  EXPECT_NEAR(p.x_m[i], x, tol) << "point " << i;
  EXPECT_NEAR(p.y_m[i], y, tol) << "point " << i;
  EXPECT_NEAR(p.z_m[i], z, tol) << "point " << i;
}

}  // namespace

TEST(PointsFromAnyObservation, LeaveTheOutputAloneWhenTheClassIsNotSupported)
{
  SensorPoints points;
  points.x_m = {1};
  points.stamp_s = 5;
  EXPECT_FALSE(points_from_observation(*observation_at<CObservationOdometry>(1), points));
  EXPECT_EQ(points.x_m.size(), 1u);
  EXPECT_EQ(points.stamp_s, 5);
}

TEST(PointsFromAnyObservation, ReplaceThoseOfTheObservationBefore)
{
  auto scan = observation_at<CObservation2DRangeScan>(7);
  scan->resizeScanAndAssign(3, 2.0f, true);
  SensorPoints points;
  points.time_s = {1, 2, 3, 4};
  for (int i = 0; i < 2; ++i)
  {
    ASSERT_TRUE(points_from_observation(*scan, points));
    EXPECT_EQ(points.x_m.size(), 3u);
    EXPECT_TRUE(points.time_s.empty());
    EXPECT_DOUBLE_EQ(points.stamp_s, 7);
  }
}

TEST(PointsFromAPointCloud, StayInTheSensorFrameWithTheMountingBesideThem)
{
  auto obs = observation_at<CObservationPointCloud>(1300000000.25);
  auto map = mrpt::maps::CSimplePointsMap::Create();
  map->insertPoint(1, 2, 3);
  map->insertPoint(std::nanf(""), 0, 0);
  map->insertPoint(0, 0, 0);
  obs->pointcloud = map;
  obs->sensorPose = kMounting;
  const auto points = points_of(*obs);
  ASSERT_EQ(points.x_m.size(), 3u);  // what is not finite or zero is for the map to count
  expect_point(points, 0, 1, 2, 3, 0);
  EXPECT_TRUE(std::isnan(points.x_m[1]));
  EXPECT_EQ(points.T_base_sensor, kMounting);
  EXPECT_NEAR(points.stamp_s, 1300000000.25, 1e-6);
}

TEST(FrameFromPoints, TellsWhereTheSensorIsOnTheRobotAndInTheMap)
{
  mrpt::obs::CObservationPointCloud obs;
  obs.sensorLabel = "rear";
  obs.sensorPose = kMounting;
  obs.pointcloud = mrpt::maps::CSimplePointsMap::Create();
  obs.pointcloud->insertPointFast(1, 2, 3);
  const SensorPoints points = points_of(obs);
  EXPECT_EQ(points.sensor_label, "rear");
  const CPose3D T_map_base(4, 5, 6, 0.7, 0, 0);
  const talus::Frame frame = talus::frame_from(points, T_map_base);
  ASSERT_TRUE(frame.T_base_sensor);
  EXPECT_EQ(frame.T_base_sensor->m, talus::pose_from(kMounting).m);
  EXPECT_EQ(frame.T_map_sensor.m, talus::pose_from(T_map_base + kMounting).m);
}

TEST(SensorNumbers, AreGivenInTheOrderOfTheLabels)
{
  talus::SensorNumbers sensors(std::vector<std::string>{"front"});
  EXPECT_EQ(sensors.number_of("rear"), 1u);
  EXPECT_EQ(sensors.number_of("front"), 0u);
  EXPECT_EQ(sensors.number_of(""), 2u);
  EXPECT_EQ(sensors.number_of("rear"), 1u);
  for (int i = 3; i < 64; i++) sensors.number_of("sensor " + std::to_string(i));
  EXPECT_THROW(sensors.number_of("one more"), std::invalid_argument);
  EXPECT_EQ(sensors.number_of("sensor 63"), 63u);
}

TEST(PointsFromAPointCloud, AreRefusedWhenThereIsNoCloud)
{
  const auto obs = observation_at<CObservationPointCloud>(1, "lidar");
  expect_refused(*obs, {"CObservationPointCloud", "'lidar'", "no point cloud"});
}

TEST(PointsFromAPointCloud, AreAllThereInARecordedScan)
{
  const auto path = real_data("offroad_a.rawlog");
  TALUS_SKIP_WITHOUT(path);
  EXPECT_GT(points_of(*first_of<CObservation>(path)).x_m.size(), 50000u);
}

TEST(PointsFromA2DScan, LieInItsPlaneFromRightToLeft)
{
  auto obs = observation_at<CObservation2DRangeScan>(1);
  obs->aperture = static_cast<float>(M_PI);
  obs->resizeScanAndAssign(5, 2.0f, true);
  obs->setScanRangeValidity(1, false);
  obs->sensorPose = kMounting;
  const auto points = points_of(*obs);
  ASSERT_EQ(points.x_m.size(), 4u);  // the ray without a return gives none
  expect_point(points, 0, 0, -2, 0, 1e-6);
  expect_point(points, 1, 2, 0, 0, 1e-6);
  expect_point(points, 2, std::sqrt(2.0), std::sqrt(2.0), 0, 1e-6);
  expect_point(points, 3, 0, 2, 0, 1e-6);
  EXPECT_EQ(points.T_base_sensor, kMounting);
}

TEST(PointsFromA2DScan, DescendWhileTheScannerNodsDown)
{
  auto obs = observation_at<CObservation2DRangeScan>(1);
  obs->aperture = static_cast<float>(M_PI / 2);
  obs->deltaPitch = 0.2;
  obs->resizeScanAndAssign(3, 2.0f, true);
  const auto points = points_of(*obs);
  const double q = std::sqrt(2.0);  // x and |y| of the outer rays
  expect_point(points, 0, q, -q, 0, 1e-6);
  expect_point(points, 1, 2 * std::cos(0.1), 0, -2 * std::sin(0.1), 1e-6);
  expect_point(points, 2, q * std::cos(0.2), q, -q * std::sin(0.2), 1e-6);
}

namespace
{
CObservation3DRangeScan::Ptr depth_camera(int rows, int columns, std::uint16_t units)
{
  auto obs = observation_at<CObservation3DRangeScan>(1, "depth");
  obs->hasRangeImage = true;
  obs->rangeImage_setSize(rows, columns);
  obs->rangeImage.fill(units);
  obs->rangeUnits = 0.001f;
  auto& camera = obs->cameraParams;
  camera.ncols = static_cast<std::uint32_t>(columns);
  camera.nrows = static_cast<std::uint32_t>(rows);
  camera.setIntrinsicParamsFromValues(100, 100, (columns - 1) / 2.0, (rows - 1) / 2.0);
  obs->sensorPose = kMounting;
  return obs;
}
}  // namespace

TEST(PointsFromADepthCamera, AreOneAPixelOnAWallAhead)
{
  for (const int columns : {16, 13})
  {
    const auto obs = depth_camera(9, columns, 3000);
    const auto points = points_of(*obs);
    ASSERT_EQ(points.x_m.size(), static_cast<std::size_t>(9 * columns));
    for (std::size_t i = 0; i < points.x_m.size(); ++i)
    {
      const int row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
      const double right = (column - (columns - 1) / 2.0) / 100, down = (row - 4) / 100.0;
      expect_point(points, i, 3, -3 * right, -3 * down, 1e-5);
    }
    EXPECT_EQ(points.T_base_sensor, kMounting);
  }
}

TEST(PointsFromADepthCamera, LieOnASphereWhenItsRangesAreDistances)
{
  const auto obs = depth_camera(9, 16, 3000);
  obs->range_is_depth = false;
  const auto points = points_of(*obs);
  ASSERT_EQ(points.x_m.size(), 9u * 16u);
  for (std::size_t i = 0; i < points.x_m.size(); ++i)
    EXPECT_NEAR(std::hypot(points.x_m[i], points.y_m[i], points.z_m[i]), 3, 1e-5);
}

TEST(PointsFromADepthCamera, SkipPixelsWithoutAReturnAndAddFurtherReturns)
{
  const auto obs = depth_camera(2, 2, 1000);
  obs->rangeImage(0, 0) = 0;
  auto& second = obs->rangeImageOtherLayers["LAST"];
  second.resize(2, 2);
  second.fill(1000);
  second(1, 1) = 2000;  // the other pixels report their only return again
  second(0, 0) = 0;
  const auto points = points_of(*obs);
  ASSERT_EQ(points.x_m.size(), 4u);
  EXPECT_NEAR(points.x_m[3], 2, 1e-6);
}

TEST(PointsFromADepthCamera, AreThoseStoredWhenThereIsNoRangeImage)
{
  auto obs = observation_at<CObservation3DRangeScan>(1);
  obs->hasPoints3D = true;
  obs->resizePoints3DVectors(1);
  obs->points3D_x[0] = 1;
  obs->points3D_y[0] = 2;
  obs->points3D_z[0] = 3;
  expect_point(points_of(*obs), 0, 1, 2, 3, 0);
}

TEST(PointsFromADepthCamera, AreRefusedWithoutDataOrWithTheWrongResolution)
{
  expect_refused(
      *observation_at<CObservation3DRangeScan>(1, "cam"), {"'cam'", "neither a range image"});
  const auto obs = depth_camera(4, 4, 1000);
  obs->cameraParams.ncols = 8;
  expect_refused(*obs, {"'depth'", "resolution"});
}

TEST(PointsFromADepthCamera, AreAllPixelsOfTheStockImage)
{
  const auto path = stock_dataset("tests_rgbd.rawlog");
  TALUS_SKIP_WITHOUT(path);
  const auto first = first_of<CObservation3DRangeScan>(path);
  const CObservation3DRangeScan& obs = *first;
  std::size_t returns = 0;
  for (int r = 0; r < obs.rangeImage.rows(); ++r)
    for (int c = 0; c < obs.rangeImage.cols(); ++c) returns += obs.rangeImage(r, c) != 0;
  const auto points = points_of(obs);
  EXPECT_EQ(points.x_m.size(), returns);
  EXPECT_EQ(points.x_m.size(), 273225u);
  // MRPT's points are stored beside it, made without the lens distortion: 4 mm in the corners.
  for (std::size_t i = 0; i < points.x_m.size(); i += 997)
    expect_point(points, i, obs.points3D_x[i], obs.points3D_y[i], obs.points3D_z[i], 5e-3);
}
