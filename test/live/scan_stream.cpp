#include <talus/import/scan_stream.h>

#include <map>

#include "bag_reader.h"
#include "bags.h"
#include "robot.h"

using talus::import::ImportedScan;
using talus::import::ScanStream;
using namespace talus::test;

namespace
{
/** A stream that hears a robot; each function is a moment after the start. */
class Heard
{
 public:
  explicit Heard(const talus::import::SourceOptions& options = {}) : stream(options, 0.2) {}

  void say_tf(double time_s, const std::string& parent, const std::string& child, double x_m)
  {
    stream.add("/tf", kTfType, tf(time_s, parent, child, x_m), kStart_s + time_s);
  }
  void say_mounting(const std::string& child = "lidar")
  {
    stream.add("/tf_static", kTfType, tf(0, "base_link", child, 0, 0.5), kStart_s);
  }
  void say_cloud(double time_s, double at_s, const std::string& frame = "lidar")
  {
    stream.add("/points", kCloudType, floor_cloud(time_s, frame), kStart_s + at_s);
  }
  bool next(double at_s) { return stream.next(scan, kStart_s + at_s); }
  std::string news()
  {
    std::string all;
    for (const auto& text : stream.take_news()) all += text + "\n";
    return all;
  }

  ScanStream stream;
  ImportedScan scan;
};
}  // namespace

TEST(ScanStream, gives_a_scan_once_its_pose_is_known)
{
  Heard robot;
  robot.say_mounting();
  robot.say_tf(0.9, "map", "base_link", 0.9);
  robot.say_cloud(1.0, 1.0);
  EXPECT_FALSE(robot.next(1.0));
  robot.say_tf(1.1, "map", "base_link", 1.1);
  ASSERT_TRUE(robot.next(1.1));
  EXPECT_EQ(robot.scan.x_m.size(), 61U * 61U);
  EXPECT_DOUBLE_EQ(robot.scan.T_base_sensor.z(), 0.5);
  const auto pose = robot.stream.poses().at(kStart_s + 1.0, 0.5);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->x(), 1.0, 1e-6);
  EXPECT_EQ(robot.stream.map_frame(), "map");
}

TEST(ScanStream, leaves_out_a_cloud_whose_pose_is_late_and_says_so)
{
  Heard robot;
  robot.say_mounting();
  robot.say_tf(0.9, "map", "base_link", 0.9);
  robot.say_cloud(1.0, 1.0);
  EXPECT_FALSE(robot.next(1.1));
  EXPECT_FALSE(robot.next(1.21));
  EXPECT_EQ(robot.stream.counts().late, 1U);
  EXPECT_NE(robot.stream.why_late().find("0.10 s older; --max-wait"), std::string::npos);
}

TEST(ScanStream, guesses_no_mounting)
{
  Heard robot;
  for (const double t : {0.9, 1.1}) robot.say_tf(t, "map", "base_link", t);
  robot.say_cloud(1.0, 1.0);
  EXPECT_FALSE(robot.next(2.0));
  EXPECT_NE(robot.stream.why_nothing().find("--mount /points=X"), std::string::npos);

  talus::import::SourceOptions options;
  options.mountings["/points"] = mrpt::poses::CPose3D(0, 0, 0.7, 0, 0, 0);
  Heard told(options);
  for (const double t : {0.9, 1.1}) told.say_tf(t, "map", "base_link", t);
  told.say_cloud(1.0, 1.0);
  ASSERT_TRUE(told.next(1.1));
  EXPECT_DOUBLE_EQ(told.scan.T_base_sensor.z(), 0.7);
}

TEST(ScanStream, waits_for_the_slowest_link_of_tf)
{
  Heard robot;
  robot.say_mounting();
  robot.say_tf(0.9, "map", "odom", 10);
  robot.say_tf(0.9, "odom", "base_link", 0.9);
  robot.say_tf(1.1, "odom", "base_link", 1.1);
  robot.say_cloud(1.0, 1.0);
  EXPECT_FALSE(robot.next(1.1));
  robot.say_tf(1.1, "map", "odom", 10);
  ASSERT_TRUE(robot.next(1.11));
  EXPECT_NEAR(robot.stream.poses().at(kStart_s + 1.0, 0.5)->x(), 11.0, 1e-6);
  EXPECT_NEAR(robot.stream.take_new_poses().back().T_map_odom.x(), 10.0, 1e-6);
}

TEST(ScanStream, takes_odometry_where_tf_has_no_poses)
{
  Heard robot;
  robot.say_mounting();
  for (int i = 0; i <= 30; ++i)
  {
    const double t = 0.1 * i;
    robot.stream.add(
        "/odom", "nav_msgs/msg/Odometry",
        talus::live::odometry_message(
            {{kStart_s + t, "odom"}, "imu_link", mrpt::poses::CPose3D(t, 0, 0, 0, 0, 0)}),
        kStart_s + t);
  }
  robot.say_cloud(2.55, 3.0);
  ASSERT_TRUE(robot.next(3.0));
  EXPECT_NEAR(robot.stream.poses().at(kStart_s + 2.55, 0.5)->x(), 2.55, 1e-6);
  const std::string news = robot.news();
  EXPECT_NE(news.find("poses are those of topic /odom"), std::string::npos);
  EXPECT_NE(news.find("of 'imu_link' are taken for those of 'base_link'"), std::string::npos);
}

TEST(ScanStream, reads_clouds_and_frames_as_those_of_a_bag)
{
  MAKE_BAGS("log.db3");
  talus::import::BagReader bag({dir / "log.db3"}, false);
  ScanStream stream({}, 5);
  std::map<std::string, std::vector<ImportedScan>> scans;
  ImportedScan scan;
  for (const bool is_static : {true, false})  // which that bag has at its end
  {
    bag.start(std::vector<bool>(bag.topics().size(), true));
    for (talus::import::BagMessage message; bag.next(message);)
    {
      const auto& topic = bag.topics()[message.topic];
      const double now_s = static_cast<double>(message.log_time_ns) * 1e-9;
      if (is_static == (topic.name == "/tf_static"))
        stream.add(topic.name, topic.type, bag.payload(), now_s);
      while (stream.next(scan, now_s)) scans[scan.sensor_label].push_back(scan);
    }
  }
  stream.end();
  while (stream.next(scan, 0)) scans[scan.sensor_label].push_back(scan);
  for (const char* topic : {"/front/points", "/rear/points"})
  {
    const auto expected = scans_of(dir / "log.db3", topic);
    ASSERT_EQ(scans[topic].size(), expected.size()) << topic;
    for (std::size_t i = 0; i < expected.size(); ++i)
    {
      const auto &a = scans[topic][i], &b = expected[i];
      EXPECT_EQ(a.time_s, b.time_s);
      EXPECT_TRUE(a.T_base_sensor == b.T_base_sensor) << topic << i;
      EXPECT_EQ(a.x_m, b.x_m);
      EXPECT_EQ(a.y_m, b.y_m);
      EXPECT_EQ(a.z_m, b.z_m);
      EXPECT_EQ(a.intensity, b.intensity);
      EXPECT_EQ(a.point_time_s, b.point_time_s);
    }
  }
  EXPECT_EQ(stream.map_frame(), "map");
}

TEST(ScanStream, leaves_out_maps_and_copies)
{
  Heard robot;
  robot.say_cloud(1, 1);
  robot.stream.add("/filtered", kCloudType, floor_cloud(1), kStart_s + 1);
  robot.stream.add("/slam/map", kCloudType, floor_cloud(1, "map"), kStart_s + 1);
  EXPECT_TRUE(robot.stream.wants("/points"));
  EXPECT_FALSE(robot.stream.wants("/filtered"));
  EXPECT_FALSE(robot.stream.wants("/slam/map"));
  EXPECT_NE(robot.news().find("--topic /filtered takes it"), std::string::npos);
}

TEST(ScanStream, takes_no_scan_twice_and_none_of_another_time)
{
  Heard robot;
  robot.say_mounting();
  robot.say_tf(0.9, "map", "base_link", 0.9);
  robot.stream.add(
      "/tf", kTfType, tf(500, "map", "base_link", 500), kStart_s + 1);  // another clock
  robot.say_tf(1.1, "map", "base_link", 1.1);
  robot.say_cloud(1.0, 1.1);
  robot.say_cloud(1.0, 1.1);
  EXPECT_TRUE(robot.next(1.1));
  EXPECT_FALSE(robot.next(1.1));
  EXPECT_EQ(robot.stream.counts().stale, 1U);
  robot.stream.add("/tf", kTfType, tf(-20, "map", "base_link", 0), kStart_s + 1.2);
  EXPECT_NE(robot.news().find("gone back"), std::string::npos);
  EXPECT_NE(robot.stream.why_nothing().find("gone back"), std::string::npos);
  robot.say_tf(1.3, "map", "base_link", 1.3);
  EXPECT_EQ(robot.stream.why_nothing(), "");
}

TEST(ScanStream, tells_by_the_stamps_what_got_lost)
{
  Heard robot;
  robot.say_mounting();
  for (int i = 0; i < 30; ++i)
    if (i < 10 || i % 4 == 0) robot.say_cloud(0.1 * i, 0.1 * i);
  EXPECT_EQ(robot.stream.counts().missing, 2U + 4 * 3);
}

TEST(ScanStream, drops_the_times_of_points_where_poses_end_before_them)
{
  auto points = floor_points();
  for (std::size_t i = 0; i < points.x_m.size(); ++i)
    points.time_s.push_back(0.1F * static_cast<float>(i) / static_cast<float>(points.x_m.size()));
  Heard robot;
  robot.say_mounting();
  for (const double t : {0.9, 1.0}) robot.say_tf(t, "map", "base_link", t);
  robot.stream.add(
      "/points", kCloudType, talus::live::cloud_message({kStart_s + 1, "lidar"}, points),
      kStart_s + 1.1);
  EXPECT_FALSE(robot.next(1.2));
  ASSERT_TRUE(robot.next(1.31));
  EXPECT_TRUE(robot.scan.point_time_s.empty());
  EXPECT_EQ(robot.stream.counts().without_times, 1U);
}

TEST(ScanStream, counts_what_is_damaged_and_goes_on)
{
  Heard robot;
  robot.say_mounting();
  for (const double t : {0.9, 1.1}) robot.say_tf(t, "map", "base_link", t);
  const std::string whole = floor_cloud(1.0);
  for (std::size_t size = 0; size < whole.size(); size = size * 3 / 2 + 1)
    robot.stream.add("/points", kCloudType, whole.substr(0, size), kStart_s + 1);
  for (std::size_t at = 0; at < 160; ++at)
  {
    std::string damaged = floor_cloud(1.0, "rear");
    damaged[at] = static_cast<char>(0xff);
    robot.stream.add("/damaged", kCloudType, damaged, kStart_s + 1);
  }
  EXPECT_GT(robot.stream.counts().refused, 50U);
  robot.say_cloud(1.05, 1.1);
  bool has_come = false;
  while (robot.next(2)) has_come |= robot.scan.sensor_label == "/points";
  EXPECT_TRUE(has_come);
}

TEST(ScanStream, takes_names_with_a_leading_slash_and_the_time_of_a_simulation)
{
  Heard robot;
  const auto at = [](double time_s) { return time_s - kStart_s + 20; };  // since its start
  robot.stream.add("/tf_static", kTfType, tf(at(0), "/base_link", "/lidar", 0, 0.5), kStart_s);
  for (const double time_s : {0.0, 0.5, 1.0, 1.5})
  {
    robot.say_tf(at(time_s), "/map", "/base_link", time_s);
    robot.stream.add("/points", kCloudType, floor_cloud(at(time_s)), kStart_s + time_s);
    ASSERT_TRUE(robot.next(time_s)) << time_s << robot.news() << robot.stream.why_nothing();
    EXPECT_NEAR(robot.scan.time_s, 20 + time_s, 1e-6);
  }
}

TEST(ScanStream, leaves_out_a_cloud_without_points)
{
  Heard robot;
  robot.say_cloud(-1, -1);
  EXPECT_FALSE(robot.next(0));
  EXPECT_EQ(robot.stream.why_late(), "no poses have come yet");
  robot.say_mounting();
  robot.stream.add(
      "/points", kCloudType, talus::live::cloud_message({kStart_s, "lidar"}, {}), kStart_s);
  robot.say_tf(0, "map", "base_link", 0);
  robot.say_tf(0.1, "map", "base_link", 0);
  EXPECT_FALSE(robot.next(0.1));
  EXPECT_NE(robot.stream.why_nothing().find("has no points"), std::string::npos);
  robot.say_cloud(0.1, 0.1);
  EXPECT_TRUE(robot.next(0.1));
  EXPECT_EQ(robot.stream.why_nothing(), "");
}
