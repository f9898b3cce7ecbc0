// The command talus-sim from end to end: its files, messages and exit codes.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <sys/wait.h>
#include <talus/io/geotiff.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

namespace
{
struct Outcome
{
  int code = 0;
  std::string text;
};

class TalusSim : public testing::Test
{
 protected:
  void SetUp() override
  {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "small.yaml")
        << "seed: 4\n"
           "ground: [plane: {slope_x_deg: 5}]\n"
           "objects: [box: {at_m: [3, 1], size_m: [0.5, 0.5, 0.5]}]\n"
           "robot: {path_m: [[0, 0], [1, 0]]}\n"
           "sensor: {at_m: [0.1, 0, 0.7]}\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Outcome run(const std::string& arguments) const
  {
    const std::string log = path("log.txt");
    const int status =
        std::system((std::string(TALUS_SIM_EXE) + " " + arguments + " >" + log + " 2>&1").c_str());
    std::ostringstream text;
    text << std::ifstream(log).rdbuf();
    return {WEXITSTATUS(status), text.str()};
  }

  static std::string bytes(const std::string& file)
  {
    std::ostringstream out;
    out << std::ifstream(file, std::ios::binary).rdbuf();
    return out.str();
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("talus_sim_test_" + std::to_string(getpid()));
};
}  // namespace

TEST_F(TalusSim, writes_a_log_a_trajectory_and_the_truth_that_agree)
{
  const Outcome done = run(path("small.yaml") + " --output " + path("out") + " --frames 5");
  ASSERT_EQ(done.code, 0) << done.text;
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
  std::ofstream(folder_ / "two.yaml")
      << "ground: [plane: {}]\n"
         "robot: {path_m: [[0, 0], [1, 0]]}\n"
         "sensors: [{name: front, at_m: [0.5, 0, 0.7]}, {name: rear, at_m: [-0.5, 0, 0.9]}]\n"
         "poses: {jumps: [{time_s: 0.5, z_m: 0.3}]}\n";
  const Outcome done =
      run(path("two.yaml") + " --output " + path("out") + " --every 5 --cut-frames 3");
  ASSERT_EQ(done.code, 0) << done.text;
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
  const Outcome done = run(path("...yaml") + " --output " + path("out") + " --frames 1");
  ASSERT_EQ(done.code, 0) << done.text;
  EXPECT_TRUE(fs::exists(path("out/unnamed.rawlog")));
  EXPECT_TRUE(fs::exists(path("out/unnamed.tum")));
}

TEST_F(TalusSim, writes_the_same_bytes_again_for_the_same_seed)
{
  const std::string common = path("small.yaml") + " --quiet --frames 3 --pose-noise 0.02 --output ";
  ASSERT_EQ(run(common + path("a")).code, 0);
  ASSERT_EQ(run(common + path("b")).code, 0);
  ASSERT_EQ(run(common + path("c") + " --seed 5").code, 0);
  for (const char* file : {"small.rawlog", "small.tum", "small_noisy.tum"})
    EXPECT_TRUE(bytes(path("a/") + file) == bytes(path("b/") + file)) << file;
  EXPECT_FALSE(bytes(path("a/small.rawlog")) == bytes(path("c/small.rawlog")));
  EXPECT_FALSE(bytes(path("a/small.tum")) == bytes(path("a/small_noisy.tum")));
}

TEST_F(TalusSim, says_what_is_wrong_and_leaves_nothing_behind)
{
  std::ofstream(path("bad.yaml")) << "ground: [plane: {z_m: 0}]\nrobot: {pat_m: [[0, 0]]}\n";
  const Outcome bad = run(path("bad.yaml") + " --output " + path("out"));
  EXPECT_EQ(bad.code, 1);
  EXPECT_NE(bad.text.find("bad.yaml:2: robot: unknown key 'pat_m'"), std::string::npos) << bad.text;
  EXPECT_FALSE(fs::exists(path("out")));
  EXPECT_EQ(run(path("none.yaml") + " --output " + path("out")).code, 1);
  EXPECT_EQ(run(path("small.yaml") + " --output " + path("small.yaml")).code, 1);
  const Outcome scanner =
      run(path("small.yaml") + " --output " + path("out") + " --scanner HAL-9000");
  EXPECT_EQ(scanner.code, 1);
  EXPECT_NE(scanner.text.find("known: RS-LiDAR-16"), std::string::npos) << scanner.text;
  const Outcome fine = run(path("small.yaml") + " --output " + path("out") + " --resolution 0.001");
  EXPECT_EQ(fine.code, 1);
  EXPECT_NE(fine.text.find("GB"), std::string::npos) << fine.text;
  EXPECT_NE(fine.text.find("small.yaml: "), std::string::npos) << fine.text;
  EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(TalusSim, refuses_what_is_no_number_in_range)
{
  const std::string common = path("small.yaml") + " --frames 1 --output " + path("out") + " ";
  for (const char* wrong :
       {"--noise nan", "--noise-per-m nan", "--pose-noise nan", "--angle-noise nan",
        "--z-drift nan", "--clock-error nan", "--resolution nan", "--resolution inf",
        "--mounting-error nan,0,0,0,0,0", "--seed -1", "--seed 99999999999999999999999"})
  {
    const Outcome o = run(common + wrong);
    EXPECT_EQ(o.code, 2) << wrong << ": " << o.text;
    const std::string option = std::string(wrong).substr(0, std::string(wrong).find(' '));
    EXPECT_NE(o.text.find(option + ":"), std::string::npos) << o.text;
  }
  EXPECT_FALSE(fs::exists(path("out")));
  EXPECT_EQ(
      run(common + "--seed 18446744073709551615 --mounting-error -100,0,100,0,0,360").code, 0);
}

TEST_F(TalusSim, does_not_write_over_its_world)
{
  for (const char* name : {"w.rawlog", "w.tum", "truth.tif"})
  {
    fs::copy_file(path("small.yaml"), path(name));
    const Outcome o = run(path(name) + " --frames 1 --output " + path(""));
    EXPECT_EQ(o.code, 1) << name;
    EXPECT_NE(o.text.find("is an input"), std::string::npos) << o.text;
    EXPECT_TRUE(bytes(path(name)) == bytes(path("small.yaml"))) << name;
    fs::remove(path(name));
  }
}

TEST_F(TalusSim, that_is_stopped_leaves_nothing_behind)
{
  std::ofstream(path("long.yaml")) << "ground: [plane: {}]\n"
                                      "robot: {path_m: [[0, 0]], duration_s: 9000}\n";
  fs::create_directories(path("out"));
  // Stopped once its log, the last of the files in the hidden folder, is there.
  const int status = std::system(
      ("cd " + path("out") + "; " + TALUS_SIM_EXE + " ../long.yaml --output . >../log.txt 2>&1 & " +
       "p=$!; for i in $(seq 600); do ls -AR | grep -q rawlog && break; sleep 0.05; done; " +
       "kill -TERM $p; wait $p")
          .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM);
  EXPECT_NE(bytes(path("log.txt")).find("nothing was written"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(path("out")));
}

TEST_F(TalusSim, leaves_the_old_files_when_the_last_bytes_of_a_log_do_not_fit)
{
  const std::string call =
      path("small.yaml") + " --frames 3 --resolution 0.5 --output " + path("out");
  ASSERT_EQ(run(call).code, 0);
  const std::string old = bytes(path("out/small.rawlog"));
  const std::size_t blocks = (old.size() - 1) / 512;  // of the limit of sh, one fewer than needed
  const int status =
      std::system(("trap '' XFSZ; ulimit -f " + std::to_string(blocks) + "; " + TALUS_SIM_EXE +
                   " " + call + " --seed 4 >" + path("log.txt") + " 2>&1")
                      .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  const std::string text = bytes(path("log.txt"));
  EXPECT_NE(text.find(path("out/small.rawlog") + ": could not be written"), std::string::npos)
      << text;
  EXPECT_TRUE(bytes(path("out/small.rawlog")) == old);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), {}), 3) << "hidden files are left";
  // The first of its files, by the name that the user knows.
  const std::string no_room = "(ulimit -f 0; " TALUS_SIM_EXE " " + call + " 2>&1) | cat >";
  EXPECT_EQ(std::system((no_room + path("log.txt")).c_str()), 0);
  EXPECT_NE(bytes(path("log.txt")).find(path("out/truth.tif") + ": "), std::string::npos)
      << bytes(path("log.txt"));
}

TEST_F(TalusSim, names_the_folder_that_cannot_be_made)
{
  const std::string too_long(300, 'x');
  const Outcome o = run(path("small.yaml") + " --output " + path(too_long));
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.text.find("--output"), std::string::npos) << o.text;
}

TEST_F(TalusSim, answers_help_version_and_wrong_usage)
{
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_NE(run("--help").text.find("OS1-64"), std::string::npos);
  EXPECT_EQ(run("--version").code, 0);
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run(path("small.yaml") + " --output " + path("out") + " --frames none").code, 2);
}
