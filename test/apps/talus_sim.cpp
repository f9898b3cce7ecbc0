// The command talus-sim from end to end: its files, messages and exit codes.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/io/geotiff.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <cmath>

#include <filesystem>

#include "command_run.h"

namespace fs = std::filesystem;
using talus::test::CommandEnd;

namespace
{
class TalusSim : public talus::test::CommandTest
{
 protected:
  TalusSim() : CommandTest(TALUS_SIM_EXE)
  {
    write(
        "small.yaml",
        "seed: 4\n"
        "ground: [plane: {slope_x_deg: 5}]\n"
        "objects: [box: {at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}]\n"
        "robot: {path_m: [[0, 0], [1, 0]]}\n"
        "sensor: {at_m: [0.1, 0, 0.7]}\n");
  }
};
}  // namespace

TEST_F(TalusSim, writes_a_log_a_trajectory_and_the_truth_that_agree)
{
  runs("small.yaml --output out --frames 5");
  const auto way = talus::io::Trajectory::load(path("out/small.tum"));
  EXPECT_EQ(way.entries().size(), 5u);
  const auto truth = talus::io::read_geotiff(path("out/truth.tif"));
  ASSERT_NE(truth.find("ground"), nullptr);
  ASSERT_NE(truth.find("obstacle_top"), nullptr);
  ASSERT_NE(truth.find("underside"), nullptr);
  ASSERT_NE(truth.find("label"), nullptr);
  ASSERT_NE(truth.find("covered"), nullptr);
  ASSERT_NE(truth.find("solid"), nullptr);

  talus::io::RawlogReader log(path("out/small.rawlog"));
  int frames = 0;
  double worst_m = 0;
  while (const auto obs = log.next())
  {
    const auto cloud = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(obs);
    ASSERT_TRUE(cloud);
    EXPECT_EQ(cloud->sensorLabel, "lidar");
    ASSERT_TRUE(talus::detail::is_cloud_with_intensity(*cloud->pointcloud));
    const auto pose = way.at(mrpt::Clock::toDouble(cloud->timestamp), 0.0);
    ASSERT_TRUE(pose) << "a pose at the very stamp of each frame";
    const auto T = *pose + cloud->sensorPose;
    for (std::size_t i = 0; i < cloud->pointcloud->size(); ++i)
    {
      mrpt::math::TPoint3D p;
      cloud->pointcloud->getPoint(i, p);
      const auto q = T.composePoint(p);
      const int ix = static_cast<int>(std::floor((q.x - truth.min_x_m) / truth.resolution_m));
      const int iy = static_cast<int>(std::floor((q.y - truth.min_y_m) / truth.resolution_m));
      if (ix < 0 || iy < 0 || ix >= truth.cells_x || iy >= truth.cells_y) continue;
      const float ground = (*truth.find("ground"))[iy * truth.cells_x + ix];
      if (q.x < 2.6) worst_m = std::max(worst_m, std::abs(q.z - ground));
    }
    ++frames;
  }
  EXPECT_EQ(frames, 5);
  // Beams at 15 degrees or less: range noise of 15 mm moves a point 4 mm; half a cell of the 5
  // degree slope is 2 mm; six standard deviations of both.
  EXPECT_LT(worst_m, 0.03);
}

TEST_F(TalusSim, writes_scans_of_several_sensors_in_pieces_each_with_its_label_stamp_and_mounting)
{
  write(
      "two.yaml",
      "ground: [plane: {}]\n"
      "robot: {path_m: [[0, 0], [1, 0]]}\n"
      "sensors: [{name: front, at_m: [0.5, 0, 0.7]}, {name: rear, at_m: [-0.5, 0, 0.9]}]\n"
      "poses: {jumps: [{time_s: 0.5, z_m: 0.3}]}\n");
  runs("two.yaml --output out --every 5 --cut-frames 3");
  const auto way = talus::io::Trajectory::load(path("out/two.tum"));
  EXPECT_EQ(way.entries().size(), 9u) << "three sweeps in three pieces, of both at the same stamps";
  EXPECT_EQ(talus::io::Trajectory::load(path("out/two_noisy.tum")).entries().size(), 9u);
  talus::io::RawlogReader log(path("out/two.rawlog"));
  int frames = 0;
  while (const auto obs = log.next())
  {
    const bool front = frames % 2 == 0;
    EXPECT_EQ(obs->sensorLabel, front ? "front" : "rear");
    mrpt::poses::CPose3D mounting;
    obs->getSensorPose(mounting);
    EXPECT_NEAR(mounting.x(), front ? 0.5 : -0.5, 1e-9);
    EXPECT_TRUE(way.at(mrpt::Clock::toDouble(obs->timestamp), 0.0)) << "at its very stamp";
    ++frames;
  }
  EXPECT_EQ(frames, 18);
}

TEST_F(TalusSim, hides_no_file_of_a_world_whose_name_begins_with_dots)
{
  fs::copy_file(path("small.yaml"), path("...yaml"));
  runs("...yaml --output out --frames 1");
  EXPECT_TRUE(fs::exists(path("out/unnamed.rawlog")));
  EXPECT_TRUE(fs::exists(path("out/unnamed.tum")));
}

TEST_F(TalusSim, says_what_is_wrong_and_leaves_nothing_behind)
{
  write("bad.yaml", "ground: [plane: {z_m: 0}]\nrobot: {pat_m: [[0, 0]]}\n");
  fails("bad.yaml --output out", 1, {"bad.yaml:2: robot: unknown key 'pat_m'"});
  fails("none.yaml --output out", 1, {"none.yaml"});
  fails("small.yaml --output small.yaml", 1, {"small.yaml"});
  fails("small.yaml --output out --scanner HAL-9000", 1, {"known: RS-LiDAR-16"});
  fails("small.yaml --output out --resolution 0.001", 1, {"small.yaml: ", "GB"});
  fails("small.yaml --output " + std::string(300, 'x'), 1, {"--output"});
  fails("", 2, {});
  fails("small.yaml --output out --frames none", 2, {});
  for (const std::string wrong :
       {"--noise nan", "--noise-per-m nan", "--pose-noise nan", "--angle-noise nan",
        "--z-drift nan", "--clock-error nan", "--resolution nan", "--resolution inf",
        "--mounting-error nan,0,0,0,0,0", "--seed -1", "--seed 99999999999999999999999"})
    fails("small.yaml --output out " + wrong, 2, {wrong.substr(0, wrong.find(' ')) + ":"});
  EXPECT_FALSE(exists("out"));
  fails(
      "small.yaml --frames 1 --output out --seed 18446744073709551615 "
      "--mounting-error -100,0,100,0,0,360",
      0, {});
  fails("--help", 0, {"OS1-64"});
  fails("--version", 0, {});
}

TEST_F(TalusSim, does_not_write_over_its_world)
{
  for (const std::string name : {"w.rawlog", "w.tum", "truth.tif"})
  {
    fs::copy_file(path("small.yaml"), path(name));
    fails(name + " --frames 1 --output .", 1, {"is an input"});
    EXPECT_TRUE(text(name) == text("small.yaml")) << name;
    fs::remove(path(name));
  }
}

TEST_F(TalusSim, leaves_the_old_files_when_the_last_bytes_of_a_log_do_not_fit)
{
  const std::string call = "small.yaml --frames 3 --resolution 0.5 --output out";
  runs(call);
  const std::string old = text("out/small.rawlog");
  const std::size_t blocks = (old.size() - 1) / 512;  // of the limit of sh, one fewer than needed
  const CommandEnd full =
      run(call + " --seed 4", "trap '' XFSZ; ulimit -f " + std::to_string(blocks) + ";");
  talus::test::expect_end(full, 1, {"out/small.rawlog: could not be written"});
  EXPECT_TRUE(text("out/small.rawlog") == old);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), {}), 3) << "hidden files are left";
  // The first of its files, by the name that the user knows.
  shell("(ulimit -f 0; " TALUS_SIM_EXE " " + call + " 2>&1) | cat >none.txt");
  EXPECT_SAYS(text("none.txt"), "out/truth.tif: ");
}
