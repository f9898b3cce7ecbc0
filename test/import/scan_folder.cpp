// Folders of scans: which files belong to one, and when, where and in which order they were taken.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <talus/import/kitti_poses.h>
#include <talus/import/scan_source.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "log_files.h"
#include "scan_formats.h"
#include "folder_layout.h"

using namespace talus::import;
using namespace talus::test;
using mrpt::poses::CPose3D;
namespace fs = std::filesystem;

namespace
{
/** One point, whose x tells which scan it is. */
Points scan_number(int i)
{
  Points p;
  p.x = {static_cast<float>(i)};
  p.y = {1};
  p.z = {-0.5F};
  return p;
}

class ScanFolder : public testing::Test
{
 protected:
  void write(const std::string& name, const std::string& bytes) const
  {
    fs::create_directories(fs::path(dir_ / name).parent_path());
    write_bytes(dir_ / name, bytes);
  }
  /** sequences/07 as KITTI's odometry data has it, with `scans` in it. */
  void write_sequence(int scans) const
  {
    for (int i = 0; i < scans; ++i)
      write("sequences/07/velodyne/00000" + std::to_string(i) + ".bin", kitti_bin(scan_number(i)));
    write("sequences/07/times.txt", "0.000000e+00\n1.037250e-01\n2.1e-01\n");
    write("sequences/07/calib.txt", kCalibration);
    write("poses/07.txt", kPoses);
  }
  std::unique_ptr<ScanSource> open(const std::string& name, const SourceOptions& options = {}) const
  {
    return open_scan_source(Input(dir_ / name), options);
  }
  std::vector<ImportedScan> read(ScanSource& source) const
  {
    std::vector<ImportedScan> all;
    ImportedScan scan;
    while (source.next(scan)) all.push_back(scan);
    EXPECT_EQ(source.progress(), 1);
    return all;
  }
  std::vector<ImportedScan> read(const std::string& name) const { return read(*open(name)); }
  void refuses(
      const std::string& name, const std::vector<std::string>& words,
      const SourceOptions& options = {}) const
  {
    expect_error(
        [&]
        {
          const auto source = open(name, options);
          read(*source);
          source->poses();
        },
        words);
  }

  // The camera looks along x of the scanner, and is 0.27 m in front of it and 0.08 m below.
  static constexpr const char* kCalibration =
      "P0: 7.2e+02 0 6.1e+02 0 0 7.2e+02 1.8e+02 0 0 0 1 0\n"
      "Tr: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n";
  // Ahead by 2 m; then turned left by 90 degrees, about the camera.
  static constexpr const char* kPoses =
      "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n0 0 -1 0 0 1 0 0 1 0 0 2\n";
  ScratchDir dir_;
};
}  // namespace

TEST_F(ScanFolder, of_kitti_has_times_poses_and_the_height_of_its_car)
{
  write_sequence(3);
  for (const char* name : {"sequences/07", "sequences/07/", "sequences/07/velodyne"})
  {
    const auto source = open(name);
    const auto scans = read(*source);
    ASSERT_EQ(scans.size(), 3u) << name;
    EXPECT_EQ(scans[1].sensor_label, "velodyne");
    EXPECT_EQ(scans[1].time_s, 0.103725);
    EXPECT_EQ(scans[2].x_m, std::vector<float>{2});
    EXPECT_EQ(scans[0].T_base_sensor.z(), 1.73);
    ASSERT_EQ(source->remarks().size(), 2u);
    EXPECT_NE(source->remarks()[0].find("1.73 m above the road"), std::string::npos);
    EXPECT_NE(source->remarks()[1].find("poses/07.txt"), std::string::npos);

    const auto poses = source->poses().entries();
    ASSERT_EQ(poses.size(), 3u);
    EXPECT_EQ(poses[2].time_s, 0.21);
    const auto is_near = [](const CPose3D& T, double x, double y, double z, double yaw)
    {
      EXPECT_NEAR(T.x(), x, 1e-9);
      EXPECT_NEAR(T.y(), y, 1e-9);
      EXPECT_NEAR(T.z(), z, 1e-9);
      EXPECT_NEAR(T.yaw(), yaw, 1e-9);
      EXPECT_NEAR(T.pitch(), 0, 1e-9);
      EXPECT_NEAR(T.roll(), 0, 1e-9);
    };
    is_near(poses[0].T_map_base, 0, 0, -1.73, 0);
    is_near(poses[1].T_map_base, 2, 0, -1.73, 0);
    // The scanner swings around the camera.
    is_near(poses[2].T_map_base, 2.27, -0.27, -1.73, M_PI / 2);
  }
}

TEST_F(ScanFolder, takes_the_lines_of_the_scans_that_there_are)
{
  write_sequence(3);
  fs::remove(dir_ / "sequences/07/velodyne/000000.bin");
  const auto source = open("sequences/07");
  const auto scans = read(*source);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].time_s, 0.103725);
  EXPECT_NEAR(source->poses().entries()[0].T_map_base.x(), 2, 1e-9);

  write("few/times.txt", "1\n2\n3\n");
  write("few/a.bin", kitti_bin(scan_number(0)));
  write("few/b.bin", kitti_bin(scan_number(1)));
  refuses("few", {"times.txt: has 3 lines for 2 scans", "'b'"});
}

TEST_F(ScanFolder, of_kittis_raw_data_has_dates)
{
  for (int i = 0; i < 2; ++i)
    write(
        "drive_sync/velodyne_points/data/000000000" + std::to_string(i) + ".bin",
        kitti_bin(scan_number(i)));
  write(
      "drive_sync/velodyne_points/timestamps.txt",
      "2011-09-26 13:02:25.951199337\n2011-09-26 13:02:26.054\n");
  const auto scans = read("drive_sync");
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].sensor_label, "velodyne_points");
  EXPECT_NEAR(scans[0].time_s, 1317042145.951199337, 1e-6);  // date -u -d ... +%s
  EXPECT_NEAR(scans[1].time_s - scans[0].time_s, 0.1028, 1e-4);
  EXPECT_EQ(read_times(dir_ / "drive_sync/velodyne_points/timestamps.txt").size(), 2u);
  write("leap.txt", "2000-02-29 00:00:00\n2024-03-01 12:00:00.5\n");
  const auto leap = read_times(dir_ / "leap.txt");
  EXPECT_EQ(leap, (std::vector<double>{951782400, 1709294400.5}));
}

TEST_F(ScanFolder, without_calibration_says_what_its_poses_need)
{
  write_sequence(3);
  fs::remove(dir_ / "sequences/07/calib.txt");
  refuses("sequences/07", {"poses/07.txt", "calib.txt", "'Tr:'"});
  write("sequences/07/calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  refuses("sequences/07", {"calib.txt: has no line 'Tr:'"});
  write("sequences/07/calib.txt", "Tr: 1 0 0 0 0 1 0 0 0 0 1\n");
  refuses("sequences/07", {"calib.txt:1: has 11 numbers"});
  write("sequences/07/calib.txt", "Tr: 1 0 0 0 0 1 0 0 0 0 -1 0\n");
  refuses("sequences/07", {"calib.txt:1: has no rotation"});
  write("sequences/07/calib.txt", kCalibration);
  write("poses/07.txt", std::string(kPoses) + "1 0 0 0 0 1 0 0 0 0 nan 0\n");
  refuses("sequences/07", {"poses/07.txt:4: 'nan'"});
}

TEST_F(ScanFolder, takes_poses_and_a_mounting_that_are_given)
{
  write_sequence(3);
  write("sequences/07/poses.txt", kPoses);
  write("slam.txt", "1 0 0 5 0 1 0 0 0 0 1 0\n1 0 0 5 0 1 0 0 0 0 1 2\n1 0 0 5 0 1 0 0 0 0 1 3\n");
  SourceOptions options;
  options.poses = dir_ / "slam.txt";
  options.mountings["velodyne"] = CPose3D(1, 0, 2, 0, 0, 0);
  const auto source = open("sequences/07", options);
  EXPECT_EQ(read(*source)[0].T_base_sensor.x(), 1);
  const auto poses = source->poses().entries();
  EXPECT_NEAR(poses[2].T_map_base.x(), 3 - 1, 1e-9);
  EXPECT_NEAR(poses[2].T_map_base.y(), -5, 1e-9);
  EXPECT_NEAR(poses[2].T_map_base.z(), -2, 1e-9);
  EXPECT_TRUE(source->remarks().empty());
}

TEST_F(ScanFolder, of_other_formats_may_bring_poses_of_the_base)
{
  for (int i = 0; i < 12; ++i)  // 2 before 10
    write("lidar/scan_" + std::to_string(i) + ".ply", ply_little(scan_number(i)));
  write("lidar/notes.md", "hello");
  write("lidar/.hidden.ply", "no scan");
  write("lidar/poses.tum", "0 1 2 3 0 0 0 1\n1 4 5 6 0 0 0 1\n");
  const auto source = open("lidar");
  const auto scans = read(*source);
  ASSERT_EQ(scans.size(), 12u);
  for (int i = 0; i < 12; ++i)
    EXPECT_EQ(scans[static_cast<std::size_t>(i)].x_m[0], static_cast<float>(i));
  EXPECT_EQ(scans[10].time_s, 1.0);  // at 10 Hz
  EXPECT_EQ(scans[0].sensor_label, "lidar");
  EXPECT_EQ(source->poses().entries()[1].T_map_base.y(), 5);
  ASSERT_EQ(source->remarks().size(), 4u);
  EXPECT_EQ(
      source->remarks()[3], "10 of 12 scans have no pose at their time: talus-map skips them");
  EXPECT_NE(source->remarks()[0].find("--mount lidar="), std::string::npos);
  EXPECT_NE(source->remarks()[1].find("lidar/poses.tum"), std::string::npos);
  EXPECT_NE(source->remarks()[2].find("10 a second (--rate)"), std::string::npos);
}

TEST_F(ScanFolder, reads_names_of_nanoseconds_without_zeros_and_of_dates)
{
  for (const char* name :
       {"bare/1700000000.53000000", "bare/1700000000.153000000", "bare/1700000001.0",
        "line/1700000000_053000000", "line/1700000000_153000000", "line/1700000001_0",
        "word/cloud_1700000000_053000000", "word/cloud_1700000000_153000000",
        "word/cloud_1700000001_0", "date/20231114221320053", "date/20231114221320153",
        "date/20231114221321000", "dash/2023-11-14-22-13-20-053", "dash/2023-11-14-22-13-20-153",
        "dash/2023-11-14-22-13-21-000"})
    write(std::string(name) + ".pcd", pcd_ascii(scan_number(0)));
  for (const char* folder : {"bare", "line", "word", "date", "dash"})
  {
    const auto source = open(folder);
    const auto scans = read(*source);
    ASSERT_EQ(scans.size(), 3u) << folder;
    EXPECT_NE(source->remarks().back().find(" is 1700000000.053 s"), std::string::npos) << folder;
    EXPECT_NEAR(scans[0].time_s, 1700000000.053, 1e-6) << folder;
    EXPECT_NEAR(scans[1].time_s, 1700000000.153, 1e-6) << folder;
    EXPECT_NEAR(scans[2].time_s, 1700000001, 1e-6) << folder;
  }
  write("decimals/1700000000.053000001.pcd", pcd_ascii(scan_number(0)));
  write("decimals/1700000000.15.pcd", pcd_ascii(scan_number(1)));
  EXPECT_NEAR(read("decimals")[1].time_s, 1700000000.15, 1e-6) << "with zeros that lead";
  write("since/9.950.pcd", pcd_ascii(scan_number(0)));
  write("since/10.0.pcd", pcd_ascii(scan_number(1)));
  EXPECT_EQ(read("since")[0].time_s, 9.95);
}

TEST_F(ScanFolder, has_points_in_the_unit_that_is_said)
{
  write("mm/0.pcd", pcd_ascii(scan_number(0)));
  SourceOptions options;
  options.scale = 0.001;
  const auto scans = read(*open("mm", options)), as_they_are = read("mm");
  for (std::size_t i = 0; i < scans.at(0).x_m.size(); ++i)
    EXPECT_FLOAT_EQ(scans[0].x_m[i] * 1000, as_they_are.at(0).x_m[i]);
}

TEST_F(ScanFolder, takes_times_out_of_names_or_points_where_no_file_has_them)
{
  write("stamps/1700000000.25.pcd", pcd_ascii(scan_number(0)));
  write("stamps/1700000000.5.pcd", pcd_ascii(scan_number(1)));
  EXPECT_EQ(read("stamps")[1].time_s, 1700000000.5);
  write("nanos/1700000000250000000.bin", kitti_bin(scan_number(0)));
  EXPECT_NEAR(read("nanos")[0].time_s, 1700000000.25, 1e-6);

  for (int i = 0; i < 2; ++i)
  {
    std::string data;
    for (int k = 0; k < 3; ++k)
    {
      for (int axis = 0; axis < 3; ++axis) put(data, 1.0F);
      put(data, 1700000000.0 + i + 0.01 * k);
    }
    write(
        "inside/" + std::to_string(i) + ".pcd",
        "FIELDS x y z timestamp\nSIZE 4 4 4 8\nTYPE F F F F\nWIDTH 3\nHEIGHT 1\nDATA binary\n" +
            data);
  }
  const auto scans = read("inside");
  EXPECT_EQ(scans[1].time_s, 1700000001.0);
  ASSERT_EQ(scans[1].point_time_s.size(), 3u);
  EXPECT_NEAR(scans[1].point_time_s[2], 0.02, 1e-6);
  fs::rename(dir_ / "inside/0.pcd", dir_ / "inside/7.pcd");
  refuses("inside", {"7.pcd: its points are no later than those of", "1.pcd"});
}

TEST_F(ScanFolder, goes_on_where_a_file_links_to_itself_or_to_nothing)
{
  fs::create_directories(dir_ / "linked");
  for (const char* name : {"0.pcd", "9.ply", "times.txt"})
    fs::create_symlink(name, dir_ / (std::string("linked/") + name));
  fs::create_symlink("nowhere", dir_ / "linked/5.pcd");
  write("linked/1.pcd", pcd_ascii(scan_number(1)));
  EXPECT_EQ(Input(dir_ / "linked").format, nullptr);
  const auto scans = read("linked");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].x_m, std::vector<float>{1});
}

TEST_F(ScanFolder, of_as_many_scans_as_poses_takes_their_times)
{
  for (int i = 0; i < 2; ++i) write("ply/" + std::to_string(i) + ".ply", ply_ascii(scan_number(i)));
  write("slam.tum", "1700000003 1 2 3 0 0 0 1\n1700000007.5 4 5 6 0 0 0 1\n");
  SourceOptions options;
  options.poses = dir_ / "slam.tum";
  const auto source = open("ply", options);
  const auto scans = read(*source);
  EXPECT_EQ(scans[0].time_s, 1700000003);
  EXPECT_EQ(scans[1].time_s, 1700000007.5);
  EXPECT_NE(source->remarks().back().find("one at each of the poses"), std::string::npos);
}

TEST_F(ScanFolder, whose_poses_count_the_scans_takes_one_for_each)
{
  for (int i = 0; i < 3; ++i)
    write("scans/170000000" + std::to_string(i) + ".500000.pcd", pcd_binary(scan_number(i)));
  write("count.tum", "0.0 5 0 0 0 0 0 1\n1.0 6 0 0 0 0 0 1\n2.0 7 0 0 0 0 0 1\n");
  SourceOptions options;
  options.poses = dir_ / "count.tum";
  const auto source = open("scans", options);
  EXPECT_EQ(read(*source).size(), 3U);
  const auto poses = source->poses();
  ASSERT_EQ(poses.entries().size(), 3U);
  EXPECT_EQ(poses.entries()[2].time_s, 1700000002.5);
  EXPECT_EQ(poses.entries()[2].T_map_base.x(), 7);
}

TEST_F(ScanFolder, leaves_out_times_of_points_that_make_no_sense)
{
  Points p = scan_number(0);
  p.time = {1.7e9F};  // a float counts by 128 s there
  write("odd/times.txt", "1700001000\n");
  write("odd/0.pcd", pcd_binary(p));
  const auto source = open("odd");
  EXPECT_TRUE(read(*source)[0].point_time_s.empty());
  EXPECT_NE(source->remarks().back().find("without times of points"), std::string::npos);
}

TEST_F(ScanFolder, takes_viewpoints_for_poses_where_there_are_no_others)
{
  write("pcd/0.pcd", pcd_binary(scan_number(0), "1 2 3 1 0 0 0"));
  write("pcd/1.pcd", pcd_binary(scan_number(1), "2 2 3 1 0 0 0"));
  SourceOptions options;
  options.mountings["pcd"] = CPose3D(0, 0, 0.5, 0, 0, 0);
  const auto source = open("pcd", options);
  read(*source);
  const auto poses = source->poses().entries();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[1].T_map_base.x(), 2, 1e-9);
  EXPECT_NEAR(poses[1].T_map_base.z(), 2.5, 1e-9);
}

TEST_F(ScanFolder, that_is_wrong_says_what_and_where)
{
  refuses("nothing", {"no such file"});
  fs::create_directories(dir_ / "empty");
  refuses("empty", {"holds no scans", ".pcd"});
  write("mixed/a.pcd", pcd_ascii(scan_number(0)));
  write("mixed/b.ply", ply_ascii(scan_number(0)));
  refuses("mixed", {"several kinds", "'a.pcd'", "'b.ply'"});
  write("log.rawlog", "x");
  refuses("log.rawlog", {"A rawlog needs no import"});
  write("scan.las", "LASF....");
  refuses("scan.las", {"LAS", "pdal translate"});
  write("las/scan.laz", "LASF....");
  refuses("las", {"scan.laz", "pdal translate"});
  write("drive.bag", "#ROSBAG V2.0\n");
  refuses("drive.bag", {"ROS 1 bag", "rosbag2rawlog"});
  write("cut/0.bin", kitti_bin(scan_number(0)));
  write("cut/1.bin", "too short");
  refuses("cut", {"1.bin: has 9 bytes"});
  write("times/0.bin", kitti_bin(scan_number(0)));
  write("times/times.txt", "noon\n");
  refuses("times", {"times.txt:1: 'noon' is no time"});
  write("times/times.txt", "1\n1\n");
  refuses("times", {"times.txt:2: is no later"});
  write("times/times.txt", "1e99\n");
  refuses("times", {"times.txt:1", "no time"});
  write("times/times.txt", "2011-13-26 13:02:25.9\n");
  refuses("times", {"no time"});
  if (geteuid() != 0)  // who may list everything
  {
    fs::permissions(dir_ / "empty", fs::perms::none);
    refuses("empty", {"cannot be listed", "permissions"});
    fs::permissions(dir_ / "empty", fs::perms::owner_all);
  }
  ASSERT_EQ(mkfifo((dir_ / "pipe.bin").c_str(), 0600), 0);
  refuses("pipe.bin", {"is a pipe or a device"});
}

TEST(Formats, are_known_by_their_first_bytes_or_their_ending)
{
  const ScratchDir dir;
  const auto is_as = [&](const std::string& name, const std::string& bytes, const char* ending)
  {
    write_bytes(dir / name, bytes);
    return Input(dir / name).format == format_by_ending(ending);
  };
  EXPECT_TRUE(is_as("a", "# .PCD v0.7", ".pcd"));
  EXPECT_TRUE(is_as("b", "ply\r\nformat", ".ply"));
  EXPECT_TRUE(is_as("c", "#ROSBAG V2.0", ".bag"));
  EXPECT_TRUE(is_as("d", std::string("SQLite format 3\0", 16), ".db3"));
  EXPECT_TRUE(is_as("e", "\x89MCAP0\r\n", ".mcap"));
  EXPECT_TRUE(is_as("f.BIN", "1234", ".bin"));
  EXPECT_FALSE(is_as("f.BIN", "1234", ".pcd"));
  write_bytes(dir / "g.rawlog", "1234");
  for (const char* name : {"g.rawlog", "not there.bin", ""})
    EXPECT_EQ(Input(dir / name).format, nullptr) << name;
  std::filesystem::create_directories(dir / "bag");
  write_bytes(dir / "bag/metadata.yaml", "x");
  EXPECT_TRUE(Input(dir / "bag").is_bag());
}
