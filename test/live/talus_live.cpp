// The command on loopback, and talus-replay as the robot.
#include <talus/io/trajectory.h>
#include <talus/live/network.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <map>
#include <memory>
#include <sys/wait.h>
#include <thread>

#include "cdr_reader.h"
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

void wait_until(const std::function<bool()>& is_so)
{
  for (int i = 0; i < 1000 && !is_so(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

void wait_for_words(const std::string& file, const std::string& words)
{
  wait_until([&] { return read_bytes(file).find(words) != std::string::npos; });
}

/** Once it hears signals. */
int end(pid_t child, int signal, const std::string& said)
{
  wait_for_words(said, "joins");
  ::kill(child, signal);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string command(const std::string& name) { return TALUS_BIN "/" + name + " "; }

/** A nav_msgs/OccupancyGrid. */
struct Cells
{
  std::uint32_t cells_x = 0, cells_y = 0;
  double min_x_m = 0, min_y_m = 0;
  std::string cells, frame;
};

Cells grid_of(std::string_view message)
{
  talus::import::CdrReader in(message);
  Cells grid;
  in.i32(), in.u32();
  grid.frame = in.string();
  in.i32(), in.u32(), in.u32();  // when, resolution
  grid.cells_x = in.u32();
  grid.cells_y = in.u32();
  grid.min_x_m = in.f64();
  grid.min_y_m = in.f64();
  for (int i = 0; i < 5; ++i) in.f64();
  grid.cells = in.bytes();
  return grid;
}

/** The same of a map that talus-export wrote for ROS: rows from the north. */
std::string cells_of_pgm(const std::string& pgm, std::uint32_t width)
{
  std::string cells;
  const std::string pixels = pgm.substr(pgm.find("255\n") + 4);
  for (auto row = pixels.size(); row >= width; row -= width)
    for (const char pixel : pixels.substr(row - width, width))
      cells += static_cast<char>(pixel == '\0' ? 100 : pixel == static_cast<char>(254) ? 0 : -1);
  return cells;
}

/** The last messages of topics of talus-live. */
class Listener
{
 public:
  explicit Listener(const std::vector<std::pair<std::string, std::string>>& topics)
      : network_(own_domain(), "talus_test")
  {
    for (const auto& [topic, type] : topics)
      heard_[topic] = std::make_unique<talus::live::Subscription>(
          network_, topic, type, talus::live::Quality{true, false, 100});
  }
  void listen()
  {
    network_.announce();
    for (auto& [topic, messages] : heard_)
      while (const auto message = messages->take()) all_[topic].emplace_back(*message);
  }
  const std::vector<std::string>& of(const std::string& topic) { return all_[topic]; }

 private:
  talus::live::Participant network_;
  std::map<std::string, std::unique_ptr<talus::live::Subscription>> heard_;
  std::map<std::string, std::vector<std::string>> all_;
};

/** Runs talus-live while a log is replayed; its exit code. */
int map_live(
    const ScratchDir& dir, const std::string& options, const std::string& replay,
    int signal = SIGTERM, const std::function<void()>& before_end = {})
{
  const pid_t live =
      start(dir / "", command("talus-live --backend cpu ") + options + " >live.txt 2>&1");
  expect_end(run_in(dir / "", command("talus-replay ") + replay), 0, {"published"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  if (before_end) before_end();
  return end(live, signal, dir / "live.txt");
}
}  // namespace

TEST(TalusLive, makes_the_map_that_talus_map_makes_of_the_same_log)
{
  Listener listener(
      {{"/talus/window", "nav_msgs/msg/OccupancyGrid"},
       {"/talus/map", "nav_msgs/msg/OccupancyGrid"},
       {"/talus/obstacles", kCloudType},
       {"/talus/path", "nav_msgs/msg/Path"},
       {"/talus/grid_map", "grid_map_msgs/msg/GridMap"},
       {"ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo"}});
  const ScratchDir dir;
  write_log(dir / "drive.rawlog", floor_scans(10), Packing::Gz);
  write_bytes(dir / "drive.tum", straight_tum(10));
  ASSERT_EQ(
      map_live(
          dir, "--record --output live --hz 100 --layers ground_elevation,traversability",
          "drive.rawlog --rate 5", SIGTERM, [&] { listener.listen(); }),
      0)
      << read_bytes(dir / "live.txt");
  for (const std::string log : {"drive.rawlog", "live/record.rawlog"})
  {
    expect_end(run_in(dir / "", command("talus-map --backend cpu --output map ") + log), 0, {});
    EXPECT_TRUE(read_bytes(dir / "live/site.tif") == read_bytes(dir / "map/site.tif")) << log;
  }
  const std::string said = read_bytes(dir / "live.txt");
  for (const char* text :
       {"hears /lidar (sensor_msgs/msg/PointCloud2, reliable)", "'base_link' in 'map' in TF",
        "10 frames of 10 scans are mapped"})
    EXPECT_NE(said.find(text), std::string::npos) << text << " not in " << said;

  for (const char* topic : {"/talus/obstacles", "/talus/path", "/talus/grid_map", "/talus/map"})
    EXPECT_FALSE(listener.of(topic).empty()) << topic;
  bool is_node = false;
  for (const auto& message : listener.of("ros_discovery_info"))
    is_node |= message.find(std::string("talus_live\0", 11)) != std::string::npos;
  EXPECT_TRUE(is_node);
  ASSERT_FALSE(listener.of("/talus/window").empty());
  const Cells window = grid_of(listener.of("/talus/window").back());
  EXPECT_EQ(window.frame, "map");
  expect_end(run_in(dir / "", command("talus-export") + "live/map.tif --to ros"), 0, {});
  EXPECT_EQ(window.cells, cells_of_pgm(read_bytes(dir / "live/map.pgm"), window.cells_x));
}

TEST(TalusLive, saves_while_it_maps_and_goes_on_with_a_map_and_with_corrected_poses)
{
  talus::live::Participant network(own_domain(), "talus_test");
  talus::live::Publication path(network, "/slam/path", "nav_msgs/msg/Path", {true, true, 1});
  std::vector<std::pair<double, mrpt::poses::CPose3D>> poses;
  for (int i = 0; i < 15; ++i)
    poses.emplace_back(kStart_s + 0.1 * i, mrpt::poses::CPose3D(0.08 * i, 0, 0, 0, 0, 0));
  const ScratchDir dir;
  const auto correct = [&]
  {
    path.write(talus::live::path_message({kStart_s, "map"}, poses));
    wait_for_words(dir / "live.txt", "their poses have moved by");
  };
  write_log(dir / "drive.rawlog", floor_scans(15), Packing::Gz);
  write_bytes(dir / "drive.tum", straight_tum(15));
  EXPECT_EQ(
      map_live(dir, "--save-every 0.003 --output old", "drive.rawlog --rate 2", SIGKILL), -SIGKILL);
  ASSERT_TRUE(std::filesystem::exists(dir / "old/site.tif"));
  ASSERT_EQ(
      map_live(
          dir, "--resume old/site.tif --record --corrected-path /slam/path --output live",
          "drive.rawlog --odometry --best-effort", SIGINT, correct),
      0);
  const std::string said = read_bytes(dir / "live.txt");
  EXPECT_NE(said.find("poses are those of topic /odom"), std::string::npos) << said;
  EXPECT_NE(said.find("best effort"), std::string::npos) << said;
  EXPECT_NE(said.find("15 corrected poses of /slam/path"), std::string::npos) << said;
  const std::string again = "--backend cpu --resume old/site.tif --output map live/record.rawlog";
  expect_end(run_in(dir / "", command("talus-map") + again), 0, {});
  EXPECT_TRUE(read_bytes(dir / "live/site.tif") == read_bytes(dir / "map/site.tif"));
}

TEST(TalusLive, makes_the_map_again_when_map_to_odom_jumps_and_when_a_path_is_corrected)
{
  own_domain();
  const ScratchDir dir;
  write_log(dir / "drive.rawlog", floor_scans(40), Packing::Gz);
  write_bytes(dir / "drive.tum", straight_tum(40));
  std::string odometry;  // which is 0.1 m short after each metre
  for (int i = 0; i < 40; ++i)
    odometry +=
        talus::io::tum_line({kStart_s + 0.1 * i, mrpt::poses::CPose3D(0.09 * i, 0, 0, 0, 0, 0)});
  write_bytes(dir / "odometry.tum", odometry);
  for (const std::string path : {"", "--corrected-path /slam/path "})
  {
    ASSERT_EQ(
        map_live(
            dir, "--record --output live " + path,
            "drive.rawlog --trajectory odometry.tum --slam drive.tum --slam-every 2", SIGTERM,
            [&] { wait_for_words(dir / "live.txt", "their poses have moved by"); }),
        0);
    const std::string said = read_bytes(dir / "live.txt");
    EXPECT_NE(
        said.find(path.empty() ? "map -> odom has jumped by 0.2" : "poses of /slam/path"),
        std::string::npos)
        << said;
    EXPECT_EQ(said.find("left out"), std::string::npos) << said;
    expect_end(
        run_in(dir / "", command("talus-map --backend cpu --output map live/record.rawlog")), 0,
        {});
    EXPECT_TRUE(read_bytes(dir / "live/site.tif") == read_bytes(dir / "map/site.tif")) << path;
  }
}

TEST(TalusLive, hears_the_dds_of_another_vendor)
{
#ifdef TALUS_FASTDDS_TALKER
  own_domain();
  const ScratchDir dir;
  const pid_t live =
      start(dir / "", command("talus-live --backend cpu --output live >live.txt 2>&1"));
  expect_end(run_in(dir / "", TALUS_FASTDDS_TALKER), 0, {"published"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(end(live, SIGTERM, dir / "live.txt"), 0);
  const std::string said = read_bytes(dir / "live.txt");
  EXPECT_NE(said.find("9 frames of 9 scans are mapped"), std::string::npos) << said;
#else
  GTEST_SKIP() << "there is no libfastrtps-dev";
#endif
}

TEST(TalusLive, maps_one_of_several_robots_whatever_becomes_of_its_topics_and_of_the_folder)
{
  namespace live = talus::live;
  const int domain = own_domain();
  const ScratchDir dir;
  const pid_t child =
      start(dir / "", command("talus-live --backend cpu --output live >live.txt 2>&1"));
  live::Participant network(domain, "robots");
  std::map<std::string, std::unique_ptr<live::Publication>> topics;
  const auto publish = [&](const std::string& topic, const char* type, bool is_reliable)
  {
    topics[topic].reset();
    topics[topic] = std::make_unique<live::Publication>(
        network, topic, type, live::Quality{is_reliable, false, 10});
  };
  for (const std::string robot : {"/robot1", "/robot2"})
  {
    publish(robot + "/tf", kTfType, true);
    publish(robot + "/points", kCloudType, true);
  }
  const auto drive_until = [&](const std::string& words, int more)
  {
    for (static int i = 0; more > 0 && i < 1000; ++i)
    {
      const double t = 0.02 * i;
      more -= read_bytes(dir / "live.txt").find(words) == std::string::npos ? 0 : 1;
      for (const std::string robot : {"/robot1", "/robot2"})
      {
        topics[robot + "/tf"]->write(tf(t, "map", "base_link", robot == "/robot1" ? t : 50));
        topics[robot + "/points"]->write(floor_cloud(t, "base_link"));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  };
  drive_until("hears /robot1/points (sensor_msgs/msg/PointCloud2, reliable)", 20);
  publish("/robot1/points", kCloudType, false);
  drive_until("hears /robot1/points (sensor_msgs/msg/PointCloud2, best effort)", 20);
  std::filesystem::remove_all(dir / "live");  // by mistake
  EXPECT_EQ(end(child, SIGTERM, dir / "live.txt"), 0);
  const std::string said = read_bytes(dir / "live.txt");
  EXPECT_TRUE(std::filesystem::exists(dir / "live/site.tif")) << said;
  for (const char* words : {"/robot2/tf is left out", "/robot2/points is left out", "best effort"})
    EXPECT_NE(said.find(words), std::string::npos) << said;
}

TEST(TalusLive, writes_nothing_where_nobody_publishes)
{
  own_domain();
  const ScratchDir dir;
  const pid_t live = start(dir / "", command("talus-live --backend cpu >live.txt 2>&1"));
  EXPECT_EQ(end(live, SIGTERM, dir / "live.txt"), 1);
  EXPECT_NE(read_bytes(dir / "live.txt").find("ROS_DOMAIN_ID"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(dir / "live_map"));
}
