// Bags of ROS 2: what another hand wrote comes back, point for point.
#include "bags.h"

#include <cmath>

#include "bag_source.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;
using mrpt::poses::CPose3D;

#define MAKE_BAGS(names)                                                 \
  if (const auto why = why_no_bags(); !why.empty()) GTEST_SKIP() << why; \
  const ScratchDir dir;                                                  \
  ASSERT_TRUE(make_bags(dir, names))

namespace
{
std::vector<ImportedScan> scans_of(
    const std::string& path, const std::string& topic, const SourceOptions& options = {})
{
  const auto source = open_bag(path, options);
  std::vector<ImportedScan> scans;
  for (const auto& scan : all_of(*source))
    if (scan.sensor_label == topic) scans.push_back(scan);
  return scans;
}

std::string error_of(const std::string& path, const SourceOptions& options = {})
{
  try
  {
    const auto source = open_bag(path, options);
    all_of(*source);
  }
  catch (const std::runtime_error& e)
  {
    return e.what();
  }
  return "";
}

std::string remarks_of(const std::string& path, const SourceOptions& options = {})
{
  const auto source = open_bag(path, options);
  all_of(*source);
  std::string all;
  for (const auto& remark : source->remarks()) all += remark + "\n";
  return all;
}

bool holds(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

void expect_pose(const CPose3D& is, double x, double y, double z, double yaw)
{
  const CPose3D difference = CPose3D(x, y, z, yaw, 0, 0) - is;
  EXPECT_NEAR(difference.norm(), 0, 1e-9) << is;
  EXPECT_NEAR(std::abs(difference.yaw()) + std::abs(difference.pitch()), 0, 1e-9) << is;
}

void expect_front(const ImportedScan& scan, int i)
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
void expect_rear(const ImportedScan& scan, int i)
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

void expect_log(const std::string& path)
{
  const auto source = open_bag(path, {});
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
  EXPECT_EQ(
      source->remarks(), std::vector<std::string>{"poses are those of 'base_link' in 'map' in TF"});
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 21u);
  for (std::size_t i = 0; i < 21; ++i)
  {
    const double t = 0.05 * static_cast<double>(i);
    EXPECT_NEAR(poses.entries()[i].time_s, kBagStart_s + t, 1e-6);
    expect_pose(poses.entries()[i].T_map_base, 10 + 3 * t, 5, 0, 0.1 * t);
  }
}
}  // namespace

class BagPacking : public testing::TestWithParam<const char*>
{
};

TEST_P(BagPacking, GivesScansMountingsAndPosesPointForPoint)
{
  const std::string names = GetParam();
  MAKE_BAGS(names);
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1)
  {
    end = names.find(' ', begin);
    const auto name = names.substr(begin, end - begin);
    SCOPED_TRACE(name);
    expect_log(dir / name);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Db3, BagPacking, testing::Values("log.db3 no_index.db3 messages_zstd.db3"));
INSTANTIATE_TEST_SUITE_P(Mcap, BagPacking, testing::Values("none.mcap zstd.mcap lz4.mcap"));
INSTANTIATE_TEST_SUITE_P(
    OddMcap, BagPacking,
    testing::Values("loose.mcap loose_no_summary.mcap no_summary.mcap overlapping.mcap"));
INSTANTIATE_TEST_SUITE_P(
    Folder, BagPacking, testing::Values("parts parts_without_metadata mode_message"));

TEST(Bag, TimesOfPointsAreSinceTheStampInWhateverUnit)
{
  MAKE_BAGS("times");
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "times"))
  {
    SCOPED_TRACE(entry.path());
    const auto scans = scans_of(entry.path().string(), "/points");
    ASSERT_EQ(scans.size(), 1u);
    ASSERT_EQ(scans[0].point_time_s.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(scans[0].point_time_s[i], 0.025 * static_cast<double>(i), 1e-6);
    ++files;
  }
  EXPECT_EQ(files, 9u);
}

TEST(Bag, TimesOfPointsOfTooFewDigitsAreLeftOutAndItIsSaid)
{
  MAKE_BAGS("few_digits.mcap");
  const auto path = dir / "few_digits.mcap";
  EXPECT_TRUE(scans_of(path, "/points")[0].point_time_s.empty());
  EXPECT_TRUE(holds(remarks_of(path), "without times of points"));
}

TEST(Bag, ReadsFieldsOfIntegersWhereverTheyLie)
{
  MAKE_BAGS("integers.mcap");
  const auto scans = scans_of(dir / "integers.mcap", "/points");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].x_m, (std::vector<float>{-5, 7}));
  EXPECT_EQ(scans[0].y_m, (std::vector<float>{-300, 12}));
  EXPECT_EQ(scans[0].z_m, (std::vector<float>{60000, 1}));
  EXPECT_EQ(scans[0].intensity, (std::vector<float>{70000, 2}));
  EXPECT_EQ(scans[0].ring, (std::vector<std::uint16_t>{3, 255}));
}

TEST(Bag, ReadsMessagesOfBigEndianMachines)
{
  MAKE_BAGS("big_endian_cdr.mcap");
  const auto scans = scans_of(dir / "big_endian_cdr.mcap", "/points");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].z_m, (std::vector<float>{3}));
  EXPECT_EQ(scans[0].time_s, kBagStart_s);
}

TEST(Bag, APackedFileIsRefusedWithTheCommandThatUnpacksIt)
{
  MAKE_BAGS("mode_file");
  const auto error = error_of(dir / "mode_file");
  EXPECT_TRUE(holds(error, "zstd -d part_0.db3.zstd -o part_0.db3")) << error;
  ASSERT_EQ(
      std::system(
          ("cd " + (dir / "mode_file") + " && zstd -q -d part_0.db3.zstd -o part_0.db3").c_str()),
      0);
  expect_log(dir / "mode_file");
}

TEST(Bag, OnlyNamedTopicsAreRead)
{
  MAKE_BAGS("zstd.mcap");
  SourceOptions options;
  options.topics = {"/rear/points"};
  EXPECT_EQ(scans_of(dir / "zstd.mcap", "/rear/points", options).size(), 10u);
  EXPECT_EQ(scans_of(dir / "zstd.mcap", "/front/points", options).size(), 0u);
  options.topics = {"/reer/points"};
  const auto error = error_of(dir / "zstd.mcap", options);
  EXPECT_TRUE(holds(error, "/reer/points") && holds(error, "/rear/points")) << error;
}

TEST(Bag, WithoutTfTheSensorIsAtTheBaseWhichIsSaid)
{
  MAKE_BAGS("no_tf.mcap");
  const auto source = open_bag(dir / "no_tf.mcap", {});
  const auto scans = all_of(*source);
  ASSERT_EQ(scans.size(), 20u);
  expect_pose(scans[3].T_base_sensor, 0, 0, 0, 0);
  EXPECT_TRUE(holds(remarks_of(dir / "no_tf.mcap"), "front_lidar"));
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 21u);
  expect_pose(poses.entries()[20].T_map_base, 2, 0, 0, 0.1);
}

TEST(Bag, AGivenMountingNeedsNoTf)
{
  MAKE_BAGS("no_tf.mcap");
  SourceOptions options;
  options.topics = {"/front/points"};
  options.mountings["/front/points"] = CPose3D(1, 2, 3, 0, 0, 0);
  expect_pose(scans_of(dir / "no_tf.mcap", "/front/points", options)[0].T_base_sensor, 1, 2, 3, 0);
  EXPECT_EQ(remarks_of(dir / "no_tf.mcap", options), "poses are those of topic /odom\n");
}

TEST(Bag, PosesComeFromPoseStampedWhereNothingElseMoves)
{
  MAKE_BAGS("poses.mcap");
  const auto source = open_bag(dir / "poses.mcap", {});
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 6u);
  expect_pose(poses.entries()[5].T_map_base, 1, 7, 0, 0);
}

TEST(Bag, OfSeveralTopicsWithPosesTheLongestIsTakenOrTheNamed)
{
  MAKE_BAGS("two_pose_topics.mcap");
  const auto path = dir / "two_pose_topics.mcap";
  EXPECT_EQ(open_bag(path, {})->poses().entries().size(), 21u);
  const auto remarks = remarks_of(path);
  EXPECT_TRUE(
      holds(remarks, "/odom") && holds(remarks, "/slam_pose (6)") && holds(remarks, "--topic"))
      << remarks;
  SourceOptions options;
  options.topics = {"/slam_pose"};
  const auto source = open_bag(path, options);
  EXPECT_EQ(source->poses().entries().size(), 6u);
  EXPECT_FALSE(all_of(*source).empty());
}

TEST(Bag, OdometryOfAnotherFrameIsCarriedOverToTheBase)
{
  MAKE_BAGS("wheel.mcap");
  const auto poses = open_bag(dir / "wheel.mcap", {})->poses();
  ASSERT_EQ(poses.entries().size(), 10u);
  expect_pose(poses.entries()[4].T_map_base, 4, 0, 0, 0);
}

TEST(Bag, FramesCanBeNamed)
{
  MAKE_BAGS("log.db3");
  SourceOptions options;
  options.map_frame = "odom";
  options.base_frame = "mast";
  const auto source = open_bag(dir / "log.db3", options);
  expect_pose(source->poses().entries()[0].T_map_base, 0.5, 0, 1, M_PI / 2);
  expect_pose(all_of(*source)[0].T_base_sensor, 0.25, 0, 0, 0);
  options.base_frame = "base";
  const auto error = error_of(dir / "log.db3", options);
  EXPECT_TRUE(holds(error, "--base-frame") && holds(error, "base_link, front_lidar")) << error;
}

TEST(Bag, WithoutPosesItSaysHowToGiveThem)
{
  MAKE_BAGS("no_poses.mcap");
  EXPECT_TRUE(open_bag(dir / "no_poses.mcap", {})->poses().empty());
  EXPECT_TRUE(holds(remarks_of(dir / "no_poses.mcap"), "--poses"));
}

TEST(Bag, WithoutCloudsItListsTopicsAndTypes)
{
  MAKE_BAGS("no_clouds.mcap empty.mcap");
  const auto error = error_of(dir / "no_clouds.mcap");
  for (const char* part : {"no_clouds.mcap", "PointCloud2", "/imu  sensor_msgs/msg/Imu", "/odom"})
    EXPECT_TRUE(holds(error, part)) << part << " is not in: " << error;
  EXPECT_TRUE(holds(error_of(dir / "empty.mcap"), "no topics at all"));
}

TEST(Bag, ScansOfTimesThatGoBackAreLeftOutAndCounted)
{
  MAKE_BAGS("two_clocks.mcap");
  EXPECT_EQ(scans_of(dir / "two_clocks.mcap", "/points").size(), 1u);
  EXPECT_TRUE(holds(remarks_of(dir / "two_clocks.mcap"), "/points: 2 scans are left out"));
}

TEST(Bag, CloudsThatSayMoreThanTheyHoldAreRefusedByNameAndPlace)
{
  MAKE_BAGS(
      "lie_huge.mcap lie_wide.mcap lie_fields.mcap lie_cut.mcap lie_tiny.mcap lie_xml.mcap "
      "unknown_type.mcap");
  for (const char* name :
       {"lie_huge", "lie_wide", "lie_fields", "lie_cut", "lie_tiny", "lie_xml", "unknown_type"})
  {
    const auto error = error_of(dir / (std::string(name) + ".mcap"));
    EXPECT_TRUE(holds(error, name) && holds(error, "/points") && holds(error, "byte")) << error;
  }
}

TEST(Bag, WhatIsNoBagIsRefused)
{
  const ScratchDir dir;
  std::ofstream(dir / "text.db3") << "some text, long enough for a header";
  std::ofstream(dir / "empty.mcap") << "";
  std::ofstream(dir / "metadata.yaml") << "rosbag2_bagfile_information: [";
  EXPECT_TRUE(holds(error_of(dir / "text.db3"), "text.db3: does not begin as a bag"));
  EXPECT_TRUE(holds(error_of(dir / "empty.mcap"), "is empty"));
  EXPECT_TRUE(holds(error_of(dir / "none.mcap"), "no such file"));
  EXPECT_TRUE(holds(error_of(dir / ""), "metadata.yaml: names no files"));
}
