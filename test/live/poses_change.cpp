// What is done where poses change after they were mapped.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "command_run.h"
#include "jump_finder.h"
#include "remaker.h"
#include "robot.h"

using namespace talus::app;
using namespace talus::test;
using mrpt::poses::CPose3D;
using talus::import::StreamPose;

namespace
{
constexpr int kScans = 60;  //!< ten a second, once around
constexpr double kRadius_m = 4;

CPose3D T_world_base(double scan)
{
  const double angle = 2 * M_PI * scan / kScans;
  return {kRadius_m * std::sin(angle), kRadius_m * (1 - std::cos(angle)), 0, angle, 0, 0};
}

/** It drifts by 1.2 m around. */
CPose3D T_odom_base(double scan)
{
  return CPose3D(0.02 * scan, 0, 0, 0, 0, 0) + T_world_base(scan);
}

double time_of(double scan) { return kStart_s + 0.1 * scan; }

StreamPose pose_at(double scan, const CPose3D& T_map_odom = {})
{
  const auto T = T_map_odom + T_odom_base(scan);
  return {talus::io::as_in_tum({time_of(scan), T}), T_map_odom};
}

/** A floor with posts on a lattice of the world. */
talus::import::ImportedScan scan_at(int i)
{
  talus::import::ImportedScan scan;
  scan.sensor_label = "/points";
  scan.time_s = time_of(i);
  scan.T_base_sensor = CPose3D(0, 0, 0.5, 0, 0, 0);
  const auto floor = floor_points();
  scan.x_m = floor.x_m, scan.y_m = floor.y_m, scan.z_m = floor.z_m;
  for (int x = -6; x <= 6; x += 2)
    for (int y = -3; y <= 11; y += 2)
      for (int step = 0; step < 20; ++step)
      {
        const CPose3D post = (-(T_world_base(i) + scan.T_base_sensor)) +
                             CPose3D(x + 0.03, y + 0.03, 0.05 * step, 0, 0, 0);
        scan.x_m.push_back(static_cast<float>(post.x()));
        scan.y_m.push_back(static_cast<float>(post.y()));
        scan.z_m.push_back(static_cast<float>(post.z()));
      }
  return scan;
}

Poses true_poses(double from, double to)
{
  Poses poses;
  for (double scan = from; scan <= to; ++scan)
    poses.push_back(talus::io::as_in_tum({time_of(scan), T_world_base(scan)}));
  return poses;
}

void write_tum(const std::string& path, const Poses& poses)
{
  std::ofstream file(path);
  for (const auto& pose : poses) file << talus::io::tum_line(pose);
}

double max_error_m(const Poses& poses)
{
  double max_m = 0;
  for (const auto& pose : poses)
    max_m =
        std::max(max_m, pose.T_map_base.distanceTo(T_world_base(10 * (pose.time_s - kStart_s))));
  return max_m;
}

/** Records a drive that begins to drift, and maps it. */
class DrivenMap
{
 public:
  explicit DrivenMap(const std::string& corrected_trajectory = "")
  {
    options.corrected_path = "/path";
    options.corrected_trajectory = corrected_trajectory;
    settings.backend = talus::Backend::Cpu;
    settings.threads = 2;
    for (const char* folder : {"record", "live"}) std::filesystem::create_directories(dir / folder);
    map = std::make_unique<DriveMap>(settings, 512, dir / "record", "");
    remaker.emplace(options, settings, dir / "record");
  }
  void drive(int from, int to, const CPose3D& T_map_odom = {})
  {
    for (int i = from; i < to; ++i)
    {
      const std::vector poses{pose_at(i, T_map_odom), pose_at(i + 0.5, T_map_odom)};
      remaker->add(poses, jump_finder.add(poses), now_s = time_of(i));
      const auto scan = scan_at(i);
      remaker->add(scan);
      EXPECT_EQ(map->add(scan, remaker->poses()), "");
      work();
    }
  }
  void publish(const Poses& poses) { remaker->take_path({"map", poses}, "map", now_s); }
  void work()
  {
    if (auto made = remaker->work(now_s))
    {
      map = std::move(made);
      ++remakes;
    }
    for (const auto& text : remaker->take_news()) news += text + "\n";
    for (const auto& text : remaker->take_errors()) errors += text + "\n";
  }
  void finish_work()
  {
    for (remaker->hurry(); remaker->is_at_work(); remaker->hurry())
    {
      work();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  /** Whether talus-map makes the same of the record, without and with a trajectory of these. */
  void expect_map_of(const Poses& poses)
  {
    remaker->close();
    map->finish(dir / "live");
    const std::string site = read_bytes(dir / "live/site.tif");
    const std::string again =
        TALUS_MAP_EXE " --quiet --backend cpu --output map record/record.rawlog";
    expect_end(run_in(dir / "", again), 0, {});
    EXPECT_TRUE(site == read_bytes(dir / "map/site.tif")) << "of record.tum";
    if (poses.empty()) return;
    write_tum(dir / "new.tum", poses);
    expect_end(run_in(dir / "", again + " --trajectory new.tum"), 0, {});
    EXPECT_TRUE(site == read_bytes(dir / "map/site.tif"));
  }

  const ScratchDir dir;
  Options options;
  Settings settings;
  std::optional<Remaker> remaker;
  std::unique_ptr<DriveMap> map;
  JumpFinder jump_finder{settings.parameters.resolution_m};
  double now_s = kStart_s;
  int remakes = 0;
  std::string news, errors;
};
}  // namespace

TEST(CorrectedPoses, undo_a_constant_drift_of_position_and_heading)
{
  for (const double turn_rad : {0.0, 0.01})  // a pose
  {
    Poses drifted{{time_of(0), T_world_base(0)}};
    for (int i = 1; i <= kScans; ++i)
    {
      const auto step = T_world_base(i) - T_world_base(i - 1);
      auto T = drifted.back().T_map_base + step;
      T.setYawPitchRoll(T.yaw() + turn_rad, 0, 0);
      if (turn_rad == 0) T.x_incr(0.02);
      drifted.push_back({time_of(i), T});
    }
    const auto& end = drifted.back().T_map_base;
    EXPECT_GT(max_error_m(drifted), 1);
    Correction correction;
    correction.jumps = {{time_of(kScans), T_world_base(kScans) + (-end)}};
    drifted.back().T_map_base = T_world_base(kScans);
    const auto fixed = corrected(drifted, correction);
    ASSERT_EQ(fixed.poses.size(), drifted.size());
    EXPECT_LT(max_error_m(fixed.poses), turn_rad == 0 ? 0.02 : 0.1) << "steps of 0.4 m";
    EXPECT_TRUE(fixed.T_after == CPose3D());
  }
}

TEST(CorrectedPoses, keep_what_a_jump_takes_back_and_move_all_where_no_drift_explains_it)
{
  const CPose3D T_jump(1, 0, 0, 0, 0, 0);
  Poses heard;
  for (int i = 0; i <= kScans; ++i)
    heard.push_back(talus::io::as_in_tum({time_of(i), T_world_base(i)}));
  auto there = heard;
  for (int i : {40, 41}) there[i] = {time_of(i), T_jump + T_world_base(i)};
  const auto kept = corrected(there, {{}, {{time_of(40), T_jump}, {time_of(42), -T_jump}}});
  EXPECT_LT(max_error_m(kept.poses), 1e-6) << "there and back";

  auto late = heard;
  for (int i = 0; i < 5; ++i) late[i].T_map_base = (-T_jump) + T_world_base(i);
  const auto all = corrected(late, {{}, {{time_of(5), T_jump}}});
  EXPECT_LT(max_error_m(all.poses), 1e-6) << "the robot is told where it is";
}

TEST(CorrectedPoses, fill_the_gaps_of_those_that_are_given)
{
  Poses heard, given;
  for (int i = 0; i <= kScans; ++i) heard.push_back(pose_at(i));
  for (int i = 10; i <= 50; i += 10) given.push_back(true_poses(i, i)[0]);
  const auto all = corrected(heard, {given, {}});
  ASSERT_EQ(all.poses.size(), heard.size());
  for (int i = 10; i <= 50; ++i) EXPECT_LT(max_error_m({all.poses[i]}), 0.02) << i;
  EXPECT_LT(max_error_m({all.poses.back()}), 0.21) << "drifts on from the last one";
  EXPECT_LT(max_error_m({moved(pose_at(kScans + 1), all.T_after)}), 0.23);
}

TEST(JumpFinder, finds_jumps_but_no_drift_and_no_odometry_that_begins_anew)
{
  const auto jumps_of = [](const std::function<StreamPose(int)>& pose)
  {
    JumpFinder finder(0.05);
    int count = 0;
    for (int i = 0; i < 100; ++i) count += static_cast<int>(finder.add({pose(i)}).size());
    return count;
  };
  const CPose3D far(2, 0, 0, 0, 0, 0);
  EXPECT_EQ(jumps_of([](int i) { return pose_at(0.2 * i); }), 0);
  EXPECT_EQ(jumps_of([&](int i) { return pose_at(0.2 * i, i < 50 ? CPose3D() : far); }), 1);
  EXPECT_EQ(
      jumps_of([&](int i) { return pose_at(0.2 * i, CPose3D(0.001 * i, 0, 0, 0, 0, 0)); }), 0);
  EXPECT_EQ(
      jumps_of(
          [&](int i)
          {
            auto pose = pose_at(0.2 * i);
            if (i >= 50) pose.T_map_odom = far;
            return pose;
          }),
      0);
}

TEST(WatchedTrajectory, waits_until_a_new_file_is_whole)
{
  const ScratchDir dir;
  const std::string path = dir / "new.tum";
  write_tum(path, true_poses(0, 3));
  WatchedTrajectory watched(path);
  EXPECT_FALSE(watched.take(0)) << "of before";
  write_bytes(path, read_bytes(path) + "1700000009.5 1 2 3 0 0");
  for (const double now_s : {1.0, 2.0, 5.0}) EXPECT_FALSE(watched.take(now_s)) << "half a line";
  EXPECT_THROW(watched.take(7), std::runtime_error);
  EXPECT_FALSE(watched.take(8)) << "told once";
  write_tum(path, true_poses(0, 5));
  EXPECT_FALSE(watched.take(9)) << "may be written on";
  const auto poses = watched.take(10);
  ASSERT_TRUE(poses);
  EXPECT_EQ(poses->size(), 6U);
  EXPECT_FALSE(watched.take(11));
}

TEST(PosesChange, a_path_gives_the_map_of_talus_map_with_it)
{
  DrivenMap drive;
  drive.drive(0, kScans);
  const auto path = true_poses(0, kScans - 1);
  drive.publish(path);
  drive.finish_work();
  EXPECT_EQ(drive.remakes, 1) << drive.errors;
  EXPECT_SAYS(drive.news, "60 corrected poses of /path: the map of 60 scans is made again");
  EXPECT_SAYS(drive.news, "m on average, by 1.1");
  drive.publish(path);
  EXPECT_FALSE(drive.remaker->is_at_work()) << "nothing has moved";
  drive.expect_map_of(path);
}

TEST(PosesChange, the_newest_of_several_wins_and_scans_that_come_meanwhile_are_mapped)
{
  DrivenMap drive;
  const CPose3D T_jump = T_world_base(30) + (-T_odom_base(30));
  drive.drive(0, 30);
  drive.drive(30, 40, T_jump);
  EXPECT_FALSE(drive.remaker->is_making()) << "a SLAM may go on to correct";
  drive.drive(40, 42, T_jump);
  EXPECT_SAYS(drive.news, "map -> odom has jumped by 0.60 m: ");
  auto first = true_poses(0, 41);
  for (auto& pose : first) pose.T_map_base.x_incr(0.5);
  drive.publish(first);
  const auto second = true_poses(0, 42);
  drive.publish(second);
  drive.drive(42, 50, T_jump);
  drive.finish_work();
  drive.drive(50, kScans, T_jump);
  drive.finish_work();
  EXPECT_EQ(drive.remakes, 2) << drive.news << drive.errors;
  EXPECT_LT(max_error_m(drive.remaker->history()), 0.7) << "it drifts on";
  EXPECT_LT(max_error_m({drive.remaker->history()[20]}), 1e-6);
  drive.expect_map_of({});
}

TEST(PosesChange, a_jump_alone_corrects_what_has_drifted)
{
  DrivenMap drive;
  const CPose3D T_jump = T_world_base(50) + (-T_odom_base(50));
  drive.drive(0, 50);
  drive.drive(50, kScans, T_jump);
  EXPECT_GT(max_error_m(drive.remaker->history()), 0.9);
  drive.finish_work();
  EXPECT_EQ(drive.remakes, 1) << drive.news << drive.errors;
  EXPECT_LT(max_error_m(drive.remaker->history()), 0.21);
  drive.expect_map_of({});
}

TEST(PosesChange, a_file_that_is_written_anew_counts_and_a_damaged_record_changes_nothing)
{
  const ScratchDir folder;
  const std::string file = folder / "new.tum";
  DrivenMap drive(file);
  drive.drive(0, kScans);
  const auto write = [&](const Poses& poses)
  {
    write_tum(file, poses);
    for (int i = 0; i < 2; ++i)
    {
      drive.now_s += 1;
      drive.work();
    }
  };
  write(true_poses(0, 30));
  drive.finish_work();
  EXPECT_EQ(drive.remakes, 1) << drive.errors;
  write(true_poses(0, kScans));
  drive.finish_work();
  EXPECT_EQ(drive.remakes, 2) << drive.errors;
  const auto* map = drive.map.get();
  {
    const std::string log = drive.dir / "record/record.rawlog", bytes = read_bytes(log);
    std::filesystem::resize_file(log, bytes.size() / 2);
    write(true_poses(0, kScans - 1));
    drive.finish_work();
    EXPECT_SAYS(drive.errors, "the map is not made again, it stays as it is: ");
    EXPECT_EQ(drive.map.get(), map);
    write_bytes(log, bytes);
  }
  EXPECT_THROW(drive.publish(true_poses(-100, -90)), std::runtime_error);
  write(true_poses(-100, -90));
  EXPECT_SAYS(drive.errors, "its poses are of another time than the scans");
  drive.expect_map_of(true_poses(0, kScans));
}
