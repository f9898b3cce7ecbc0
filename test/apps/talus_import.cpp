// The command talus-import from end to end: the same map as of the log that the scans came from,
// its messages and exit codes, and the commands of doc/import.md.
#include <gtest/gtest.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/io/geotiff.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/observation_points.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "command_run.h"
#include "log_files.h"
#include "scan_formats.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::test;

namespace
{
constexpr double kFirst_s = 1700000000.0;

class TalusImport : public CommandTest
{
 protected:
  TalusImport() : CommandTest("PATH=" TALUS_BIN ":$PATH;") {}
  CommandEnd import(const std::string& arguments) const { return run("talus-import " + arguments); }
  void fails(const std::string& arguments, int code, const std::vector<std::string>& words) const
  {
    CommandTest::fails("talus-import " + arguments, code, words);
  }
  std::vector<SensorPoints> scans_of(const std::string& log) const
  {
    io::RawlogReader reader(dir_ / log);
    std::vector<SensorPoints> all;
    SensorPoints points;
    while (const auto obs = reader.next())
      if (points_from_observation(*obs, points)) all.push_back(points);
    return all;
  }
  static Points floor(bool timed = false) { return floor_points(20, timed); }
  static std::string tum(int count, double first_s = kFirst_s)
  {
    std::string text;
    for (int i = 0; i < count; ++i)
    {
      char line[80];
      std::snprintf(line, sizeof line, "%.1f %.1f 0 0 0 0 0 1\n", first_s + 0.1 * i, 0.2 * i);
      text += line;
    }
    return text;
  }
  /** A folder of floors with times and poses. */
  void write_floors(const std::string& folder, int count, double first_s = kFirst_s) const
  {
    write_scan_folder(path(folder), floor(), count, first_s);
  }
  void write_inputs_of_page() const;
};

/** `bytes` of doubles: the floor, moved by (east, north, up). */
std::string floor_in_world(const Points& floor, double east_m, double north_m, double up_m)
{
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(floor.size()) +
                      "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  for (std::size_t i = 0; i < floor.size(); ++i)
    for (const double number : {east_m + floor.x[i], north_m + floor.y[i], up_m + floor.z[i]})
      put(bytes, number);
  return bytes;
}

void TalusImport::write_inputs_of_page() const
{
  fs::create_directories(dir_ / "build");
  fs::create_directory_symlink(TALUS_BIN, dir_ / "build/bin");
  fs::create_directory_symlink(TALUS_SOURCE_DIR "/datasets", dir_ / "datasets");
  const std::string sequence = "dataset/sequences/00/", identity = "1 0 0 0 0 1 0 0 0 0 1 ",
                    drive = "2013_05_28_drive_0000_sync", kitti_360 = "KITTI-360/";
  Points road = floor();
  for (float& z : road.z) z = -1.73F;
  write(sequence + "velodyne/000000.bin", kitti_bin(road));
  write(sequence + "velodyne/000001.bin", kitti_bin(road));
  write(sequence + "times.txt", "0\n0.1\n");
  write(sequence + "calib.txt", "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  write("dataset/poses/00.txt", identity + "0\n" + identity + "0.5\n");
  write(
      kitti_360 + "data_3d_raw/" + drive + "/velodyne_points/data/0000000001.bin", kitti_bin(road));
  write(kitti_360 + "data_poses/" + drive + "/poses.txt", "1 " + identity + "115\n");
  write(kitti_360 + "calibration/calib_cam_to_pose.txt", "image_00: " + identity + "0\n");
  write(kitti_360 + "calibration/calib_cam_to_velo.txt", identity + "0\n");
  for (const char* folder : {"lidar", "front", "rear", "registered"}) write_floors(folder, 3);
  write("poses.tum", tum(3));
  write("slam.tum", tum(3));
  const std::string row = identity + "0.1\n";
  write("results/latest/lidar_poses_kitti.txt", row + row + row);
  for (int i = 0; i < 3; ++i)  // the base is 0.2 m farther each time, and 0.6 m below the sensor
    write(
        "registered/" + std::to_string(i) + ".pcd",
        [i]
        {
          Points p = floor();
          for (float& x : p.x) x += 0.2F * static_cast<float>(i);
          for (float& z : p.z) z += 0.6F;
          return pcd_binary(p);
        }());
  write("utm.ply", floor_in_world(floor(), 585146, 4076825, 152.5));
  write("map.pcd", pcd_binary(floor()));
}

Points points_of(const SensorPoints& scan)
{
  Points p;
  p.x = scan.x_m;
  p.y = scan.y_m;
  p.z = scan.z_m;
  p.intensity.assign(scan.x_m.size(), 0.5F);
  return p;
}

std::string number(double value)
{
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}
}  // namespace

TEST_F(TalusImport, gives_the_map_of_the_log_that_the_scans_came_from_bit_by_bit)
{
  runs("talus-sim " TALUS_SOURCE_DIR "/datasets/worlds/demo.yaml --output sim --frames 4 --quiet");
  runs("talus-map sim/demo.rawlog --backend cpu --output sim/map --quiet");
  const auto scans = scans_of("sim/demo.rawlog");
  ASSERT_EQ(scans.size(), 4u);
  const auto& T = scans[0].T_base_sensor;
  ASSERT_EQ(T.yaw(), 0);
  ASSERT_EQ(T.pitch(), 0);
  const std::string mounting = number(T.x()) + "," + number(T.y()) + "," + number(T.z()) + ",0,0,0";

  std::string times;
  for (std::size_t i = 0; i < scans.size(); ++i)
  {
    write("lidar/00000" + std::to_string(i) + ".pcd", pcd_compressed(points_of(scans[i])));
    times += number(scans[i].stamp_s) + "\n";
  }
  write("lidar/times.txt", times);
  runs(
      "talus-import lidar --poses sim/demo.tum --mount lidar=" + mounting + " --output log.rawlog");
  EXPECT_EQ(read_bytes(dir_ / "log.tum"), read_bytes(dir_ / "sim/demo.tum"));
  runs("talus-map log.rawlog --backend cpu --output map --quiet");
  for (const std::string file : {"map.tif", "site.tif"})
  {
    const auto one = io::read_geotiff(dir_ / ("sim/map/" + file)),
               other = io::read_geotiff(dir_ / ("map/" + file));
    ASSERT_EQ(one.names, other.names);
    for (std::size_t i = 0; i < one.layers.size(); ++i)
    {
      ASSERT_EQ(one.layers[i].size(), other.layers[i].size());
      const std::size_t bytes = one.layers[i].size() * sizeof(float);
      EXPECT_EQ(std::memcmp(one.layers[i].data(), other.layers[i].data(), bytes), 0)
          << file << " " << one.names[i];
    }
  }
  EXPECT_EQ(hidden(), 0);
}

TEST_F(TalusImport, keeps_stamps_labels_mountings_and_the_times_of_points)
{
  Points p = floor(true);
  p.intensity.assign(p.size(), 0.5F);
  p.ring.assign(p.size(), 7);
  write("front/1700000000.5.pcd", pcd_binary(p));
  runs("talus-import front --mount front=0.3,-0.2,0.6,90,0,-5 --output log.rawlog");
  const auto scans = scans_of("log.rawlog");
  ASSERT_EQ(scans.size(), 1u);
  const SensorPoints& s = scans[0];
  EXPECT_EQ(s.stamp_s, 1700000000.5);
  EXPECT_EQ(s.sensor_label, "front");
  EXPECT_NEAR(s.T_base_sensor.y(), -0.2, 1e-12);
  EXPECT_NEAR(s.T_base_sensor.yaw(), M_PI / 2, 1e-12);
  EXPECT_NEAR(s.T_base_sensor.roll(), -5 * M_PI / 180, 1e-12);
  EXPECT_EQ(s.x_m, p.x);
  EXPECT_EQ(s.z_m, p.z);
  ASSERT_EQ(s.time_s.size(), p.time.size());
  for (std::size_t i = 0; i < p.size(); ++i) ASSERT_NEAR(s.time_s[i], p.time[i], 1e-6);
  io::RawlogReader reader(dir_ / "log.rawlog");
  const auto obs = std::dynamic_pointer_cast<mrpt::obs::CObservationVelodyneScan>(reader.next());
  ASSERT_TRUE(obs);
  EXPECT_EQ(obs->point_cloud.intensity[0], 128);  // of 255
  EXPECT_EQ(obs->point_cloud.laser_id[0], 7);
  EXPECT_EQ(obs->point_cloud.laser_id.size(), p.size());
}

/** Photon counts, counts of which the first scan has none, and shares of one. */
TEST_F(TalusImport, keeps_intensities_in_one_scale)
{
  struct Row
  {
    std::vector<float> of_scans;
    double step;
  };
  for (const Row& row :
       {Row{{300, 2400}, 2400.0 / 255}, {{1, 100}, 1}, {{0.5F, 1}, 1.0 / 255}, {{-20, 30}, 1}})
  {
    std::string times;
    for (std::size_t i = 0; i < row.of_scans.size(); ++i)
    {
      Points p = floor(true);
      p.intensity.assign(p.size(), row.of_scans[i]);
      write("lidar/" + std::to_string(i) + ".pcd", pcd_binary(p));
      times += std::to_string(i) + "\n";
    }
    write("lidar/times.txt", times);
    const CommandEnd o = import("lidar --output log.rawlog");
    ASSERT_EQ(o.code, 0) << o.text;
    EXPECT_EQ(o.text.find("256 steps") != std::string::npos, row.step != 1) << o.text;
    runs("talus-map log.rawlog --static --channels intensity:max --output map --quiet");
    const auto map = io::read_geotiff(dir_ / "map/map.tif");
    const auto& values = *map.find("intensity");
    EXPECT_NEAR(
        *std::max_element(
            values.begin(), values.end(), [](float a, float b) { return std::isnan(a) || a < b; }),
        row.of_scans[1], 1e-3);
    io::RawlogReader reader(dir_ / "log.rawlog");
    for (const float value : row.of_scans)
    {
      const auto obs =
          std::dynamic_pointer_cast<mrpt::obs::CObservationVelodyneScan>(reader.next());
      ASSERT_TRUE(obs);
      const double least = std::min(0.0F, row.of_scans[0]);
      EXPECT_NEAR(least + row.step * obs->point_cloud.intensity[0], value, row.step / 2);
    }
  }
}

/** A hall with a box and a ceiling, as a SLAM program wrote it. */
TEST_F(TalusImport, of_a_whole_map_claims_no_ground_inside_of_things)
{
  Points p;
  const auto add = [&p](double x, double y, double z)
  {
    p.x.push_back(static_cast<float>(x));
    p.y.push_back(static_cast<float>(y));
    p.z.push_back(static_cast<float>(z - 0.7));
  };
  for (double x = -1; x < 19; x += 0.05)
    for (double y = -3; y < 3; y += 0.05)
    {
      const bool in_box = x > 5 && x < 6 && y > 1 && y < 2;
      if (!in_box) add(x, y, 0);
      add(x, y, 2.6);
    }
  for (double z = 0; z < 2.6; z += 0.05)
    for (double u = -1; u < 19; u += 0.05)
      for (const double y : {-3.0, 3.0}) add(u, y, z);
  for (double z = 0; z < 1; z += 0.05)
    for (double u = 0; u < 1; u += 0.05)
    {
      for (const double x : {5.0, 6.0}) add(x, 1 + u, z);
      for (const double y : {1.0, 2.0}) add(5 + u, y, z);
    }
  write("hall/map.pcd", pcd_binary(p));
  const CommandEnd o =
      run("talus-map hall/map.pcd --mount hall=0,0,0.7,0,0,0 -s resolution=0.1 --output map");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_SAYS(o.text, "--clouds-in sensor");
  EXPECT_SAYS(o.text, " tiles of hall, ");
  for (const char* wrong : {"hint", " scans", " frame", " poses", "m of way"})
    EXPECT_SAYS_NOT(o.text, wrong);
  const auto site = io::read_geotiff(dir_ / "map/site.tif", {"traversability"});
  const auto shares = [&](double x0_m, double x1_m, double y0_m, double y1_m)
  {
    double all = 0, free = 0, blocked = 0;
    for (int y = 0; y < site.cells_y; ++y)
      for (int x = 0; x < site.cells_x; ++x)
      {
        const double x_m = site.min_x_m + (x + 0.5) * site.resolution_m;
        const double y_m = site.min_y_m + (y + 0.5) * site.resolution_m;
        if (x_m < x0_m || x_m > x1_m || y_m < y0_m || y_m > y1_m) continue;
        const float score = site.layers[0][static_cast<std::size_t>(y * site.cells_x + x)];
        ++all;
        free += score > 0 ? 1 : 0;
        blocked += score <= 0 ? 1 : 0;
      }
    return std::pair(free / all, blocked / all);
  };
  EXPECT_EQ(shares(5.1, 5.9, 1.1, 1.9).first, 0) << "nothing is known of the inside of the box";
  EXPECT_GT(shares(4.9, 5.1, 1.1, 1.9).second, 0.4);
  EXPECT_GT(shares(-0.5, 4.5, -2.5, 2.5).first, 0.95);
  EXPECT_GT(shares(13, 18, -2.5, 2.5).first, 0.95) << "all of the map, not a window of it";
  expect_end(run("talus-map hall/map.pcd --static --output no"), 1, {"--static", "--clouds-in"});
  runs("talus-import hall/map.pcd --clouds-in sensor --output scan.rawlog");
  EXPECT_EQ(scans_of("scan.rawlog").size(), 1u);

  write(
      "seen.pcd",
      "VERSION 0.7\nFIELDS x y z vp_x vp_y vp_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
      "COUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
      "1 0 0 0 0 0.6\n2 0 0 1 0 0.6\n");
  expect_end(run("talus-map seen.pcd --static --output no"), 1, {"--static", "--clouds-in"});
}

TEST_F(TalusImport, tells_what_it_read_and_what_is_missing)
{
  Points p = floor();
  p.x[3] = std::nanf("");
  write("lidar/0.ply", ply_little(p));
  write("lidar/1.ply", ply_little(floor()));
  CommandEnd o = import("lidar --rate 5 --output out/new/log.rawlog");
  EXPECT_EQ(o.code, 0);
  for (const char* words :
       {"out/new/log.rawlog: 2 scans of lidar, 3361 points (1 more are not finite: left out)",
        "poses   no poses: talus-map needs --trajectory FILE, or --static", "5 a second (--rate)",
        "--mount lidar=", "wrote   out/new/log.rawlog\n"})
    EXPECT_SAYS(o.text, words);
  EXPECT_FALSE(fs::exists(dir_ / "out/new/log.tum"));
  EXPECT_NEAR(scans_of("out/new/log.rawlog")[1].stamp_s, 0.2, 1e-6);
  runs("talus-map out/new/log.rawlog --backend cpu --static --output map --quiet");

  write("poses.tum", tum(4, 0));
  o = import("lidar --poses poses.tum --output log.rawlog");
  EXPECT_SAYS(o.text, "poses   4 poses of poses.tum over 0.6 m");
  EXPECT_SAYS(o.text, "wrote   log.rawlog and log.tum");
  EXPECT_EQ(import("lidar --output log2.rawlog --quiet").text, "");
  for (float* v : {p.x.data(), p.y.data(), p.z.data()})
    for (std::size_t i = 0; i < p.size(); ++i) v[i] *= 2000;  // of a floor twice as large
  write("mm/0.ply", ply_little(p));
  o = import("mm --output mm.rawlog");
  EXPECT_SAYS(o.text, "m: are these millimetres (--scale 0.001)?");
  EXPECT_SAYS_NOT(import("mm --scale 0.001 --output mm.rawlog").text, "millimetres");
}

TEST_F(TalusImport, merges_sensors_in_the_order_of_time)
{
  write_floors("front", 3);
  write_floors("rear", 3, kFirst_s + 0.05);
  write("poses.tum", tum(4));
  runs(
      "talus-import front rear --poses poses.tum --mount rear=-0.3,0,0.5,180,0,0 "
      "--mount front=0.3,0,0.5,0,0,0 --output log.rawlog");
  const auto scans = scans_of("log.rawlog");
  ASSERT_EQ(scans.size(), 6u);
  for (std::size_t i = 0; i < scans.size(); ++i)
  {
    EXPECT_EQ(scans[i].sensor_label, i % 2 ? "rear" : "front");
    EXPECT_NEAR(scans[i].T_base_sensor.x(), i % 2 ? -0.3 : 0.3, 1e-12);
    EXPECT_NEAR(scans[i].stamp_s, kFirst_s + 0.05 * static_cast<double>(i), 1e-6);
  }
  fs::rename(dir_ / "rear", dir_ / "back");
  fs::create_directories(dir_ / "b");
  fs::rename(dir_ / "back", dir_ / "b/front");
  fails(
      "front b/front --output x.rawlog", 1,
      {"front and b/front: both have scans of 'front'", "Rename"});
  fails("front/0.pcd front/1.pcd --output x.rawlog", 1, {"give the folder"});
}

TEST_F(TalusImport, leaves_everything_as_it_was_when_it_fails)
{
  write("log.rawlog", "precious");
  write("log.tum", "precious too");
  write_floors("cut", 3);
  fs::resize_file(dir_ / "cut/2.pcd", 1000);
  fails("cut --output log.rawlog", 1, {"cut/2.pcd", "is cut"});
  fails("none --output log.rawlog", 1, {"none: no such file"});
  write_floors("lidar", 3);
  fails("lidar --output log.rawlog", 1, {"log.tum: lies there already", "--poses"});
  write("poses.tum", tum(3, 5));
  fails("lidar --poses poses.tum --output log.rawlog", 1, {"its poses are of 5 to", "same clock"});
  write("kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  fails("lidar --poses kitti.txt --output log.rawlog", 1, {"calib.txt", "'Tr:'"});
  fails(
      "lidar --mount lidr=0,0,1,0,0,0 --output x.rawlog", 1, {"--mount lidr", "there are: lidar"});
  fails("lidar --poses lidar --output x.rawlog", 1, {"is a directory"});
  write("empty/0.pcd", pcd_header(Points(), "ascii"));
  fails("empty --output x.rawlog", 1, {"not a single point"});
  EXPECT_EQ(read_bytes(dir_ / "log.rawlog"), "precious");
  EXPECT_EQ(read_bytes(dir_ / "log.tum"), "precious too");
  EXPECT_FALSE(fs::exists(dir_ / "x.rawlog"));
  EXPECT_EQ(hidden(), 0);
}

TEST_F(TalusImport, writes_a_log_whose_name_begins_with_a_dot)
{
  write_floors("lidar", 2);
  write("poses.tum", tum(2));
  runs("talus-import lidar --poses poses.tum --output .hidden.rawlog");
  EXPECT_EQ(scans_of(".hidden.rawlog").size(), 2U);
  EXPECT_EQ(read_bytes(dir_ / ".hidden.tum"), tum(2));
  EXPECT_EQ(hidden(), 2);
  runs("talus-map .hidden.rawlog --rawlog-out .copy.rawlog --quiet --backend cpu");
  EXPECT_GT(scans_of(".copy.rawlog").size(), 1U);
  EXPECT_EQ(hidden(), 3);
}

TEST_F(TalusImport, names_mistakes_of_its_command_line)
{
  write_floors("lidar", 1);
  fails("lidar", 2, {"--output is required"});
  fails("lidar --output log", 2, {"ends in .rawlog"});
  fails("lidar --output log.rawlog --mount lidar=1,2,3", 2, {"fewer than six numbers"});
  fails("lidar --output log.rawlog --mount l=1,2,3,4,5,nan", 2, {"'nan'"});
  fails("lidar --output log.rawlog --rate 0", 2, {"--rate"});
  fails("lidar --fields x,y --output log.rawlog", 2, {"--fields", "no z"});
  fails("lidar --fields x,y,z --output log.rawlog", 1, {"lidar/0.pcd", "leave out --fields"});
  fails("lidar --clouds-in space --output log.rawlog", 2, {"--clouds-in"});
  fails("lidar --poses-of robot --output log.rawlog", 2, {"--poses-of"});
  fails("--help", 0, {"Examples:", "sequences/00", "Exit codes"});
  fails("--version", 0, {"talus-import 0."});
}

TEST_F(TalusImport, is_what_commands_of_rawlogs_name_for_scans_of_other_programs)
{
  write_floors("lidar", 2);
  write("sequence/velodyne/0.bin", kitti_bin(floor()));
  write("a.ply", ply_big(floor()));
  write("drive.bag", "#ROSBAG V2.0\n");
  write("bag/metadata.yaml", "rosbag2_bagfile_information:\n");
  for (const char* source :
       {"lidar", "lidar/0.pcd", "sequence", "sequence/velodyne/0.bin", "a.ply", "bag", "drive.bag"})
  {
    const CommandEnd o = run(std::string("talus-calibrate ") + source);
    EXPECT_EQ(o.code, 1);
    EXPECT_SAYS(o.text, std::string("talus-import ") + source + " --output LOG.rawlog");
  }
  EXPECT_SAYS(run("talus-map drive.bag").text, "rosbag2rawlog drive.bag");
  fails("drive.bag --output log.rawlog", 1, {"rosbag2rawlog drive.bag", "doc/import_bags.md"});
}

TEST_F(TalusImport, runs_the_commands_of_its_page)
{
  const std::string page = read_bytes(TALUS_SOURCE_DIR "/doc/import.md");
  std::string commands;
  for (auto begin = page.find("```sh\n"); begin != std::string::npos;
       begin = page.find("```sh\n", begin + 1))
    commands += page.substr(begin + 6, page.find("```", begin + 6) - begin - 6);
  ASSERT_NE(commands.find("talus-map dataset/sequences/00"), std::string::npos);
  write_inputs_of_page();

  const std::string more = "\\\n";
  for (auto at = commands.find(more); at != std::string::npos; at = commands.find(more))
    commands.erase(at, more.size());
  std::istringstream lines(commands);
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("./dev", 0) != 0)
    {
      const bool maps = line.find("talus-map") != std::string::npos;
      runs(line + (maps ? " --backend cpu" : ""));
    }
  EXPECT_TRUE(fs::exists(dir_ / "00/site.png"));
  EXPECT_TRUE(fs::exists(dir_ / "drive/site.png"));
  EXPECT_EQ(scans_of("both.rawlog").size(), 6u);
  const auto z_m = [this](const char* tum)
  { return io::Trajectory::load(dir_ / tum).entries().back().T_map_base.z(); };
  EXPECT_NEAR(z_m("kiss.tum"), 0.1 - 0.6, 1e-9);
  EXPECT_NEAR(z_m("mola.tum"), -0.6, 1e-9);
  EXPECT_NEAR(z_m("360.tum"), 115 - 1.73, 1e-9);
  EXPECT_NEAR(z_m("utm.tum"), 152, 0.02);
  EXPECT_EQ(scans_of("map.rawlog").at(2).x_m.at(0), floor().x[0]);
}

TEST_F(TalusImport, tells_nothing_false_of_real_scans)
{
  for (const char* name : {"street", "mover", "offroad_a"})
  {
    const std::string data = TALUS_TEST_DATA + std::string("/") + name;
    if (!fs::exists(data + ".rawlog")) GTEST_SKIP() << data << ".rawlog is not there";
    io::RawlogReader reader(data + ".rawlog");
    SensorPoints points;
    std::string times;
    const std::string folder = name;
    int count = 0;
    for (auto obs = reader.next(); obs && count < 12; obs = reader.next())
    {
      if (!points_from_observation(*obs, points)) continue;
      Points p = points_of(points);
      for (std::size_t i = 0; i < p.size(); ++i) p.intensity[i] = std::fmod(p.x[i] * p.x[i], 1.0F);
      write(folder + "/" + std::to_string(count++) + ".bin", kitti_bin(p));
      times += number(points.stamp_s) + "\n";
    }
    write(folder + "/times.txt", times);
    const auto& T = points.T_base_sensor;
    std::string mounting;
    for (const double n :
         {T.x(), T.y(), T.z(), T.yaw() * 180 / M_PI, T.pitch() * 180 / M_PI, T.roll() * 180 / M_PI})
      mounting += (mounting.empty() ? "" : ",") + number(n);
    const CommandEnd o = import(
        folder + " --poses " + data + ".tum --mount " + folder + "=" + mounting + " --output " +
        folder + ".rawlog");
    EXPECT_EQ(o.code, 0) << o.text;
    EXPECT_SAYS_NOT(o.text, "  note");
  }
}

TEST_F(TalusImport, names_the_switches_that_read_bags_which_are_cut_or_have_two_clocks)
{
  if (run("python3 -S " TALUS_SOURCE_DIR "/test/import/make_bags.py . boot_clouds.mcap").code != 0)
    GTEST_SKIP() << "no bags can be made here: python3, zstd, lz4?";
  fails("boot_clouds.mcap --stamped-times --output log.rawlog", 1, {"--recorded-times"});
  runs("talus-import boot_clouds.mcap --recorded-times --output boot.rawlog");
  runs("talus-import boot_clouds.mcap --output by_itself.rawlog");
  for (const char* log : {"boot.rawlog", "by_itself.rawlog"})
    EXPECT_NEAR(scans_of(log).at(9).stamp_s, kFirst_s + 0.86, 1e-6)
        << "0.05 s before it was recorded";
  write("lidar/0.bin", std::string(16, '\0'));
  fails("lidar --partial --output log.rawlog", 1, {"lidar: is no ROS 2 bag, and --partial is for"});
  fails("none.db3 --partial --output log.rawlog", 1, {"none.db3: no such file"});
}
