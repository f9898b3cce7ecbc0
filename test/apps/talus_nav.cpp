// The command talus-nav, as a person runs it. Runs of many seeds are not tests: they take minutes.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/nav/reactive/CLogFileRecord.h>
#include <sys/stat.h>
#include <talus/io/palette.h>
#include <talus/io/rawlog_reader.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "apps/lab/talus-nav/planner_ini.h"
#include "command_run.h"
#include "message_of.h"

namespace
{
using talus::test::read_bytes;

struct Row
{
  double time_s, x_m, y_m, z_m;
};

class TalusNav : public talus::test::CommandTest
{
 protected:
  /** What it says goes into out.txt and err.txt. */
  int run(const std::string& arguments, const std::string& before = "") const
  {
    const auto unless_given = [&](const std::string& option, const std::string& value)
    { return arguments.find(option) == std::string::npos ? " " + option + " " + value : ""; };
    const bool drives = arguments.find("--goal") != std::string::npos;
    return shell(
               before + " '" TALUS_NAV_EXE "' " + arguments + unless_given("--backend", "cpu") +
               (drives ? unless_given("--every", "0") : "") + " >out.txt 2>err.txt")
        .code;
  }
  int drive(const std::string& world, const std::string& arguments) const
  {
    return run(TALUS_SOURCE_DIR "/datasets/worlds/" + world + " " + arguments);
  }
  /** Drives in a world that is written down here, in a file of this name. */
  int drive_in(
      const std::string& name, const std::string& world, const std::string& arguments) const
  {
    write(name, world);
    return run(name + " " + arguments);
  }
  /** The command must refuse that, say the words, and leave no results. */
  void refuses(int code, int end, const std::vector<std::string>& words) const
  {
    EXPECT_EQ(end, code) << text("err.txt");
    for (const auto& word : words) EXPECT_SAYS(text("err.txt"), word);
    EXPECT_FALSE(exists("out"));
  }
  nlohmann::json summary(const std::string& folder) const { return json(folder + "/summary.json"); }
  std::vector<Row> driven(const std::string& folder) const
  {
    std::istringstream in(text(folder + "/path.csv"));
    std::string line;
    std::getline(in, line);
    std::vector<Row> rows;
    while (std::getline(in, line))
    {
      Row r{};
      if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &r.time_s, &r.x_m, &r.y_m, &r.z_m) == 4)
        rows.push_back(r);
    }
    return rows;
  }
};
}  // namespace

TEST_F(TalusNav, drives_over_the_ramp_and_the_low_boxes_of_the_indoor_world)
{
  ASSERT_EQ(drive("nav_indoor.yaml", "--goal 12.5,0 --scanner OS0-128 --output out"), 0)
      << text("err.txt");
  EXPECT_EQ(summary("out")["ending"], "arrived");
  const auto rows = driven("out");
  const auto height = [&](double x0, double x1)
  {
    double top = 0;
    for (const Row& r : rows)
      if (r.x_m > x0 && r.x_m < x1) top = std::max(top, r.z_m);
    return top;
  };
  EXPECT_NEAR(height(7, 9), 0.375, 0.03) << "over the ramp";
  EXPECT_GT(height(10, 12), 0.03) << "over a box of 6.5 cm";
  EXPECT_LE(std::hypot(rows.back().x_m - 12.5, rows.back().y_m), 0.5);
  char when[40];  // the report and the summary mean the same moment
  std::snprintf(
      when, sizeof when, "after %.1f s and %.1f m", summary("out")["time_s"].get<double>(),
      summary("out")["driven_m"].get<double>());
  EXPECT_SAYS(text("out.txt"), when);
}

TEST_F(TalusNav, drives_under_the_branches_with_the_planner_in_3d)
{
  ASSERT_EQ(drive("nav_woods.yaml", "--goal 6,0 --planner 3d --output out"), 0) << text("err.txt");
  const auto rows = driven("out");
  // The foliage hangs from y = -1.8 to 0.6 at x = 3.1: the way leads below it.
  const auto below = std::any_of(
      rows.begin(), rows.end(),
      [](const Row& r) { return std::abs(r.x_m - 3.1) < 0.2 && r.y_m > -1.8 && r.y_m < 0.6; });
  EXPECT_TRUE(below);
}

TEST_F(TalusNav, says_blocked_where_there_is_no_way_and_writes_everything)
{
  ASSERT_EQ(drive("nav_blocked.yaml", "--goal 7,0 --output out --every 10"), 3) << text("err.txt");
  EXPECT_EQ(summary("out")["ending"], "blocked");
  for (const char* name : {"navigation.png", "path.csv", "frames/frame_000001.png"})
    EXPECT_TRUE(exists(std::string("out/") + name)) << name;
  EXPECT_FALSE(exists("out/cache"));
  EXPECT_SAYS(text("out.txt"), "found no way to the goal");
}

TEST_F(TalusNav, gives_the_same_path_with_the_same_seed)
{
  const std::string arguments = "--goal 15,0 --timeout 3.2 --quiet --backend auto";
  EXPECT_EQ(drive("nav_indoor.yaml", arguments + " --output a --seed 5"), 5);
  EXPECT_EQ(text("out.txt") + text("err.txt"), "");
  EXPECT_EQ(drive("nav_indoor.yaml", arguments + " --output b --seed 5"), 5);
  EXPECT_EQ(drive("nav_indoor.yaml", arguments + " --output c --seed 6"), 5);
  const auto a = driven("a"), b = driven("b"), c = driven("c");
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 30U);
  EXPECT_EQ(a.back().x_m, b.back().x_m);
  EXPECT_EQ(a.back().y_m, b.back().y_m);
  EXPECT_NE(a.back().y_m, c.back().y_m);
}

TEST_F(TalusNav, writes_a_log_that_navlog_viewer_reads_and_shows_the_obstacles_it_was_given)
{
  EXPECT_EQ(drive("nav_indoor.yaml", "--goal 15,0 --timeout 2 --output out --backend auto"), 5);
  EXPECT_SAYS_NOT(text("err.txt"), "backend: cpu");
  talus::io::RawlogStream file(path("out/log.reactivenavlog"));
  mrpt::nav::CLogFileRecord::Ptr record;
  for (int i = 0; i < 15; i++)
  {
    record = std::dynamic_pointer_cast<mrpt::nav::CLogFileRecord>(file.next());
    ASSERT_TRUE(record) << i;
  }
  EXPECT_GT(record->WS_Obstacles.size(), 50U);
  EXPECT_EQ(record->nPTGs, 2U);
  const cv::Mat picture = cv::imread(path("out/navigation.png"));
  const auto& rgb = talus::io::palette::kGiven.rgb;
  const cv::Vec3b colour(rgb[2], rgb[1], rgb[0]);
  const auto pixels = std::count(picture.begin<cv::Vec3b>(), picture.end<cv::Vec3b>(), colour);
  EXPECT_GT(pixels, 500) << "the legend alone has some ten";
}

TEST_F(TalusNav, arrives_at_goals_that_are_near)
{
  // The robot looks 27 degrees past them, so that the first arcs of the navigator do not lead
  // there.
  const std::string world =
      "ground: [plane: {z_m: 0}]\nrobot: {path_m: [[0, 0], [1, 0.5]]}\n"
      "sensor: {scanner: OS0-128, at_m: [0, 0, 0.68]}\n";
  write("near.yaml", world);
  for (const std::string mission :
       {"0.05,0 --planner 2d", "0.5,0 --planner 2d", "0.5,0 --planner 3d", "0,0.5 --planner 2d"})
    EXPECT_EQ(run("near.yaml --output out --timeout 30 --goal " + mission), 0) << mission << "\n"
                                                                               << text("err.txt");
}

TEST_F(TalusNav, tells_a_fall_from_a_hit)
{
  // What a sensor without returns does not see is in no map; this one takes all for free.
  const std::string world =
      "ground: [step: {at_m: [2, 0], height_m: -0.5}]\nrobot: {path_m: [[0, 0], [1, 0]]}\n"
      "sensor: {dropout: 1}\n";
  write("edge.yaml", world);
  const std::string arguments = " --goal 4,0 --timeout 20 --output out --map octomap";
  EXPECT_EQ(run("edge.yaml" + arguments), 6) << text("err.txt");
  EXPECT_EQ(summary("out")["ending"], "fall");
  talus::test::write_bytes(
      path("up.yaml"), std::string(world).replace(world.find("-0.5"), 4, "0.5"));
  EXPECT_EQ(run("up.yaml" + arguments), 4) << text("err.txt");
  EXPECT_EQ(summary("out")["ending"], "collision");
}

TEST_F(TalusNav, takes_another_scanner_and_mounting_than_the_world_has)
{
  EXPECT_EQ(
      drive(
          "nav_blocked.yaml",
          "--goal 7,0 --timeout 2 --output out --scanner os0128 --mount "
          "0.1,0,0.7,0,20,0"),
      5)
      << text("err.txt");
  EXPECT_EQ(summary("out")["mount"][4], 20);
  EXPECT_EQ(summary("out")["scanner"], "OS0-128");
  EXPECT_EQ(drive("nav_blocked.yaml", "--goal 7,0 --output out --mount 0,0,0.7 --timeout 1"), 2);
  EXPECT_EQ(drive("nav_blocked.yaml", "--goal 7,0 --output out --scanner none"), 2);
}

TEST_F(TalusNav, does_not_fall_where_the_table_of_drops_says_that_it_stops_in_time)
{
  EXPECT_EQ(run("--drop-table --mount 0,0,0.68,0,0,0"), 0);
  std::istringstream lines(text("out.txt"));
  std::string line;
  while (std::getline(lines, line) && line.rfind("| OS0-128", 0) != 0)
  {
  }
  double ground_m = 0, at_slow_m = 0, at_usual_m = 9, at_fast_m = 0;
  ASSERT_EQ(
      std::sscanf(
          line.c_str(), "| OS0-128 | 0.00 m ahead, 0.68 m up, pitch 0 | %lf | %lf | %lf | %lf",
          &ground_m, &at_slow_m, &at_usual_m, &at_fast_m),
      4)
      << line;
  EXPECT_LT(at_usual_m, 0.5) << "so that a hole of half a metre is found at 0.7 m/s";
  const std::string world =
      "ground: [ditch: {at_m: [4, 0], yaw_deg: 90, width_m: 0.5, depth_m: 1}]\n"
      "objects: [wall: {from_m: [-1, -2], to_m: [9, -2], height_m: 2},\n"
      "  wall: {from_m: [-1, 2], to_m: [9, 2], height_m: 2},\n"
      "  wall: {from_m: [-1, -2], to_m: [-1, 2], height_m: 2}]\n"
      "robot: {path_m: [[0, 0], [1, 0]]}\n";
  EXPECT_EQ(drive_in("hole.yaml", world, "--goal 8,0 --output out --scanner OS0-128"), 3)
      << text("out.txt");
}

TEST_F(TalusNav, tells_where_ahead_it_sees_what_is_as_high_as_the_robot)
{
  const auto row = [this](const std::string& scanner, const std::string& mount)
  {
    EXPECT_EQ(run("--drop-table --mount " + mount), 0);
    const std::string table = text("out.txt");
    const auto at = table.find("| " + scanner + " |");
    const std::string line = table.substr(at, table.find('\n', at) - at);
    return line.substr(line.rfind('|', line.size() - 2) + 2);
  };
  // The highest ray looks 5 degrees down from 0.68 m; 5 down from 1.2 m; 2.5 up from 0.68 m.
  EXPECT_EQ(row("RS-LiDAR-16", "0,0,0.68,0,20,0"), "nowhere |");
  EXPECT_EQ(row("RS-LiDAR-16", "0,0,1.2,0,20,0"), "up to 4.6 m |");
  EXPECT_EQ(row("OS1-64", "0,0,0.68,0,20,0"), "from 2.7 m on |");
  EXPECT_EQ(row("OS1-64", "0,0,0.8,0,0,0"), "everywhere |");

  const std::string world =
      "ground: [plane: {}]\n"
      "objects: [table: {at_m: [2, 0], size_m: [0.8, 4, 0.78], thickness_m: 0.03}]\n"
      "robot: {path_m: [[0, 0], [1, 0]]}\n";
  const std::string tilted = "--goal 4,0 --mount 0,0,0.68,0,20,0 --timeout 40 --output out";
  EXPECT_EQ(drive_in("tables.yaml", world, tilted), 4) << text("out.txt");
  const std::string hint = "hint: tables.yaml: the highest ray ahead looks 5 degrees down";
  EXPECT_SAYS(text("err.txt"), hint);
  EXPECT_EQ(drive_in("tables.yaml", world, "--goal 4,0 --timeout 2 --output out"), 5);
  EXPECT_SAYS_NOT(text("err.txt"), "hint");
}

TEST_F(TalusNav, warns_when_the_file_does_not_say_how_the_map_becomes_obstacles)
{
  auto ini = read_bytes(TALUS_SOURCE_DIR "/datasets/configs/reactive2d_config.ini");
  ini.resize(ini.find("[talus_obstacles]"));
  write("own.ini", ini);
  const std::string arguments = "--goal 15,0 --timeout 1 --output ";
  drive("nav_indoor.yaml", arguments + "own --planner-config own.ini");
  EXPECT_SAYS(text("err.txt"), "own.ini: has no section [talus_obstacles]");
  drive("nav_indoor.yaml", arguments + "builtin");
  EXPECT_SAYS_NOT(text("err.txt"), "talus_obstacles");
}

TEST_F(TalusNav, refuses_options_worlds_and_files_that_are_wrong)
{
  for (const std::string wrong :
       {"--goal=nan,0", "--goal=0,inf", "--goal=1e9,0", "--goal=1,0 --timeout nan",
        "--goal=1,0 --noise nan", "--goal=1,0 --pose-noise nan", "--goal=1,0 --angle-noise nan",
        "--goal=1,0 --seed -1", "--goal=1,0 --planner-config ''"})
  {
    const auto option = wrong.substr(wrong.rfind("--"));
    const auto name = option.substr(0, option.find_first_of("= "));
    refuses(2, drive("nav_indoor.yaml", "--output out " + wrong), {name + ":"});
  }
  refuses(
      1, drive("nav_indoor.yaml", "--goal 2999,0 --output out"),
      {"to (3000.5, 5.5) m", ": choose a nearer --goal, or move what is far away in the world"});
  const std::string world =
      "ground: [plane: {}]\nobjects: [box: {at_m: [9e5, 0], size_m: [1, 2, 1]}]\n"
      "robot: {path_m: [[0, 0], [1, 0]]}\n";
  refuses(
      1, drive_in("far.yaml", world, "--goal 4,0 --output out"),
      {"far.yaml: start, goal and objects"});
  refuses(1, run("none.yaml --goal 1,0 --output out"), {"none.yaml"});
  refuses(2, run("none.yaml --goal 1 --output out"), {});
  refuses(
      2, drive("nav_indoor.yaml", "--goal 1,0 --output out --planner-config none.ini"),
      {"none.ini: no such file"});
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const std::string what : {"pipe", "/dev/zero"})
  {
    const std::string said = what + ": is a pipe or a device", limit = "timeout -s KILL 20";
    refuses(1, run(what + " --goal 1,0 --output out", limit), {said});
    const std::string config = "none.yaml --goal 1,0 --output out --planner-config ";
    refuses(2, run(config + what, limit), {said});
  }
  refuses(
      1,
      run(TALUS_SOURCE_DIR "/datasets/worlds/nav_indoor.yaml --goal 15,0 --timeout 5 --output out",
          "ulimit -f 16;"),
      {"out: the log of the navigator", "is the disk full?"});
  const std::string name = "a\x1b[31m.yaml";
  write(name, "ground: \x1b[32m");
  refuses(1, run("'" + name + "' --goal 1,0 --output out"), {"a\\x1b[31m.yaml:1: "});
  EXPECT_EQ(text("err.txt").find('\x1b'), std::string::npos) << text("err.txt");
  EXPECT_EQ(run("--version"), 0);
}

TEST_F(TalusNav, keeps_off_the_edge_beside_the_ramp_down_from_a_terrace)
{
  ASSERT_EQ(drive("nav/nav_terrace.yaml", "--goal 1,2.2 --output out --scanner RS-LiDAR-16"), 0)
      << text("out.txt");
  // The edge is at x = 5.4 m where y > 1; the middle of the robot keeps its corner away from it.
  for (const Row& r : driven("out"))
    if (r.y_m > 1.3)
    {
      EXPECT_GT(std::abs(r.x_m - 5.4), 0.35) << "at " << r.time_s << " s";
    }
}

TEST_F(TalusNav, finds_the_way_around_what_reaches_far_beyond_start_and_goal)
{
  const std::string world =
      "ground: [ditch: {at_m: [3, 0], yaw_deg: 90, width_m: 0.8, depth_m: 0.6, length_m: 6}]\n"
      "robot: {path_m: [[0, 0], [1, 0]]}\nsensor: {at_m: [0, 0, 0.68]}\n";
  EXPECT_EQ(
      drive_in("around.yaml", world, "--goal 6,0 --timeout 60 --output out --scanner OS0-128"), 0)
      << text("out.txt");
}

TEST_F(TalusNav, writes_a_summary_of_a_world_whose_name_is_not_utf8)
{
  const std::string name = "nav_\xff.yaml";
  std::filesystem::copy_file(TALUS_SOURCE_DIR "/datasets/worlds/nav_indoor.yaml", path(name));
  EXPECT_EQ(run(name + " --goal 15,0 --timeout 1 --output out"), 5) << text("err.txt");
  EXPECT_EQ(summary("out")["world"], "nav_\xef\xbf\xbd.yaml");
}

TEST_F(TalusNav, names_the_key_of_a_planner_configuration_that_is_wrong)
{
  struct Wrong
  {
    const char *planner, *was, *is, *message;
  };
  for (const Wrong& w : std::vector<Wrong>{
           {"2d", "ROBOT_MAX_V  0.7", "ROBOT_MAX_V  abc",
            "robotMax_V_mps = 'abc': must be a number (in section CAbstractPTGBasedReactive)"},
           {"2d", "NAV_MAX_REF_DIST   4.0", "NAV_MAX_REF_DIST   -4",
            "ref_distance = '-4': must be from 0.5 to 50 (in section CAbstractPTGBasedReactive)"},
           {"2d", "PTG1_resolution = 0.05", "PTG1_resolution = 0.001",
            "PTG1_resolution = '0.001': must be from 0.005 to 1"},
           {"2d", "NAV_MAX_REF_DIST   4.0", "NAV_MAX_REF_DIST   50.0",
            "must be 0.1 or more, or PTG0_refDistance less: its grid would have"},
           {"2d", "PTG0_K = 1.0", "PTG0_K = 0.5", "PTG0_K = '0.5': must be 1 or -1"},
           {"2d", "PTG0_K = 1.0",
            "PTG0_K =", "PTG0_K = '': must be a number (in section CReactiveNavigationSystem)"},
           {"2d", "enable_obstacle_filtering                         = false",
            "enable_obstacle_filtering = maybe",
            "enable_obstacle_filtering = 'maybe': must be true or false (in section "
            "CAbstractPTGBasedReactive)"},
           {"2d", "[0.25 , 0.1 ,", "[0.25 , x ,", "1  , 0.05 , 0.5, 1, 1, 0 ]': must be numbers"},
           {"2d", "\nPTG_COUNT", "\n# PTG_COUNT", "PTG_COUNT is missing: must be a whole number"},
           {"2d", "RobotModel_shape2D_ys = 0.35",
            "RobotModel_shape2D_ys =", "must be as many numbers as RobotModel_shape2D_xs"},
           {"3d", "LEVEL2_HEIGHT = 0.25", "LEVEL2_HEIGHT = -0.25",
            "LEVEL2_HEIGHT = '-0.25': must be from 0.01 to 10"}})
  {
    auto ini = read_bytes(
        std::string(TALUS_SOURCE_DIR "/datasets/configs/reactive") + w.planner + "_config.ini");
    const auto at = ini.find(w.was);
    ASSERT_NE(at, std::string::npos) << w.was;
    ini.replace(at, std::string(w.was).size(), w.is);
    const mrpt::config::CConfigFileMemory file(ini);
    const bool is_3d = std::string(w.planner) == "3d";
    EXPECT_SAYS(message_of([&] { talus::nav::check_planner_ini(file, is_3d); }), w.message);
  }
}

TEST_F(TalusNav, names_the_file_of_a_planner_configuration_that_is_wrong)
{
  const std::string mrpt = "own.ini: MRPT's CReactiveNavigationSystem cannot work";
  for (const auto& [planner, was, is, message] : std::vector<std::array<std::string, 4>>{
           {"2d", "\nseen_within_m = 1.0", "\nseen_within_m = abc",
            "seen_within_m = 'abc': must be"},
           {"2d", "\nresolution = 0.05", "\nresolution = 0.1",
            "resolution = 0.1 m: must be 0.05 m"},
           {"2d", "\nunseen ", "\nfree\nunseen ", "own.ini:215: 'free' has no '='"},
           {"2d", "CPTG_DiffDrive_alpha", "CPTG_Nothing", "No PTG named `CPTG_Nothing`"},
           {"2d", "8.0*euclidean", "8.0*(euclidean", "Mismatched brackets"}})
  {
    auto ini = read_bytes(TALUS_SOURCE_DIR "/datasets/configs/reactive" + planner + "_config.ini");
    const auto at = ini.find(was);
    ASSERT_NE(at, std::string::npos) << was;
    ini.replace(at, was.size(), is);
    write("own.ini", ini);
    const std::string arguments = "--goal 15,0 --planner-config own.ini --output out --planner ";
    const bool by_mrpt = was[0] == 'C' || was[0] == '8';
    refuses(
        2, drive("nav_indoor.yaml", arguments + planner), {by_mrpt ? mrpt : "own.ini", message});
    EXPECT_SAYS_NOT(text("err.txt"), "backtrace");
  }
}
