#pragma once
// What log() of make_bags.py holds, point for point.
#include <gtest/gtest.h>

#include <cmath>

#include "bags.h"

namespace talus::test
{
inline void expect_pose(const mrpt::poses::CPose3D& is, double x, double y, double z, double yaw)
{
  const mrpt::poses::CPose3D difference = mrpt::poses::CPose3D(x, y, z, yaw, 0, 0) - is;
  EXPECT_NEAR(difference.norm(), 0, 1e-9) << is;
  EXPECT_NEAR(std::abs(difference.yaw()) + std::abs(difference.pitch()), 0, 1e-9) << is;
}

inline void expect_front(const import::ImportedScan& scan, int i)
{
  const float first = static_cast<float>(i);
  EXPECT_NEAR(scan.time_s, kBagStart_s + 0.1 * i, 1e-6);
  EXPECT_EQ(scan.x_m, (std::vector<float>{first, first + 0.25f, first + 0.5f, first + 1}));
  EXPECT_EQ(scan.y_m, (std::vector<float>{0, -1, -2, -4}));
  EXPECT_EQ(scan.z_m, std::vector<float>(4, 0.5f));
  EXPECT_EQ(
      scan.intensity,
      (std::vector<float>{10 * first, 10 * first + 1, 10 * first + 2, 10 * first + 4}));
  EXPECT_EQ(scan.ring, (std::vector<std::uint16_t>{0, 1, 2, 4}));
  EXPECT_EQ(scan.point_time_s, (std::vector<float>{0, 0.001f, 0.002f, 0.004f}));
  EXPECT_EQ(scan.not_finite, 1u);
  expect_pose(scan.T_base_sensor, 0.5, 0.25, 1, M_PI / 2);
}

/** The arm on which it sits turns. */
inline void expect_rear(const import::ImportedScan& scan, int i)
{
  const double t = 0.1 * i + 0.05;
  EXPECT_NEAR(scan.time_s, kBagStart_s + t, 1e-6);
  ASSERT_EQ(scan.x_m.size(), 6u);
  ASSERT_EQ(scan.point_time_s.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k)
  {
    const auto kf = static_cast<float>(k);
    EXPECT_EQ(scan.x_m[k], -static_cast<float>(i) - kf);
    EXPECT_EQ(scan.y_m[k], 2.5f);
    EXPECT_EQ(scan.z_m[k], 0.125f * kf);
    EXPECT_EQ(scan.intensity[k], 100 - kf);
    EXPECT_EQ(scan.ring[k], k);
    EXPECT_NEAR(scan.point_time_s[k], 0.01 * static_cast<double>(k), 1e-6);
  }
  EXPECT_EQ(scan.not_finite, 0u);
  expect_pose(scan.T_base_sensor, -0.5 * std::cos(t), -0.5 * std::sin(t), 1, t + M_PI);
}

/** `remarks`: those before that on the poses. */
inline void expect_log(
    const std::string& path, const std::vector<std::string>& remarks = {},
    const import::SourceOptions& options = {})
{
  const auto source = import::open_bag_source({path}, options);
  int front = 0, rear = 0;
  double before_s = 0;
  for (const auto& scan : all_of(*source))
  {
    EXPECT_LT(before_s, scan.time_s);
    before_s = scan.time_s;
    if (scan.sensor_label == "/front/points")
      expect_front(scan, front++);
    else
      expect_rear(scan, rear++);
  }
  EXPECT_EQ(front, 10);
  EXPECT_EQ(rear, 10);
  EXPECT_EQ(source->progress(), 1);
  auto all = remarks;
  all.push_back("poses are those of 'base_link' in 'map' in TF");
  EXPECT_EQ(source->remarks(), all);
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 21u);
  for (std::size_t i = 0; i < 21; ++i)
  {
    const double t = 0.05 * static_cast<double>(i);
    EXPECT_NEAR(poses.entries()[i].time_s, kBagStart_s + t, 1e-6);
    expect_pose(poses.entries()[i].T_map_base, 10 + 3 * t, 5, 0, 0.1 * t);
  }
}

}  // namespace talus::test
