// The programs of apps/examples: each prints what it says.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>

#include "log_files.h"

namespace
{
class Examples : public testing::Test
{
 protected:
  /** What an example prints, run in the scratch folder. */
  std::string run(const std::string& name, const std::string& arguments = "")
  {
    const std::string line = "cd '" + (dir / "") +
                             "' && timeout 100 " TALUS_EXAMPLES_DIR "/example_" + name + " " +
                             arguments + " >out.txt 2>err.txt";
    const int status = std::system(line.c_str());
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
        << name << "\n"
        << talus::test::read_bytes(dir / "err.txt");
    return talus::test::read_bytes(dir / "out.txt");
  }
  talus::test::ScratchDir dir;
};
}  // namespace

TEST_F(Examples, a_map_of_a_cloud_knows_ground_block_and_what_it_has_not_seen)
{
  EXPECT_EQ(
      run("01_map_of_a_cloud"),
      "x =  1.0 m: ground 0.00 m, top 0.00 m, traversability 1.0\n"
      "x =  1.8 m: ground 0.00 m, top 0.40 m, traversability 0.0\n"
      "x = 50.0 m: ground nan m, top nan m, traversability nan\n");
}

TEST_F(Examples, a_live_map_is_read_by_the_thread_of_a_planner)
{
  EXPECT_EQ(run("02_live_map"), "after frame 20:\n  on the road  1.0\n  at the block 0.0\n");
}

TEST_F(Examples, a_multi_metric_map_holds_the_terrain_and_gives_a_costmap)
{
  EXPECT_EQ(
      run("03_multi_metric_map"),
      "2 maps\n"
      "costmap 120 x 120 cells\n"
      "free at (2.75, -1.0): 0.94\n"
      "free at (2.75,  0.5): 0.05\n");
}

TEST_F(Examples, obstacles_for_a_reactive_navigator_are_in_the_frame_of_the_robot)
{
  EXPECT_EQ(
      run("04_reactive_obstacles"),
      "some obstacles\nnearest 1.9 m away, 1.9 m ahead, 0.3 m to the left\n");
}

TEST_F(Examples, a_whole_drive_is_asked_far_back_and_written)
{
  EXPECT_EQ(
      run("05_whole_drive", "site.tif"),
      "27.2 m back: window nan, whole drive 0.0\n"
      "26.0 m back: window nan, whole drive 1.0\n");
  for (const char* name : {"site.tif", "site.png"})
    EXPECT_GT(talus::test::read_bytes(dir / name).size(), 2000U) << name;
}

#ifdef TALUS_EXAMPLES_DRIVE
TEST_F(Examples, a_robot_drives_around_a_block_and_tells_how_far_it_is)
{
  const std::string text =
      run("06_my_robot", "'" TALUS_SOURCE_DIR "/datasets/configs/reactive2d_config.ini'");
  EXPECT_EQ(text.rfind(" 0 s: 5.9 m to the goal\n 5 s: ", 0), 0U) << text;
  EXPECT_NE(text.find("arrived; drove by on the right side of the block: yes\n"), text.npos)
      << text;
}
#endif

#ifdef TALUS_EXAMPLES_LOCALIZE
TEST_F(Examples, scans_of_one_drive_are_laid_onto_the_map_of_another)
{
  const std::string world = " '" TALUS_SOURCE_DIR "/datasets/worlds/demo.yaml' --quiet --output ";
  const std::string commands = "cd '" + (dir / "") + "' && " TALUS_BIN "/talus-sim" + world +
                               "monday && " TALUS_BIN
                               "/talus-map monday/demo.rawlog --quiet --output map && " +
                               TALUS_BIN "/talus-sim" + world + "friday --seed 21";
  ASSERT_EQ(std::system(commands.c_str()), 0);
  std::istringstream lines(run("07_localize", "map/site.tif friday/demo.rawlog friday/demo.tum"));
  int scans = 0, near = 0, number = 0;
  double off_m = 0, off_deg = 0;
  for (std::string line; std::getline(lines, line); ++scans)
  {
    ASSERT_EQ(
        std::sscanf(line.c_str(), "scan %d: %lf m and %lf degrees off", &number, &off_m, &off_deg),
        3)
        << line;
    EXPECT_LT(off_m, 0.1) << line;
    EXPECT_LE(off_deg, 0.5) << line;
    if (off_m <= 0.05) ++near;
  }
  EXPECT_EQ(scans, 7);
  EXPECT_GE(near, 5) << "of seven that began 0.3 m and 5 degrees off";
}
#endif
