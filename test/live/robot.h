#pragma once
// A robot with ROS 2 on loopback, and what it says.
#include <gtest/gtest.h>
#include <talus/live/messages.h>
#include <talus/live/network.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace talus::test
{
constexpr double kStart_s = 1.7e9;
constexpr const char* kCloudType = "sensor_msgs/msg/PointCloud2";
constexpr const char* kTfType = "tf2_msgs/msg/TFMessage";

/** A domain of its own for each test that runs at the same time, on loopback only. */
inline int own_domain()
{
  ::setenv("CYCLONEDDS_URI", ("file://" + std::string(TALUS_LOOPBACK)).c_str(), 1);
  const int domain = 1 + static_cast<int>(::getpid() % 100);
  ::setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  return domain;
}

/** A level floor, seen from 0.5 m above it. */
inline live::CloudPoints floor_points()
{
  live::CloudPoints points;
  for (int i = -30; i <= 30; ++i)
    for (int j = -30; j <= 30; ++j)
    {
      points.x_m.push_back(0.1F * static_cast<float>(i) + 0.02F);
      points.y_m.push_back(0.1F * static_cast<float>(j) + 0.02F);
      points.z_m.push_back(-0.5F);
    }
  return points;
}

inline std::string floor_cloud(double time_s, const std::string& frame = "lidar")
{
  return live::cloud_message({kStart_s + time_s, frame}, floor_points());
}

inline std::string tf(
    double time_s, const std::string& parent, const std::string& child, double x_m, double z_m = 0)
{
  return live::tf_message(
      {{{kStart_s + time_s, parent}, child, mrpt::poses::CPose3D(x_m, 0, z_m, 0, 0, 0)}});
}

}  // namespace talus::test
