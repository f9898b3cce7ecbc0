// The command on loopback, and talus-replay as the robot.
#include <chrono>
#include <csignal>
#include <sys/wait.h>
#include <thread>

#include "command_run.h"
#include "robot.h"
#include "talus_map_run.h"

using namespace talus::test;

namespace
{
/** Starts a command line in the background. */
pid_t start(const std::string& folder, const std::string& command)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    const std::string line = "cd '" + folder + "' && exec " + command;
    ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    ::_exit(127);
  }
  return child;
}

int end(pid_t child, int signal)
{
  ::kill(child, signal);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string command(const std::string& name) { return TALUS_BIN "/" + name + " "; }

/** Runs talus-live while a log is replayed; its exit code. */
int map_live(
    const ScratchDir& dir, const std::string& options, const std::string& replay,
    int signal = SIGTERM)
{
  const pid_t live =
      start(dir / "", command("talus-live --backend cpu ") + options + " >live.txt 2>&1");
  expect_end(run_in(dir / "", command("talus-replay ") + replay), 0, {"published"});
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return end(live, signal);
}
}  // namespace

TEST(TalusLive, makes_the_map_that_talus_map_makes_of_the_same_log)
{
  own_domain();
  const ScratchDir dir;
  write_log(dir / "drive.rawlog", floor_scans(10), Packing::Gz);
  write_bytes(dir / "drive.tum", straight_tum(10));
  ASSERT_EQ(map_live(dir, "--record --output live", "drive.rawlog --rate 5"), 0)
      << read_bytes(dir / "live.txt");
  for (const std::string log : {"drive.rawlog", "live/record.rawlog"})
  {
    expect_end(run_in(dir / "", command("talus-map --backend cpu --output map ") + log), 0, {});
    EXPECT_EQ(read_bytes(dir / "live/site.tif"), read_bytes(dir / "map/site.tif")) << log;
  }
  const std::string said = read_bytes(dir / "live.txt");
  for (const char* text :
       {"hears /lidar (sensor_msgs/msg/PointCloud2, reliable)", "'base_link' in 'map' in TF",
        "10 frames of 10 scans are mapped"})
    EXPECT_NE(said.find(text), std::string::npos) << text << " not in " << said;
}

TEST(TalusLive, takes_odometry_and_ends_by_an_interrupt)
{
  own_domain();
  const ScratchDir dir;
  write_log(dir / "drive.rawlog", floor_scans(15), Packing::Gz);
  write_bytes(dir / "drive.tum", straight_tum(15));
  EXPECT_EQ(map_live(dir, "--output live", "drive.rawlog --odometry --best-effort", SIGINT), 0);
  const std::string said = read_bytes(dir / "live.txt");
  EXPECT_NE(said.find("poses are those of topic /odom"), std::string::npos) << said;
  EXPECT_NE(said.find("best effort"), std::string::npos) << said;
}

TEST(TalusLive, writes_nothing_where_nobody_publishes)
{
  own_domain();
  const ScratchDir dir;
  const pid_t live = start(dir / "", command("talus-live --backend cpu >live.txt 2>&1"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(end(live, SIGTERM), 1);
  EXPECT_NE(read_bytes(dir / "live.txt").find("ROS_DOMAIN_ID"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(dir / "live_map"));
}
