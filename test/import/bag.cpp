// Bags of ROS 2: what another hand wrote comes back, point for point.
#include "bag_log.h"
#include "bag_topics.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;
using mrpt::poses::CPose3D;

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
INSTANTIATE_TEST_SUITE_P(
    Mcap, BagPacking, testing::Values("none.mcap zstd.mcap lz4.mcap checked.mcap"));
INSTANTIATE_TEST_SUITE_P(
    OddMcap, BagPacking,
    testing::Values("loose.mcap loose_no_summary.mcap no_summary.mcap overlapping.mcap"));
INSTANTIATE_TEST_SUITE_P(Folder, BagPacking, testing::Values("parts mode_message"));

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

TEST(Bag, ReadsWhatTheDriversOfLivoxWrite)
{
  MAKE_BAGS("livox.mcap livox_1.mcap livox_big.mcap");
  for (const std::string name : {"livox.mcap", "livox_1.mcap", "livox_big.mcap"})
  {
    SCOPED_TRACE(name);
    const auto scans = scans_of(dir / name, "/livox/lidar");
    ASSERT_EQ(scans.size(), 3u);
    const auto& scan = scans[2];
    EXPECT_NEAR(scan.time_s, kBagStart_s + 0.2, 1e-6) << "of the timebase, where there is no stamp";
    ASSERT_EQ(scan.x_m.size(), 20u);
    for (std::size_t k : {0, 19})
    {
      EXPECT_EQ(scan.x_m[k], 1.0F + static_cast<float>(k));
      EXPECT_EQ(scan.y_m[k], -2);
      EXPECT_EQ(scan.z_m[k], 0.5F);
      EXPECT_EQ(scan.intensity[k], 100.0F + static_cast<float>(k));
      EXPECT_EQ(scan.ring[k], k % 4);
      EXPECT_NEAR(scan.point_time_s[k], 1e-3 * static_cast<double>(k), 1e-6);
    }
  }
}

TEST(Bag, RefusesLivoxMessagesThatSayMoreThanTheyHold)
{
  MAKE_BAGS("lie_livox_more.mcap lie_livox_huge.mcap lie_livox_cut.mcap lie_livox_tiny.mcap");
  for (const std::string what : {"more", "huge", "cut", "tiny"})
  {
    const auto error = error_of(dir / ("lie_livox_" + what + ".mcap"));
    EXPECT_TRUE(holds(error, "/livox/lidar") && holds(error, "Copy the bag again")) << error;
  }
}

TEST(Bag, TakesThePosesOfAPathButNotThoseOfAPlan)
{
  MAKE_BAGS("path.mcap plan.mcap");
  const auto source = open_bag_source({dir / "path.mcap"}, {});
  all_of(*source);
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 10u);
  EXPECT_NEAR(poses.entries()[9].time_s, kBagStart_s + 0.9, 1e-6);
  EXPECT_NEAR(poses.entries()[9].T_map_base.x(), 2.7, 1e-9);
  EXPECT_TRUE(open_bag_source({dir / "plan.mcap"}, {})->poses().empty());
  EXPECT_TRUE(holds(remarks_of(dir / "plan.mcap"), "no Path whose poses have times"));
}

TEST(Bag, LeavesOutTheCloudsThatAPipelineMakesOfOthers)
{
  MAKE_BAGS("copies.mcap");
  const auto count_of = [&](const std::string& topic, const SourceOptions& options)
  { return scans_of(dir / "copies.mcap", topic, options).size(); };
  SourceOptions one, both;
  one.topics = {"/thin"};
  both.topics = {"/points", "/thin"};
  for (const auto& [topic, count] :
       {std::pair("/points", 10u), {"/rear", 10u}, {"/thin", 0u}, {"/a_base", 0u}})
    EXPECT_EQ(count_of(topic, {}), count) << topic;
  EXPECT_EQ(count_of("/thin", one), 10u);
  EXPECT_EQ(count_of("/thin", both) + count_of("/points", both), 20u);
  const auto remarks = remarks_of(dir / "copies.mcap");
  for (const char* part : {"/thin is left out: its points are those of /points", "--topic /a_base"})
    EXPECT_TRUE(holds(remarks, part)) << remarks;
}

TEST(Bag, WithoutCloudsSaysHowItGetsSome)
{
  const auto error_with = [](const char* topic, const char* type) {
    return message_of([&] { roles_of({{topic, type, "cdr"}}, {}, "a.db3"); });
  };
  EXPECT_TRUE(holds(error_with("/camera/depth", "sensor_msgs/msg/Image"), "depth_image_proc"));
  EXPECT_FALSE(holds(error_with("/camera", "sensor_msgs/msg/Image"), "depth_image_proc"));
  EXPECT_TRUE(holds(error_with("/v", "velodyne_msgs/msg/VelodyneScan"), "velodyne_pointcloud"));
  EXPECT_TRUE(holds(error_with("/o", "ouster_sensor_msgs/msg/PacketMsg"), "packets"));
  EXPECT_TRUE(holds(error_with("/scan", "sensor_msgs/msg/LaserScan"), "one plane"));
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

TEST(Bag, AWrongFlagOfTheByteOrderShowsInTheDistances)
{
  MAKE_BAGS("wrong_order.mcap");
  EXPECT_EQ(scans_of(dir / "wrong_order.mcap", "/points").at(0).y_m, std::vector<float>(5, 2.3F));
  EXPECT_TRUE(holds(remarks_of(dir / "wrong_order.mcap"), "/points: is_bigendian is wrong"));
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

TEST(Bag, CloudsOfMapsAreLeftOutUnlessTheyAreNamed)
{
  MAKE_BAGS("with_maps.mcap");
  const auto path = dir / "with_maps.mcap";
  EXPECT_EQ(all_of(*open_bag_source({path}, {})).size(), 10u);
  EXPECT_EQ(scans_of(path, "/points").size(), 10u);
  const auto remarks = remarks_of(path);
  for (const std::string name : {"/grows", "/repeats", "/registered"})
  {
    EXPECT_TRUE(holds(remarks, name + " is left out: its")) << remarks;
    SourceOptions options;
    options.topics = {name};
    EXPECT_EQ(scans_of(path, name, options).size(), 10u);
  }
}

TEST(Bag, PointsAtOnePlaceOfTheBaseInEachScanAreNoReturns)
{
  MAKE_BAGS("no_returns_1.mcap no_returns_9.mcap");
  for (const int count : {1, 9})
  {
    const auto path = dir / ("no_returns_" + std::to_string(count) + ".mcap");
    EXPECT_EQ(scans_of(path, "/points").at(9).x_m.size(), 31u) << "also what stays on the ground";
    const auto remarks = remarks_of(path);
    EXPECT_TRUE(holds(
        remarks, "/points: " + std::to_string(10 * count) +
                     " points are left out: in each of the first scans some lie at exactly (0.2, "
                     "0, 0.7)"))
        << remarks;
  }
}

TEST(Bag, WithoutTfTheSensorIsAtTheBaseWhichIsSaid)
{
  MAKE_BAGS("no_tf.mcap");
  const auto source = open_bag_source({dir / "no_tf.mcap"}, {});
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

TEST(Bag, OfSeveralTopicsWithPosesTheLongestIsTakenOrTheNamed)
{
  MAKE_BAGS("two_pose_topics.mcap");
  const auto path = dir / "two_pose_topics.mcap";
  EXPECT_EQ(open_bag_source({path}, {})->poses().entries().size(), 21u);
  const auto remarks = remarks_of(path);
  EXPECT_TRUE(
      holds(remarks, "/odom") && holds(remarks, "/slam_pose (6)") && holds(remarks, "--topic"))
      << remarks;
  SourceOptions options;
  options.topics = {"/slam_pose"};
  const auto source = open_bag_source({path}, options);
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 6u);
  expect_pose(poses.entries()[5].T_map_base, 1, 7, 0, 0);
  EXPECT_FALSE(all_of(*source).empty());
}

TEST(Bag, OdometryOfAnotherFrameIsCarriedOverToTheBase)
{
  MAKE_BAGS("wheel.mcap");
  const auto poses = open_bag_source({dir / "wheel.mcap"}, {})->poses();
  ASSERT_EQ(poses.entries().size(), 10u);
  expect_pose(poses.entries()[4].T_map_base, 4, 0, 0, 0);
}

TEST(Bag, FramesCanBeNamed)
{
  MAKE_BAGS("log.db3");
  SourceOptions options;
  options.map_frame = "odom";
  options.base_frame = "mast";
  const auto source = open_bag_source({dir / "log.db3"}, options);
  expect_pose(source->poses().entries()[0].T_map_base, 0.5, 0, 1, M_PI / 2);
  expect_pose(all_of(*source)[0].T_base_sensor, 0.25, 0, 0, 0);
  options.base_frame = "base";
  const auto error = error_of(dir / "log.db3", options);
  EXPECT_TRUE(holds(error, "--base-frame") && holds(error, "base_link, front_lidar")) << error;
}

TEST(Bag, WithoutPosesItSaysHowToGiveThem)
{
  MAKE_BAGS("no_poses.mcap");
  EXPECT_TRUE(open_bag_source({dir / "no_poses.mcap"}, {})->poses().empty());
  EXPECT_TRUE(holds(remarks_of(dir / "no_poses.mcap"), "--poses"));
}

TEST(Bag, WithoutCloudsItListsTopicsAndTypes)
{
  MAKE_BAGS("no_clouds.mcap empty.mcap");
  const auto error = error_of(dir / "no_clouds.mcap");
  for (const char* part : {"no_clouds.mcap", "PointCloud2", "/imu sensor_msgs/msg/Imu, ", "/odom"})
    EXPECT_TRUE(holds(error, part)) << part << " is not in: " << error;
  EXPECT_TRUE(holds(error_of(dir / "empty.mcap"), "no topics at all"));
}

TEST(Bag, ScansOfTimesThatGoBackAreLeftOutAndCounted)
{
  MAKE_BAGS("two_clocks.mcap");
  const auto source = open_bag_source({dir / "two_clocks.mcap"}, {});
  EXPECT_EQ(all_of(*source).size(), 1u);
  EXPECT_TRUE(holds(source->warnings().at(0), "/points: 2 of 3 scans are left out"));
}

TEST(Bag, AMountingInTfThatNeverChangesHoldsForAllScans)
{
  MAKE_BAGS("rare_tf.mcap");
  const auto scans = scans_of(dir / "rare_tf.mcap", "/points");
  ASSERT_EQ(scans.size(), 20u);
  expect_pose(scans.back().T_base_sensor, 0, 0, 1, 0);
}

TEST(Bag, ScansWithoutAStampWereTakenBeforeTheyWereRecorded)
{
  MAKE_BAGS("not_stamped.mcap");
  EXPECT_NEAR(scans_of(dir / "not_stamped.mcap", "/points").at(3).time_s, kBagStart_s + 0.31, 1e-6);
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
  EXPECT_TRUE(holds(error_of(dir / "text.db3"), "text.db3: does not begin as a bag"));
  EXPECT_TRUE(holds(error_of(dir / "empty.mcap"), "is empty"));
  EXPECT_TRUE(holds(error_of(dir / "none.mcap"), "no such file"));
  EXPECT_TRUE(holds(error_of(dir / ""), "text.db3: does not begin as a bag"));
}

// What a summary tells is held against the messages.
TEST(BagLies, WhatAnIndexHidesIsRead)
{
  MAKE_BAGS("lost_index.db3");
  expect_log(dir / "lost_index.db3");
}

TEST(BagLies, CountsAreHeldAgainstStatistics)
{
  MAKE_BAGS("lie_statistics.mcap lie_channel.mcap lost_chunk.mcap lost_message.mcap");
  const auto expect = [&](const std::string& name, const std::string& part)
  {
    const auto error = error_of(dir / name);
    EXPECT_TRUE(holds(error, name) && holds(error, part) && holds(error, "--partial")) << error;
  };
  expect("lie_statistics.mcap", "has 85 messages, and its Statistics count 86");
  expect("lie_channel.mcap", "has 10 messages of /imu, and its Statistics count 11");
  expect("lost_chunk.mcap", "has 7 chunks, and its Statistics count 8");
  expect("lost_message.mcap", "messages of /");
}

TEST(BagLies, ChecksumsOfDataAndSummaryAreChecked)
{
  MAKE_BAGS("flip_index.mcap flip_summary.mcap twice.mcap");
  const auto expect = [&](const std::string& name, const std::string& part)
  {
    const auto error = error_of(dir / name);
    EXPECT_TRUE(holds(error, name) && holds(error, part)) << error;
  };
  expect("flip_index.mcap", "the checksum of its data (DataEnd) does not agree");
  expect("flip_summary.mcap", "the checksum of its summary (Footer) does not agree");
  expect("twice.mcap", "goes on behind its end");
}

TEST(BagLies, WhatIsWhollyThereIsReadInPartWhereItsEndLies)
{
  MAKE_BAGS("lie_statistics.mcap flip_index.mcap flip_summary.mcap twice.mcap");
  SourceOptions options;
  options.partial = true;
  for (const std::string name :
       {"lie_statistics.mcap", "flip_index.mcap", "flip_summary.mcap", "twice.mcap"})
  {
    EXPECT_EQ(scans_of(dir / name, "/front/points", options).size(), 10u) << name;
    EXPECT_TRUE(holds(remarks_of(dir / name, options), "read in part")) << name;
  }
}

// Stamps of a clock that is not that of the recorder: since the sensor was switched on.
namespace
{
SourceOptions recorded()
{
  SourceOptions options;
  options.recorded_times = true;
  return options;
}
}  // namespace

TEST(BagClock, ScansHaveTheTimesOfRecordingWhereTheyAreAskedFor)
{
  MAKE_BAGS("boot_clouds.mcap boot_all.mcap boot_odometry.mcap boot_moving.mcap");
  for (const std::string name :
       {"boot_clouds.mcap", "boot_all.mcap", "boot_odometry.mcap", "boot_moving.mcap"})
  {
    SCOPED_TRACE(name);
    const auto source = open_bag_source({dir / name}, recorded());
    const auto scans = all_of(*source);
    ASSERT_EQ(scans.size(), 10u);
    for (std::size_t i = 0; i < scans.size(); ++i)
    {
      EXPECT_NEAR(scans[i].time_s, kBagStart_s + 0.1 * static_cast<double>(i) + 0.01 - 0.05, 1e-6);
      expect_pose(scans[i].T_base_sensor, 0, 0, 1, 0);
      ASSERT_EQ(scans[i].point_time_s.size(), 2u);  // since the stamp of the same clock
      EXPECT_NEAR(scans[i].point_time_s[1], 0.05, 1e-5);
    }
    const auto poses = source->poses();
    ASSERT_EQ(poses.entries().size(), 10u);
    EXPECT_NEAR(poses.entries()[3].time_s, kBagStart_s + 0.3, 1e-6);
    EXPECT_TRUE(holds(remarks_of(dir / name, recorded()), "/points: 10 scans have the time of"));
  }
}

TEST(BagClock, WithoutTheSwitchTheStampsCount)
{
  MAKE_BAGS("boot_clouds.mcap boot_all.mcap");
  for (const std::string name : {"boot_clouds.mcap", "boot_all.mcap"})
    EXPECT_NEAR(scans_of(dir / name, "/points").at(1).time_s, 614.76, 1e-6) << name;
}

TEST(BagClock, MountingsOfAnotherTimeNameTheSwitch)
{
  MAKE_BAGS("boot_moving.mcap");
  const auto error = error_of(dir / "boot_moving.mcap");
  for (const char* part :
       {"none of its 10 scans", "614.66 s", "--recorded-times", "--mount /points"})
    EXPECT_TRUE(holds(error, part)) << part << " is not in: " << error;
}

TEST(BagClock, ScansOfAnotherClockThanThePosesAreToldAndWantThatOfTheRecorder)
{
  MAKE_BAGS(
      "ahead_37.mcap ahead_1.mcap ahead_all.mcap jump_2.mcap boot_odometry.mcap stall.mcap "
      "sweep_end.mcap");
  struct Row
  {
    const char* name;
    std::vector<const char*> warning;
    bool wants, all;  //!< the recorder's clock, for poses too
  };
  for (const Row& row :
       {Row{"ahead_37.mcap",
            {"/points", "-36.98 s after", "0.00 s after", "--recorded-times"},
            true,
            false},
        {"ahead_1.mcap", {"0.98 s before their last points", "--recorded-times"}, false, false},
        {"sweep_end.mcap", {"0.08 s before their last points"}, false, false},
        {"stall.mcap", {}, false, false},
        {"ahead_all.mcap", {}, false, false},
        {"boot_odometry.mcap", {"/points", "--recorded-times"}, true, true},
        {"jump_2.mcap", {"jumps", "-1.98 to 0.02 s"}, true, false}})
  {
    SCOPED_TRACE(row.name);
    SourceOptions options;
    const auto first = open_bag_source({dir / row.name}, options);
    const auto scans = all_of(*first);
    const auto told = first->warnings();
    ASSERT_EQ(told.empty(), row.warning.empty());
    for (const char* part : row.warning) EXPECT_TRUE(holds(told[0], part)) << told[0];
    SourceOptions stamped;
    stamped.stamped_times = true;
    EXPECT_EQ(first->wants(options), row.wants);
    EXPECT_EQ(options.recorded_times, row.all);
    const auto again = open_bag_source({dir / row.name}, options);
    EXPECT_EQ(all_of(*again).size(), scans.size());
    EXPECT_EQ(again->warnings().empty(), row.wants || row.warning.empty());
    EXPECT_FALSE(again->wants(options));
    const auto as_asked = open_bag_source({dir / row.name}, stamped);
    all_of(*as_asked);
    EXPECT_FALSE(as_asked->wants(stamped));
  }
}
