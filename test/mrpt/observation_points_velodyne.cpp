#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <talus/mrpt/observation_points.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <cmath>

#include "velodyne_packets.h"

using namespace mrpt::obs;
using talus::points_from_observation;
using talus::SensorPoints;
using namespace talus::test;

namespace
{
constexpr double kDegree = M_PI / 180;
constexpr double kVlp16Packet_us = 12 * 2 * 55.296;

SensorPoints points_of(const CObservation& obs)
{
  SensorPoints points;
  EXPECT_TRUE(points_from_observation(obs, points));
  EXPECT_EQ(points.time_s.size(), points.x_m.size());
  return points;
}

/** Clockwise azimuth of a point [degrees, 0..360). */
double azimuth_deg(const SensorPoints& p, std::size_t i)
{
  const double a = std::atan2(-p.y_m[i], p.x_m[i]) / kDegree;
  return a < -1e-9 ? a + 360 : a;
}

CObservationVelodyneScan vlp16_scan(int packets = 1, std::uint8_t mode = kStrongest)
{
  auto scan = empty_scan(packets, mode == kDual ? 2 : 1, 40, mode, kVlp16, kVlp16Packet_us);
  scan.calibration = flat_calibration(16);
  return scan;
}

void set_all_returns(CObservationVelodyneScan& scan, std::uint16_t range)
{
  for (auto& packet : scan.scan_packets)
    for (int b = 0; b < 12; ++b)
      for (int k = 0; k < 32; ++k) PacketWriter(packet).set_return(b, k, range);
}

}  // namespace

TEST(PointsFromAVlp16, AreAll32ReturnsOfABlockEachWithItsAzimuthAndTime)
{
  auto scan = vlp16_scan(2);
  set_all_returns(scan, 5000);
  const auto points = points_of(scan);
  ASSERT_EQ(points.x_m.size(), 2u * 12 * 32);
  for (std::size_t i = 0; i < points.x_m.size(); ++i)
  {
    const std::size_t block = i / 32, k = i % 32;
    const double delay_us =
        55.296 * static_cast<double>(k / 16) + 2.304 * static_cast<double>(k % 16);
    const double time_us = 110.592 * static_cast<double>(block) + delay_us;
    // 1 us: the clock of the sensor counts whole microseconds.
    EXPECT_NEAR(points.time_s[i], time_us * 1e-6, 1e-6);
    EXPECT_NEAR(azimuth_deg(points, i), 0.4 * time_us / 110.592, 1e-4);
    EXPECT_NEAR(std::hypot(points.x_m[i], points.y_m[i]), 10, 1e-5);
  }
}

TEST(PointsFromAVlp16, AreFullDensityInTheStockLog)
{
  const auto path = stock_dataset("test_velodyne_VLP16.rawlog");
  TALUS_SKIP_WITHOUT(path);
  const auto scan = first_of<CObservationVelodyneScan>(path);
  const auto points = points_of(*scan);
  EXPECT_EQ(points.x_m.size(), 22591u);
  EXPECT_NEAR(points.T_base_sensor.z(), 0.09, 1e-6);
  const auto [first, last] = std::minmax_element(points.time_s.begin(), points.time_s.end());
  EXPECT_NEAR(*first, 0, 120e-6);  // the first block has its first return within 0.11 ms
  EXPECT_NEAR(*last, 0.0995, 0.0005);  // one turn at 10 Hz
}

/** MRPT takes the first firing of every block: those points must be the same. Its azimuths are
 * rounded to 0.01 degrees and looked up in a table 0.01 degrees off: 0.02 degrees of the range. */
TEST(PointsFromAVlp16, AgreeWithMrptWhereMrptDecodesThem)
{
  const auto path = stock_dataset("test_velodyne_VLP16.rawlog");
  TALUS_SKIP_WITHOUT(path);
  auto scan = first_of<CObservationVelodyneScan>(path);
  for (auto& packet : scan->scan_packets)
    for (int b = 0; b < 12; ++b)
      for (int k = 16; k < 32; ++k) PacketWriter(packet).set_return(b, k, 0);
  const auto points = points_of(*scan);

  CObservationVelodyneScan::TGeneratePointCloudParameters keep_all;
  keep_all.generatePerPointTimestamp = true;
  scan->generatePointCloud(keep_all);
  const auto& theirs = scan->point_cloud;
  ASSERT_EQ(points.x_m.size(), theirs.x.size());
  for (std::size_t i = 0; i < theirs.x.size(); ++i)
  {
    const double range = std::hypot(theirs.x[i], theirs.y[i], theirs.z[i]);
    const double off = std::hypot(
        points.x_m[i] - theirs.x[i], points.y_m[i] - theirs.y[i], points.z_m[i] - theirs.z[i]);
    ASSERT_LT(off, 0.02 * kDegree * range + 1e-4) << "point " << i << " at " << range << " m";
  }
}

TEST(PointsFromAVlp16, UseTheCalibrationOfTheObservation)
{
  auto scan = vlp16_scan();
  auto& laser = scan.calibration.laser_corrections[0];
  laser.verticalCorrection = 30;
  laser.sinVertCorrection = 0.5;
  laser.cosVertCorrection = std::sqrt(0.75);
  laser.distanceCorrection = 2;
  laser.verticalOffsetCorrection = 0.1;
  laser.horizontalOffsetCorrection = 0.2;
  laser.azimuthCorrection = 90;
  PacketWriter(scan.scan_packets[0]).set_return(0, 0, 4000);  // 8 m + 2 m
  const auto p = points_of(scan);
  ASSERT_EQ(p.x_m.size(), 1u);
  // Block azimuth 0 less 90 degrees clockwise is 90 degrees to the left.
  EXPECT_NEAR(p.y_m[0], 10 * std::sqrt(0.75) - 0.1 * 0.5, 1e-5);
  EXPECT_NEAR(p.x_m[0], -0.2, 1e-5);
  EXPECT_NEAR(p.z_m[0], 10 * 0.5 + 0.1 * std::sqrt(0.75), 1e-5);
}

TEST(PointsFromAVlp16, ReadCorrectionsInRadiansWhenTheElevationsAreInRadians)
{
  auto scan = vlp16_scan();
  for (auto& laser : scan.calibration.laser_corrections)
  {
    laser.verticalCorrection = 0.25;
    laser.sinVertCorrection = std::sin(0.25);
    laser.cosVertCorrection = std::cos(0.25);
    laser.azimuthCorrection = -0.5;
  }
  PacketWriter(scan.scan_packets[0]).set_return(0, 0, 4000);
  EXPECT_NEAR(azimuth_deg(points_of(scan), 0), 0.5 / kDegree, 1e-4);
}

TEST(PointsFromAVlp16, UseTheDefaultCalibrationOfTheModelWhenNoneWasRecorded)
{
  auto scan = vlp16_scan();
  scan.calibration.clear();
  PacketWriter(scan.scan_packets[0]).set_return(0, 0, 5000);
  const auto p = points_of(scan);
  EXPECT_NEAR(p.z_m[0], -10 * std::sin(15 * kDegree), 1e-5);
}

TEST(PointsFromAVlp16, StayInsideTheRangesThatTheObservationStates)
{
  auto scan = vlp16_scan();
  PacketWriter writer(scan.scan_packets[0]);
  writer.set_return(0, 0, 249);  // 0.498 m
  writer.set_return(0, 1, 250);
  writer.set_return(0, 2, 50000);
  writer.set_return(0, 3, 50001);  // 100.002 m
  EXPECT_EQ(points_of(scan).x_m.size(), 2u);
}

TEST(PointsFromAVlp16, HoldBothReturnsOfARayButNoneTwice)
{
  auto scan = vlp16_scan(1, kDual);
  PacketWriter writer(scan.scan_packets[0]);
  writer.set_return(4, 20, 3000);  // one echo, reported twice
  writer.set_return(5, 20, 3000);
  writer.set_return(6, 7, 4000);  // two echoes of the same ray
  writer.set_return(7, 7, 2000);
  const auto p = points_of(scan);
  ASSERT_EQ(p.x_m.size(), 3u);
  EXPECT_NEAR(p.time_s[0], (2 * 110.592 + 55.296 + 4 * 2.304) * 1e-6, 1e-9);
  EXPECT_EQ(p.time_s[1], p.time_s[2]);
  EXPECT_NEAR(p.time_s[1], (3 * 110.592 + 7 * 2.304) * 1e-6, 1e-9);
  EXPECT_NEAR(azimuth_deg(p, 1), 3 * 0.4 + 0.4 * 7 * 2.304 / 110.592, 1e-4);
  EXPECT_NEAR(azimuth_deg(p, 2), azimuth_deg(p, 1), 1e-4);
}

TEST(PointsFromAVlp16, KeepTheirTimesWhenTheClockOfTheSensorStartsANewHourOrStandsStill)
{
  auto scan = vlp16_scan(2);
  set_all_returns(scan, 5000);
  const auto time_of_second_s = [&](std::uint32_t first_us, std::uint32_t second_us)
  {
    PacketWriter(scan.scan_packets[0]).set_tail(first_us, kStrongest, kVlp16);
    PacketWriter(scan.scan_packets[1]).set_tail(second_us, kStrongest, kVlp16);
    return points_of(scan).time_s[12 * 32];
  };
  EXPECT_NEAR(time_of_second_s(3599999000u, 327), 1327e-6, 1e-9);
  EXPECT_NEAR(time_of_second_s(0, 0), kVlp16Packet_us * 1e-6, 1e-9);
}

TEST(PointsFromAVlp16, TurnOverNorthWithoutAJump)
{
  auto scan = vlp16_scan();
  PacketWriter writer(scan.scan_packets[0]);
  for (int b = 0; b < 12; ++b)
    writer.set_block(b, kUpperBank, static_cast<std::uint16_t>((35800 + 40 * b) % 36000));
  set_all_returns(scan, 5000);
  const auto p = points_of(scan);
  for (std::size_t i = 0; i < p.x_m.size(); ++i)
  {
    const double expected = 358 + 0.4 * p.time_s[i] / 110.592e-6;
    EXPECT_NEAR(std::remainder(azimuth_deg(p, i) - expected, 360), 0, 1e-3);
  }
}

TEST(PointsFromAVlp16, LeaveOutBlocksThatAreDamaged)
{
  auto scan = vlp16_scan();
  set_all_returns(scan, 5000);
  PacketWriter(scan.scan_packets[0]).set_block(3, 0x1234, 120);
  PacketWriter(scan.scan_packets[0]).set_block(5, kUpperBank, 65535);
  EXPECT_EQ(points_of(scan).x_m.size(), 10u * 32);
}

TEST(PointsFromAVelodyne, AreRefusedWhenTheyCannotBeDecoded)
{
  auto scan = vlp16_scan();
  scan.sensorLabel = "top";
  scan.calibration = flat_calibration(7);
  expect_refused(scan, {"CObservationVelodyneScan", "'top'", "7 lasers"});

  scan.calibration.clear();
  PacketWriter(scan.scan_packets[0]).set_tail(0, kStrongest, 0x99);
  expect_refused(scan, {"'top'", "no calibration", "153"});

  scan.calibration = flat_calibration(16);
  std::memset(static_cast<void*>(scan.scan_packets.data()), 0, sizeof scan.scan_packets[0]);
  expect_refused(scan, {"'top'", "none of its 1 packets"});
}

TEST(PointsFromAVelodyne, AreThoseStoredWhenThePacketsAreGone)
{
  CObservationVelodyneScan scan;
  scan.point_cloud.x = {1, 4};
  scan.point_cloud.y = {2, 5};
  scan.point_cloud.z = {3, 6};
  scan.point_cloud.timestamp = {scan.timestamp, scan.timestamp + std::chrono::milliseconds(20)};
  const auto p = points_of(scan);
  ASSERT_EQ(p.x_m.size(), 2u);
  EXPECT_EQ(p.z_m[1], 6);
  EXPECT_NEAR(p.time_s[1], 0.02, 1e-7);
}

TEST(PointsFromAnHdl32, FireOneAfterTheOtherDuringABlock)
{
  auto scan = empty_scan(2, 1, 16, kStrongest, kHdl32, 12 * 46.08);
  scan.calibration = flat_calibration(32);
  set_all_returns(scan, 5000);
  const auto p = points_of(scan);
  ASSERT_EQ(p.x_m.size(), 2u * 12 * 32);
  for (std::size_t i = 0; i < p.x_m.size(); ++i)
  {
    const double time_us =
        46.08 * static_cast<double>(i / 32) + 1.152 * static_cast<double>(i % 32);
    EXPECT_NEAR(p.time_s[i], time_us * 1e-6, 1e-6);
    EXPECT_NEAR(azimuth_deg(p, i), 0.16 * time_us / 46.08, 1e-4);
  }
}

TEST(PointsFromAnHdl32, UseItsOwnElevationForEachLaser)
{
  auto scan = empty_scan(1, 1, 16, kStrongest, kHdl32, 0);
  scan.calibration = VelodyneCalibration::LoadDefaultCalibration("HDL32");
  ASSERT_EQ(scan.calibration.laser_corrections.size(), 32u);
  set_all_returns(scan, 5000);
  const auto p = points_of(scan);
  EXPECT_NEAR(p.z_m[0], -10 * std::sin(30.67 * kDegree), 1e-4);
  EXPECT_NEAR(p.z_m[31], 10 * std::sin(10.67 * kDegree), 1e-4);
}

TEST(PointsFromAnHdl64, ComeFromTwoBanksThatShareAnAzimuth)
{
  auto scan = empty_scan(1, 2, 17, 0, 0, 0, kLowerBank);
  scan.calibration = flat_calibration(64);
  auto& upper = scan.calibration.laser_corrections[3];
  auto& lower = scan.calibration.laser_corrections[35];
  upper.sinVertCorrection = 0.6;
  upper.cosVertCorrection = 0.8;
  lower.sinVertCorrection = -0.8;
  lower.cosVertCorrection = 0.6;
  lower.azimuthCorrection = 5;  // degrees
  for (int b = 0; b < 12; ++b) PacketWriter(scan.scan_packets[0]).set_return(b, 3, 5000);
  const auto p = points_of(scan);
  ASSERT_EQ(p.x_m.size(), 12u);
  for (std::size_t b = 0; b < 12; ++b)
  {
    EXPECT_NEAR(p.z_m[b], b % 2 ? -8 : 6, 1e-5);
    const double expected = 0.17 * static_cast<double>(b / 2) - (b % 2 ? 5 : 0);
    EXPECT_NEAR(std::remainder(azimuth_deg(p, b) - expected, 360), 0, 1e-4);
    EXPECT_NEAR(p.time_s[b], 48e-6 * static_cast<double>(b / 2), 1e-9);
  }
}

TEST(PointsFromAnHdl64, HoldBothReturnsOfARayButNoneTwice)
{
  auto scan = empty_scan(1, 4, 17, 0, 0, 0, kLowerBank);
  scan.calibration = flat_calibration(64);
  PacketWriter writer(scan.scan_packets[0]);
  writer.set_return(0, 3, 5000);  // upper bank, one echo
  writer.set_return(2, 3, 5000);
  writer.set_return(1, 3, 4000);  // lower bank, two echoes
  writer.set_return(3, 3, 3000);
  EXPECT_EQ(points_of(scan).x_m.size(), 3u);
}

namespace
{
/** A ray with two echoes, as packets and as what MRPT's conversion makes of them. */
void expect_same_two_returns(CObservationVelodyneScan scan, const std::string& model)
{
  scan.calibration = VelodyneCalibration::LoadDefaultCalibration(model);
  PacketWriter writer(scan.scan_packets[4]);
  writer.set_return(4, 6, 5000);
  writer.set_return(5, 6, 3000);
  const auto expected = points_of(scan);
  CObservationRotatingScan rotating;
  rotating.fromVelodyne(scan);
  const auto p = points_of(rotating);
  ASSERT_EQ(expected.x_m.size(), 2u);
  ASSERT_EQ(p.x_m.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i)
  {
    EXPECT_NEAR(std::remainder(azimuth_deg(p, i) - azimuth_deg(expected, i), 360), 0, 0.02);
    EXPECT_NEAR(p.z_m[i], expected.z_m[1 - i], 1e-4);  // the strongest return comes first here
    EXPECT_NEAR(p.time_s[i], expected.time_s[i], 20e-6);
  }
}
}  // namespace

TEST(PointsFromARotatingScan, AgreeWithThePacketsOfAScanWithTwoReturnsARay)
{
  expect_same_two_returns(empty_scan(10, 2, 40, kDual, kVlp16, kVlp16Packet_us / 2), "VLP16");
  expect_same_two_returns(empty_scan(10, 2, 16, kDual, kHdl32, 6 * 46.08), "HDL32");
}

TEST(PointsFromARotatingScan, LieInAPlaneWhenItHasOneRow)
{
  CObservation2DRangeScan planar;
  planar.aperture = static_cast<float>(M_PI);
  planar.resizeScanAndAssign(5, 2.0f, true);
  CObservationRotatingScan scan;
  scan.fromScan2D(planar);
  SensorPoints points;
  ASSERT_TRUE(points_from_observation(scan, points));
  ASSERT_EQ(points.x_m.size(), 5u);
  EXPECT_NEAR(points.y_m[0], -2, 1e-5);
  EXPECT_NEAR(points.x_m[2], 2, 1e-5);
  EXPECT_NEAR(points.y_m[4], 2, 1e-5);
  EXPECT_TRUE(points.time_s.empty());
}

TEST(PointsFromARotatingScan, KeepTheConventionOfTheObservationWhenItsSpanIsNegative)
{
  CObservationRotatingScan scan;
  scan.lidarModel = "VLP-16";
  scan.rangeResolution = 0.002;
  scan.rangeImage.resize(16, 360);
  scan.rangeImage.fill(0);
  scan.rangeImage(0, 90) = 5000;  // -15 degrees of elevation, a quarter turn clockwise from behind
  scan.rangeImage(1, 359) = 5000;
  scan.startAzimuth = M_PI;
  scan.azimuthSpan = -2 * M_PI;
  SensorPoints p;
  ASSERT_TRUE(points_from_observation(scan, p));
  ASSERT_EQ(p.x_m.size(), 2u);
  EXPECT_NEAR(p.x_m[0], 0, 1e-4);
  EXPECT_NEAR(p.y_m[0], 10 * std::cos(15 * kDegree), 1e-4);
  EXPECT_NEAR(p.z_m[0], -10 * std::sin(15 * kDegree), 1e-4);
}

TEST(PointsFromARotatingScan, AreRefusedWhenTheElevationsAreNotKnown)
{
  CObservationRotatingScan scan;
  scan.sensorLabel = "roof";
  scan.lidarModel = "OS1-64";
  scan.rangeImage.resize(64, 8);
  expect_refused(scan, {"CObservationRotatingScan", "'roof'", "OS1-64", "64 rows", "VLP-16"});
  scan.rangeImage.resize(0, 0);
  expect_refused(scan, {"'roof'", "empty"});
}
