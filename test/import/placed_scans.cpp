// The frames of scans and poses: points in world coordinates or in the frame of the map, poses of
// the sensor, and what is told where ground or poses contradict them.
#include <gtest/gtest.h>
#include <talus/import/scan_source.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include "log_files.h"
#include "placed_scans.h"
#include "scan_formats.h"

using namespace talus::import;
using namespace talus::test;
using mrpt::poses::CPose3D;
namespace fs = std::filesystem;

namespace
{
constexpr double kEast_m = 585146.25, kNorth_m = 4076825.5, kUp_m = 152.3;

struct Point
{
  double x, y, z;
};

/** A floor that a sensor 0.5 m above it sees around it, denser near it, and a wall to its left. */
std::vector<Point> around_sensor()
{
  std::vector<Point> points;
  for (int ring = 1; ring <= 20; ++ring)
    for (int i = 0; i < 60; ++i)
    {
      const double range_m = 0.3 * ring, angle = 0.1047 * i;
      points.push_back({range_m * std::cos(angle), range_m * std::sin(angle), -0.5});
    }
  for (int i = 0; i < 200; ++i) points.push_back({-4 + 0.04 * i, 5, 0.01 * i});
  return points;
}

std::vector<Point> moved(const CPose3D& T, std::vector<Point> points)
{
  for (Point& p : points)
  {
    const Point q = p;
    T.composePoint(q.x, q.y, q.z, p.x, p.y, p.z);
  }
  return points;
}

/** `T`: how the file has the coordinates, double or float. */
template <class T>
std::string pcd_of(const std::vector<Point>& points, bool timed = false)
{
  const std::string size = sizeof(T) == 8 ? "8 8 8" : "4 4 4", n = std::to_string(points.size());
  std::string bytes = "VERSION 0.7\nFIELDS x y z" + std::string(timed ? " time" : "") + "\nSIZE " +
                      size + (timed ? " 4" : "") + "\nTYPE F F F" + (timed ? " F" : "") +
                      "\nWIDTH " + n + "\nHEIGHT 1\nDATA binary\n";
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    for (const double number : {points[i].x, points[i].y, points[i].z})
      put(bytes, static_cast<T>(number));
    if (timed) put(bytes, 1e-5F * static_cast<float>(i));
  }
  return bytes;
}

void expect_near(const ImportedScan& scan, const std::vector<Point>& points, double within_m)
{
  ASSERT_EQ(scan.x_m.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    ASSERT_NEAR(scan.x_m[i], points[i].x, within_m) << i;
    ASSERT_NEAR(scan.y_m[i], points[i].y, within_m) << i;
    ASSERT_NEAR(scan.z_m[i], points[i].z, within_m) << i;
  }
}

class PlacedScans : public testing::Test
{
 protected:
  /** Where the base is at scan `i`: it drives 4 m a scan in a curve, over a hill. */
  static CPose3D T_map_base(int i) { return {4.0 * i, 0.3 * i, 0.1 * i, 0.1 * i, 0.02, -0.01}; }
  static CPose3D mounting() { return {0.2, -0.1, 0.5, 0.3, 0.1, 0}; }

  void write(const std::string& name, const std::string& bytes) const
  {
    fs::create_directories(fs::path(dir_ / name).parent_path());
    write_bytes(dir_ / name, bytes);
  }
  static std::string tum_line(double time_s, const CPose3D& T)
  {
    mrpt::math::CQuaternionDouble q;
    T.getAsQuaternion(q);
    char line[300];
    std::snprintf(
        line, sizeof line, "%.3f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", time_s, T.x(), T.y(),
        T.z(), q.x(), q.y(), q.z(), q.r());
    return line;
  }
  static std::string row(const CPose3D& T)
  {
    const auto& R = T.getRotationMatrix();
    const double t[] = {T.x(), T.y(), T.z()};
    std::string text;
    for (int r = 0; r < 3; ++r)
    {
      char numbers[200];
      std::snprintf(
          numbers, sizeof numbers, "%.12f %.12f %.12f %.9f ", R(r, 0), R(r, 1), R(r, 2), t[r]);
      text += numbers;
    }
    text.back() = '\n';
    return text;
  }
  /** drive/0.pcd ... with times.txt, points in the map or in the frame of the sensor, and the poses
   * of the base in poses.tum; `T_world_map` moves all. */
  template <class T>
  void write_drive(int scans, bool in_map, const CPose3D& T_world_map = {}) const
  {
    std::string times, poses;
    for (int i = 0; i < scans; ++i)
    {
      const CPose3D T_base = T_world_map + T_map_base(i);
      const auto points = around_sensor();
      write(
          "drive/" + std::to_string(i) + ".pcd",
          pcd_of<T>(in_map ? moved(T_base + mounting(), points) : points));
      times += std::to_string(100 + i) + "\n";
      poses += tum_line(100 + i, T_base);
    }
    write("drive/times.txt", times);
    write("poses.tum", poses);
  }
  SourceOptions with_poses(const std::string& poses = "poses.tum") const
  {
    SourceOptions options;
    options.poses = dir_ / poses;
    options.mountings["drive"] = mounting();
    return options;
  }
  struct Read
  {
    std::vector<ImportedScan> scans;
    std::vector<talus::io::Trajectory::Entry> poses;
    std::string remarks;
  };
  Read read(const std::string& name, const SourceOptions& options) const
  {
    Read all;
    const auto source = open_scan_source(Input(dir_ / name), options);
    ImportedScan scan;
    while (source->next(scan)) all.scans.push_back(scan);
    all.poses = source->poses().entries();
    for (const auto& remark : source->remarks()) all.remarks += remark + "\n";
    return all;
  }
  void refuses(
      const std::string& name, const SourceOptions& options,
      const std::vector<std::string>& words) const
  {
    expect_error([&] { read(name, options); }, words);
  }
  static bool has(const std::string& text, const std::string& words)
  {
    return text.find(words) != std::string::npos;
  }
  ScratchDir dir_;
};

/** A bag whose clouds are in the frame of the map: TF mounts the map, not the sensor, on the base.
 */
class CloudsInMap : public ScanSource
{
 public:
  bool next(ImportedScan& scan) override
  {
    if (number_ == 5) return false;
    const CPose3D T_map_base(5.0 * number_, 0, 0, 0, 0, 0);
    scan = ImportedScan();
    scan.sensor_label = "/cloud_registered";
    scan.time_s = number_++;
    scan.T_base_sensor =
        mountings.count(scan.sensor_label) ? mountings[scan.sensor_label] : CPose3D(-T_map_base);
    for (const Point& p : moved(T_map_base, around_sensor()))
    {
      scan.x_m.push_back(static_cast<float>(p.x));
      scan.y_m.push_back(static_cast<float>(p.y));
      scan.z_m.push_back(static_cast<float>(p.z));
    }
    return true;
  }
  double progress() const override { return 0; }
  talus::io::Trajectory poses() override
  {
    std::vector<talus::io::Trajectory::Entry> entries;
    for (int i = 0; i < 5; ++i) entries.push_back({1.0 * i, CPose3D(5.0 * i, 0, 0, 0, 0, 0)});
    return talus::io::Trajectory(entries);
  }
  std::map<std::string, CPose3D> mountings;

 private:
  int number_ = 0;
};

const CPose3D kWorld(kEast_m, kNorth_m, kUp_m, 1, 0, 0);
}  // namespace

TEST_F(PlacedScans, in_world_coordinates_keep_their_millimetres_and_their_place)
{
  write("world.pcd", pcd_of<double>(moved(kWorld, around_sensor())));
  SourceOptions options;
  options.mountings[fs::path(dir_ / "").parent_path().filename().string()] =
      CPose3D(0, 0, 0.5, 0, 0, 0);
  const auto world = read("world.pcd", options);
  ASSERT_EQ(world.poses.size(), 1u);
  const CPose3D& T = world.poses[0].T_map_base;
  EXPECT_EQ(T.x(), std::round(T.x()));
  EXPECT_NEAR(T.x(), kEast_m, 3);
  EXPECT_NEAR(T.y(), kNorth_m, 3);
  EXPECT_NEAR(T.z(), kUp_m - 0.5, 0.011) << "the base stands on the ground";
  const CPose3D T_world_sensor = T + CPose3D(0, 0, 0.5, 0, 0, 0);
  expect_near(world.scans.at(0), moved(CPose3D(-T_world_sensor) + kWorld, around_sensor()), 1e-5);
  EXPECT_TRUE(has(world.remarks, "world coordinates: 5851")) << world.remarks;
  EXPECT_FALSE(has(world.remarks, "contradicts")) << world.remarks;
}

TEST_F(PlacedScans, in_world_coordinates_as_floats_are_refused_with_what_they_lost)
{
  write("world.pcd", pcd_of<float>(moved(kWorld, around_sensor())));
  refuses("world.pcd", {}, {"world.pcd", "4077 km", "steps of 0.25 m", "Write them as doubles"});
  // Text has all digits, whatever type its header names.
  Points p;
  p.x = p.y = p.z = {0};
  std::string text = pcd_ascii(p);
  const auto line = text.find("DATA ascii\n") + 11;
  text.replace(line, std::string::npos, "585146.25 4076825.5 152.375\n");
  write("text.pcd", text);
  EXPECT_EQ(read("text.pcd", {}).scans.at(0).y_m.at(0), -0.5F);
}

TEST_F(PlacedScans, in_world_coordinates_need_poses_where_there_are_several)
{
  write_drive<double>(3, true, kWorld);
  SourceOptions options;
  refuses("drive", options, {"4119 km", "--clouds-in map with --poses FILE"});
  refuses("drive", with_poses(), {"4119 km", "pass --clouds-in map"});
  options.clouds_in_map = true;
  refuses("drive", options, {"drive", "there is none: pass --poses FILE"});
  options.clouds_in_map = false;
  options.is_only_source = false;
  refuses("drive/0.pcd", options, {"world coordinates", "--clouds-in map"});
}

TEST_F(PlacedScans, in_the_map_come_back_to_their_sensor)
{
  for (const bool is_world : {true, false})
  {
    if (is_world)
      write_drive<double>(5, true, kWorld);
    else
      write_drive<float>(5, true);
    auto options = with_poses();
    options.clouds_in_map = true;
    const auto drive = read("drive", options);
    ASSERT_EQ(drive.scans.size(), 5u);
    for (const auto& scan : drive.scans) expect_near(scan, around_sensor(), 1e-5);
    EXPECT_EQ(drive.poses.size(), 5u);
    EXPECT_EQ(drive.remarks, "") << is_world;
  }
}

TEST_F(PlacedScans, in_the_map_without_a_pose_are_left_out_and_counted)
{
  write_drive<float>(5, true);
  write("drive/1.pcd", pcd_of<float>(moved(T_map_base(1) + mounting(), around_sensor()), true));
  write("poses.tum", tum_line(100, T_map_base(0)) + tum_line(101, T_map_base(1)));
  auto options = with_poses();
  options.clouds_in_map = true;
  const auto drive = read("drive", options);
  ASSERT_EQ(drive.scans.size(), 2u);
  EXPECT_TRUE(drive.scans[1].point_time_s.empty()) << "they would be moved a second time";
  EXPECT_TRUE(has(drive.remarks, "1 of 5 scans lose the times")) << drive.remarks;
  EXPECT_TRUE(has(drive.remarks, "3 of 5 scans have no pose at their time, and are left out"));
  write("poses.tum", tum_line(100, CPose3D(9000, 0, 0, 0, 0, 0)));
  refuses("drive", options, {"where the poses have the sensor", "not in the same frame"});
  write("poses.tum", tum_line(500, T_map_base(0)));
  refuses("drive", options, {"none at the times of the scans"});
}

TEST_F(PlacedScans, that_lie_around_the_poses_are_told_to_be_in_the_map)
{
  write_drive<float>(8, true);
  EXPECT_TRUE(has(read("drive", with_poses()).remarks, "pass --clouds-in map"));
  auto options = with_poses();
  options.clouds_in_map = true;
  EXPECT_EQ(read("drive", options).remarks, "");
  write_drive<float>(8, false);
  EXPECT_EQ(read("drive", with_poses()).remarks, "");
  EXPECT_TRUE(has(read("drive", options).remarks, "leave out --clouds-in map"));
}

TEST_F(PlacedScans, may_have_poses_of_their_sensor)
{
  write_drive<float>(4, false);
  std::string tum, rows;
  for (int i = 0; i < 4; ++i)
  {
    tum += tum_line(100 + i, T_map_base(i) + mounting());
    rows += row(T_map_base(i) + mounting());
  }
  write("sensor.tum", tum);
  write("sensor.txt", rows);
  for (const char* file : {"sensor.tum", "sensor.txt"})
  {
    auto options = with_poses(file);
    options.poses_of_sensor = true;
    const auto drive = read("drive", options);
    ASSERT_EQ(drive.poses.size(), 4u) << file;
    for (int i = 0; i < 4; ++i)
    {
      const auto& entry = drive.poses[static_cast<std::size_t>(i)];
      EXPECT_EQ(entry.time_s, 100 + i);
      EXPECT_LT((entry.T_map_base - T_map_base(i)).norm(), 1e-6) << file;
      EXPECT_NEAR(entry.T_map_base.yaw(), 0.1 * i, 1e-6) << file;
    }
  }
  // Both switches at once: what FAST-LIO writes.
  write_drive<float>(4, true);
  auto options = with_poses("sensor.tum");
  options.poses_of_sensor = options.clouds_in_map = true;
  for (const auto& scan : read("drive", options).scans) expect_near(scan, around_sensor(), 1e-5);
}

TEST_F(PlacedScans, show_the_ground_that_a_mounting_contradicts)
{
  write_drive<float>(3, false);
  auto options = with_poses();
  options.mountings["drive"] = CPose3D(0.2, 0, 0.36, 0.5, 0, 0);
  const auto wrong = read("drive", options).remarks;
  EXPECT_TRUE(has(wrong, "should be 0.36 m below the sensor and is seen 0.50 m below it")) << wrong;
  EXPECT_TRUE(has(wrong, "(--mount drive=0.2,0,0.50,28.6479,0,0)")) << wrong;
  options.mountings["drive"] = CPose3D(0.2, 0, 0.45, 0.5, 0, 0);
  EXPECT_EQ(read("drive", options).remarks, "") << "a road is not flatter";
  options.mountings.clear();
  const auto none = read("drive", options).remarks;
  EXPECT_TRUE(has(none, "is seen 0.50 m below drive (--mount drive=0,0,0.50,0,0,0)")) << none;
}

TEST_F(PlacedScans, of_kitti_360_take_the_poses_of_their_frames)
{
  // The GPS unit looks ahead, right and down; the camera right, down and ahead.
  const std::string at = "k/data_3d_raw/d_sync/velodyne_points/";
  for (const int frame : {3, 4, 6})
    write(
        at + "data/000000000" + std::to_string(frame) + ".bin",
        []
        {
          Points p;
          for (const Point& q : around_sensor())
          {
            p.x.push_back(static_cast<float>(q.x));
            p.y.push_back(static_cast<float>(q.y));
            p.z.push_back(static_cast<float>(q.z - 1.23));
          }
          return kitti_bin(p);
        }());
  std::string dates;
  for (int i = 0; i < 8; ++i) dates += "2013-05-28 08:46:0" + std::to_string(i) + ".5\n";
  write(at + "timestamps.txt", dates);
  write(
      "k/calibration/calib_cam_to_pose.txt", "image_01: 1\nimage_00: 0 0 1 1.5 1 0 0 0 0 1 0 -1\n");
  write("k/calibration/calib_cam_to_velo.txt", "0 0 1 0.75 -1 0 0 0 0 -1 0 -0.25\n");
  const std::string level = " 1 0 0 10 0 -1 0 20 0 0 -1 30\n";
  write("k/data_poses/d_sync/poses.txt", "4" + level + "6 1 0 0 12 0 -1 0 20 0 0 -1 30\n");
  const auto drive = read("k/data_3d_raw/d_sync", {});
  ASSERT_EQ(drive.scans.size(), 3u);
  EXPECT_FALSE(drive.scans[0].T_map_sensor);
  ASSERT_EQ(drive.poses.size(), 2u);
  EXPECT_NEAR(drive.poses[0].time_s - drive.scans[0].time_s, 1, 1e-6);
  const CPose3D& T = drive.poses[1].T_map_base;
  EXPECT_NEAR(T.x(), 12 + 1.5 - 0.75, 1e-9);
  EXPECT_NEAR(T.y(), 20, 1e-9);
  EXPECT_NEAR(T.z(), 30 + 1 + 0.25 - 1.73, 1e-9);
  EXPECT_NEAR(T.yaw(), 0, 1e-9);
  EXPECT_NEAR(T.roll(), 0, 1e-9);
  EXPECT_TRUE(has(drive.remarks, "1 of 3 scans have no pose at their time")) << drive.remarks;
  EXPECT_FALSE(has(drive.remarks, "contradicts")) << drive.remarks;

  write("k/data_poses/d_sync/poses.txt", "100" + level);
  refuses("k/data_3d_raw/d_sync", {}, {"poses.txt", "frames 100 to 100", "no scan"});
  write("k/data_poses/d_sync/poses.txt", "4.5" + level);
  refuses("k/data_3d_raw/d_sync", {}, {"poses.txt:1: '4.5' is not the number of a frame"});
  fs::remove_all(dir_ / "k/calibration");
  write("k/data_poses/d_sync/poses.txt", "4" + level);
  refuses("k/data_3d_raw/d_sync", {}, {"--poses-of sensor", "calibration", "data_3d_raw"});
}

TEST_F(PlacedScans, with_fewer_poses_name_the_switch_that_reads_them)
{
  write_drive<float>(5, false);
  fs::remove(dir_ / "drive/times.txt");
  write("few.tum", tum_line(100, T_map_base(0)) + tum_line(101, T_map_base(1)));
  write("few.txt", row(T_map_base(0)) + row(T_map_base(1)));
  for (const char* file : {"few.tum", "few.txt"})
  {
    auto options = with_poses(file);
    options.poses_of_sensor = true;
    refuses("drive", options, {file, "2 poses for 5 scans", "--partial", "first 2 scans"});
    options.partial = true;
    const auto drive = read("drive", options);
    EXPECT_EQ(drive.scans.size(), 2u) << file;
    EXPECT_EQ(drive.poses.size(), 2u) << file;
    EXPECT_TRUE(has(drive.remarks, "the last 3 of 5 scans of drive are left out")) << drive.remarks;
  }
  write("many.tum", read_bytes(dir_ / "poses.tum") + tum_line(200, T_map_base(9)));
  refuses("drive", with_poses("many.tum"), {"6 poses for 5 scans", "times.txt"});
}

TEST_F(PlacedScans, of_a_bag_in_the_frame_of_the_map_are_told_and_need_a_mounting)
{
  const auto read_bag = [](SourceOptions options)
  {
    auto bag = std::make_unique<CloudsInMap>();
    bag->mountings = options.mountings;
    const auto placed = place_scans(std::move(bag), "bag", options, true);
    Read all;
    ImportedScan scan;
    while (placed->next(scan)) all.scans.push_back(scan);
    all.poses = placed->poses().entries();
    for (const auto& remark : placed->remarks()) all.remarks += remark + "\n";
    return all;
  };
  SourceOptions options;
  EXPECT_TRUE(has(read_bag(options).remarks, "pass --clouds-in map"));
  options.clouds_in_map = true;
  expect_error(
      [&] { read_bag(options); },
      {"bag: --clouds-in map", "--mount /cloud_registered=X,Y,Z,YAW,PITCH,ROLL"});
  // As FAST-LIO has it: poses of the sensor, which is 0.5 m above the ground.
  options.poses_of_sensor = true;
  options.mountings["/cloud_registered"] = CPose3D(0, 0, 0.5, 0, 0, 0);
  const auto bag = read_bag(options);
  ASSERT_EQ(bag.scans.size(), 5u);
  for (const auto& scan : bag.scans) expect_near(scan, around_sensor(), 1e-5);
  EXPECT_NEAR(bag.poses.at(4).T_map_base.x(), 20, 1e-9);
  EXPECT_NEAR(bag.poses.at(4).T_map_base.z(), -0.5, 1e-9);
  EXPECT_EQ(bag.remarks, "");
}
