// The command talus-map from end to end: what it writes, and how logs, poses and options reach it.
#include "talus_map_run.h"

#include <talus/io/geotiff.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "packing.h"

using namespace talus;
using namespace talus::test;

TEST_F(TalusMap, maps_a_single_scan_of_a_velodyne)
{
  const std::string log = stock_dataset("test_velodyne_VLP16.rawlog");
  TALUS_SKIP_WITHOUT(log);
  const CommandEnd done = runs(log + " --static --output out");
  EXPECT_SAYS(done.out, "1 frame,");
  EXPECT_EQ(entries(), 10u) << "the folder and nine files, nothing hidden";
  EXPECT_TRUE(exists("out/map.png"));
  EXPECT_TRUE(exists("out/timing.csv"));
  const auto j = summary("out");
  EXPECT_EQ(j["frames"], 1);
  EXPECT_EQ(j["points"]["in"], 22591) << "all returns of all blocks";
  EXPECT_EQ(j["backend"], "cpu");
  const auto map = io::read_geotiff(path("out/map.tif"));
  EXPECT_EQ(
      map.names, (std::vector<std::string>{
                     "traversability", "ground_elevation", "elevation", "variance", "state",
                     "reached", "slope", "step", "roughness", "sparsity"}))
      << "the first six as in site.tif";
  EXPECT_EQ(map.cells_x, 160);
  constexpr double kStamp_s = 1519637061.085268;
  write_bytes(path("t.tum"), straight_tum(20, std::floor(kStamp_s) - 1));
  runs(log + " --trajectory t.tum --output out");
  EXPECT_EQ(summary("out")["frames_deskewed"], 1) << "its points have times";
}

TEST_F(TalusMap, writes_the_risk_where_it_is_asked_for)
{
  write_log(path("drive.rawlog"), floor_scans(3), Packing::Gz);
  write_bytes(path("drive.tum"), straight_tum(3));
  runs("drive.rawlog --risk");
  const auto map = io::read_geotiff(path("drive_map/map.tif"));
  ASSERT_EQ(map.names.back(), "risk");
  const auto& scores = *map.find("traversability");
  for (std::size_t i = 0; i < scores.size(); ++i)
  {
    const float risk = map.layers.back()[i];
    ASSERT_EQ(std::isnan(risk), std::isnan(scores[i])) << i;
    EXPECT_FALSE(risk < 0 || risk > 1) << i;
    EXPECT_TRUE(scores[i] != 0 || risk == 1) << i;
  }
}

TEST_F(TalusMap, takes_the_trajectory_beside_the_log)
{
  write_log(path("drive.rawlog"), floor_scans(8), Packing::Gz);
  write_bytes(path("drive.tum"), straight_tum(8));
  runs("drive.rawlog --every 4");
  const auto j = summary("drive_map");
  EXPECT_EQ(j["frames"], 8);
  EXPECT_EQ(j["poses"], "drive.tum");
  EXPECT_EQ(j["snapshots"], 2);
  for (const char* name : {"frame_000004.tif", "frame_000004.png", "frame_000008.tif"})
    EXPECT_TRUE(exists(std::string("drive_map/frames/") + name)) << name;
  EXPECT_FALSE(exists("drive_map/frames/frame_000002.tif"));

  const auto map = io::read_geotiff(path("drive_map/map.tif"));
  EXPECT_NEAR(map.min_x_m + 4, 0.7, 0.051) << "the window follows the robot by whole cells";
  double worst_m = 0;
  for (const float z : *map.find("ground_elevation"))
    if (std::isfinite(z)) worst_m = std::max(worst_m, std::abs(static_cast<double>(z)));
  EXPECT_LT(worst_m, 1e-5) << "the floor is at z = 0 of the map";
  const auto csv = read_bytes(path("drive_map/timing.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9);
}

TEST_F(TalusMap, finds_the_trajectory_beside_a_compressed_log_and_prefers_the_one_given)
{
  write_log(path("drive.rawlog.gz"), floor_scans(3), Packing::Gz);
  write_bytes(path("drive.tum"), straight_tum(3));
  write_bytes(path("better.tum"), straight_tum(3));
  runs("drive.rawlog.gz --output a");
  EXPECT_EQ(summary("a")["poses"], "drive.tum");
  runs("drive.rawlog.gz --output a --trajectory better.tum");
  EXPECT_EQ(summary("a")["poses"], "better.tum");
}

TEST_F(TalusMap, maps_a_log_that_is_packed_with_zstd_and_copies_it_with_its_snapshots)
{
  write_log(path("plain.rawlog"), floor_scans(4), Packing::Plain);
  write_bytes(path("drive.rawlog"), zstd_of(read_bytes(path("plain.rawlog"))));
  runs("drive.rawlog --static --rawlog-out copy.rawlog");
  EXPECT_EQ(summary("drive_map")["frames"], 4);
  runs("copy.rawlog --static");
  EXPECT_EQ(summary("copy_map")["frames"], 4);
  EXPECT_EQ(read_bytes(path("copy.rawlog")).substr(0, 2), "\x1f\x8b") << "what every MRPT reads";
}

TEST_F(TalusMap, takes_poses_from_the_log_when_there_are_no_others)
{
  Objects objects;
  for (int i = 0; i < 5; ++i)
  {
    auto odometry = observation_at<mrpt::obs::CObservationOdometry>(kFirstStamp_s + 0.1 * i);
    odometry->odometry = mrpt::poses::CPose2D(0.1 * i, 0, 0);
    objects.push_back(odometry);
    objects.push_back(floor_scan(kFirstStamp_s + 0.1 * i));
  }
  write_log(path("a.rawlog"), objects, Packing::Gz);
  runs("a.rawlog");
  const auto j = summary("a_map");
  EXPECT_EQ(j["frames"], 5);
  EXPECT_SAYS(j["poses"].get<std::string>(), "CObservationOdometry");
  EXPECT_EQ(j["unsupported_observations"]["CObservationOdometry"], 5);
}

TEST_F(TalusMap, skips_and_counts_scans_in_gaps_of_the_trajectory)
{
  write_log(path("a.rawlog"), floor_scans(10), Packing::Gz);
  write_bytes(path("a.tum"), straight_tum(3) + straight_tum(3, kFirstStamp_s + 0.7));
  const CommandEnd done = runs("a.rawlog --max-gap 0.3 --output a");
  EXPECT_TRUE(done.says("4 scans were skipped")) << done.err;
  EXPECT_EQ(summary("a")["skipped_by_reason"]["no_pose"], 4);
  EXPECT_EQ(summary("a")["frames"], 6);
  runs("a.rawlog --max-gap 0.6 --output a");
  EXPECT_EQ(summary("a")["frames"], 10);
}

TEST_F(TalusMap, maps_only_the_sensor_asked_for)
{
  Objects objects = floor_scans(4);
  objects.push_back(floor_scan(kFirstStamp_s, "rear"));
  write_log(path("a.rawlog"), objects, Packing::Gz);
  const CommandEnd both = run("a.rawlog --static");
  EXPECT_EQ(summary("a_map")["sensors"]["rear"], 1);
  EXPECT_SAYS(both.out, "sensors lidar x 4, rear x 1");
  EXPECT_EQ(both.err, "") << "several sensors are nothing to warn of";
  runs("a.rawlog --static --sensor rear");
  EXPECT_EQ(summary("a_map")["frames"], 1);
  fails("a.rawlog --static --sensor front --output none", 1, {"'lidar', 'rear'"});
}

TEST_F(TalusMap, takes_frames_with_stamps_that_go_back_and_counts_them)
{
  Objects objects = floor_scans(4);
  std::swap(objects[1], objects[2]);
  write_log(path("a.rawlog"), objects, Packing::Gz);
  write_bytes(path("a.tum"), straight_tum(4));
  const CommandEnd done = runs("a.rawlog");
  EXPECT_EQ(summary("a_map")["stamps_backwards"], 1);
  EXPECT_EQ(summary("a_map")["frames"], 4);
  EXPECT_TRUE(done.says("stamps go back")) << done.err;
}

TEST_F(TalusMap, maps_different_scans_of_one_stamp_and_all_without_a_stamp)
{
  Objects objects = {floor_scan(kFirstStamp_s), floor_scan(kFirstStamp_s)};
  const auto other = floor_scan(kFirstStamp_s);
  other->pointcloud->setPoint(0, 1.0F, 1.0F, 0.0F);
  objects.push_back(other);
  for (int i = 0; i < 2; ++i)
  {
    objects.push_back(floor_scan(kFirstStamp_s, "unstamped"));
    std::dynamic_pointer_cast<mrpt::obs::CObservation>(objects.back())->timestamp =
        INVALID_TIMESTAMP;
  }
  write_log(path("a.rawlog"), objects, Packing::Gz);
  const CommandEnd done = runs("a.rawlog --static");
  EXPECT_EQ(summary("a_map")["sensors"]["lidar"], 2);
  EXPECT_EQ(summary("a_map")["sensors"]["unstamped"], 2);
  EXPECT_EQ(summary("a_map")["skipped_by_reason"]["duplicate"], 1);
  EXPECT_EQ(summary("a_map")["stamps_backwards"], 0);
  EXPECT_TRUE(done.says("duplicate")) << done.err;
}

TEST_F(TalusMap, takes_parameters_from_a_file_of_multi_maps_and_then_from_the_command_line)
{
  write_log(path("a.rawlog"), floor_scans(1), Packing::Gz);
  write_bytes(
      path("map.ini"),
      "[M_CDualElevationMap_00_creationOpts]\nresolution = 0.1 // m\nwindow = 6\nthreads = 2\n"
      "[M_CDualElevationMap_00_insertOpts]\nclearance_m = 0.9\n");
  const CommandEnd done =
      runs("a.rawlog --static --config map.ini -s window=4 --set fill_samples=4");
  EXPECT_EQ(done.err, "") << "nothing to warn of, and no progress bar in a file";
  const auto p = summary("a_map")["parameters"];
  EXPECT_EQ(p["resolution_m"], 0.1);
  EXPECT_EQ(p["window_m"], 4.0);
  EXPECT_EQ(p["clearance_m"], 0.9);
  EXPECT_EQ(p["fill_samples"], 4);
  EXPECT_EQ(summary("a_map")["threads"], 2);
}

TEST_F(TalusMap, writes_nothing_outside_of_the_folder_whatever_the_logs_of_a_batch_are_called)
{
  const std::string names = " ...rawlog ..rawlog .rawlog .hidden.rawlog hidden.rawlog unnamed_2.gz";
  std::istringstream each(names);
  for (std::string name; each >> name;) write_log(path(name), floor_scans(1), Packing::Gz);
  const std::size_t before = entries();
  const CommandEnd done = runs("--static" + names + " --output in/out --quiet");
  EXPECT_EQ(done.out + done.err, "");
  for (const char* label : {"unnamed", "unnamed_2", "rawlog", "hidden", "hidden_2", "unnamed_2_2"})
    EXPECT_EQ(summary(std::string("in/out/") + label)["frames"], 1) << label;
  EXPECT_EQ(entries(), before + 2 + 6 * 10) << "two folders, then a folder and nine files each";
  write_bytes(path("...tum"), straight_tum(1));
  runs("...rawlog");
  EXPECT_EQ(summary("unnamed_map")["poses"], "...tum");
}

TEST_F(TalusMap, answers_help_with_examples_version_and_the_list_of_parameters)
{
  const CommandEnd help = runs("--help");
  for (const char* text : {"Examples:", "--trajectory", "--static", "--max-gap", "Exit codes"})
    EXPECT_SAYS(help.out, text);
  const CommandEnd version = runs("--version");
  EXPECT_EQ(version.out.rfind("talus-map 0.1.0 (", 0), 0u) << version.out;
  EXPECT_SAYS(version.out, "backend");
  const CommandEnd list = runs("--parameters");
  EXPECT_SAYS(list.out, "clearance_m");
}
