// talus-map of what is no rawlog: folders and files of scans, bags, folders of rawlogs.
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <talus/io/rawlog_reader.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "scan_formats.h"
#include "talus_map_run.h"

namespace fs = std::filesystem;
using namespace talus::test;

namespace
{
class TalusMapSources : public TalusMap
{
 protected:
  void write_scans(const std::string& folder, int count) const
  {
    write_scan_folder(path(folder), floor_points(30), count, kFirstStamp_s);
  }

  /** What talus-import makes of the same arguments, mapped. */
  void map_in_two_steps(const std::string& arguments, const std::string& output) const
  {
    const std::string import = fs::path(TALUS_MAP_EXE).replace_filename("talus-import").string();
    const std::string command = "cd '" + path("") + "' && '" + import + "' " + arguments +
                                " --output two_steps.rawlog --quiet";
    ASSERT_EQ(std::system(command.c_str()), 0);
    runs("two_steps.rawlog --quiet --output " + output);
  }

  std::vector<std::string> names_in(const std::string& folder) const
  {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path(folder)))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  const std::vector<std::string> results_{"map.png",       "map.qml",      "map.tif",
                                          "site.png",      "site.qml",     "site.tif",
                                          "site_way.gpkg", "summary.json", "timing.csv"};
};
}  // namespace

TEST_F(TalusMapSources, are_mapped_as_the_log_that_talus_import_makes_of_them)
{
  write_scans("front", 5);
  write_bytes(path("poses.tum"), straight_tum(5));
  const std::string arguments = "front --poses poses.tum --mount front=0.1,0,0.5,10,0,0";
  const CommandEnd one = runs(arguments + " --output one");
  map_in_two_steps(arguments, "two");
  EXPECT_TRUE(read_bytes(path("one/site.tif")) == read_bytes(path("two/site.tif")));
  EXPECT_EQ(summary("one")["frames"], 5);
  EXPECT_EQ(names_in("one"), results_);
  EXPECT_SAYS(one.out, "import  5 scans of front");
  EXPECT_SAYS(one.out, "5 poses of poses.tum");
  EXPECT_EQ(summary("one")["poses"], "poses.tum");
  EXPECT_EQ(summary("one")["log"], "front");
}

TEST_F(TalusMapSources, may_be_the_key_frames_of_a_simplemap)
{
  const std::string demo = " '" TALUS_SOURCE_DIR "/datasets/worlds/demo.yaml' ";
  const std::string simulate =
      "cd '" + path("") + "' && '" + TALUS_SIM_EXE + "'" + demo + "--output . --frames 6 --quiet";
  ASSERT_EQ(std::system(simulate.c_str()), 0);
  const auto poses = talus::io::Trajectory::load(path("demo.tum"));
  talus::io::RawlogReader log(path("demo.rawlog"));
  mrpt::maps::CSimpleMap map;
  while (const auto obs = log.next())
  {
    mrpt::poses::CPose3DPDFGaussian pose;
    pose.mean = *poses.at(mrpt::Clock::toDouble(obs->timestamp), 0.5);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(obs);
    map.insert(pose, frame);
  }
  ASSERT_TRUE(map.saveToFile(path("drive.simplemap")));
  runs("demo.rawlog --quiet --output log");
  runs("drive.simplemap");
  EXPECT_TRUE(read_bytes(path("drive_map/site.tif")) == read_bytes(path("log/site.tif")));
  EXPECT_EQ(summary("drive_map")["poses"], "key frames of the log");
}

TEST_F(TalusMapSources, leave_the_log_beside_the_map_where_it_is_asked_for)
{
  write_scans("front", 4);
  write_bytes(path("poses.tum"), straight_tum(4));
  // A trajectory is one, whichever command the name of its switch comes from.
  runs("front/ --trajectory poses.tum --mount front=0,0,0.5,0,0,0 --keep-log");
  std::vector<std::string> names = results_;
  names.insert(names.begin(), {"front.rawlog", "front.tum"});
  EXPECT_EQ(names_in("front_map"), names);
  runs("front_map/front.rawlog --output again");
  EXPECT_TRUE(read_bytes(path("front_map/map.tif")).size() > 0);
  EXPECT_TRUE(read_bytes(path("front_map/site.tif")) == read_bytes(path("again/site.tif")));
}

TEST_F(TalusMapSources, of_a_single_scan_need_no_pose)
{
  write_bytes(path("yard.pcd"), pcd_binary(floor_points(30)));
  const CommandEnd done = runs("yard.pcd");
  EXPECT_EQ(summary("yard_map")["poses"], "static, as a single scan without a pose") << done.err;
}

TEST_F(TalusMapSources, without_poses_are_refused_with_what_to_pass)
{
  write_scans("front", 3);
  const std::size_t before = entries();
  fails("front", 1, {"front: has no poses of the robot. Pass --trajectory FILE"});
  EXPECT_EQ(entries(), before);
  runs("front --static --quiet");
}

TEST_F(TalusMapSources, that_are_a_folder_of_rawlogs_are_a_batch)
{
  fs::create_directories(path("logs"));
  write_log(path("logs/b.rawlog.zst"), floor_scans(3), Packing::Gz);  // its bytes tell what it is
  write_log(path("logs/a.rawlog"), floor_scans(3), Packing::Gz);
  for (const char* name : {"logs/b.tum", "logs/a.tum"}) write_bytes(path(name), straight_tum(3));
  const CommandEnd done = runs("logs --output out");
  EXPECT_EQ(names_in("out"), (std::vector<std::string>{"a", "b"}));
  EXPECT_SAYS(done.out, "2 logs: 2 done, 0 failed");
  fails("logs --rawlog-out x.rawlog", 2, {});
}

TEST_F(TalusMapSources, get_a_configuration_suggested)
{
  write_scans("front", 3);
  const std::size_t before = entries();
  const CommandEnd done = runs("front --static --mount front=0,0,0.5,0,0,0 --suggest");
  EXPECT_SAYS(done.out, "Made from 3 scans of front");
  EXPECT_EQ(entries(), before);
}

TEST_F(TalusMapSources, have_switches_that_are_refused_where_nothing_is_imported)
{
  write_log(path("log.rawlog"), floor_scans(2), Packing::Gz);
  for (const char* option : {"--mount lidar=0,0,1,0,0,0", "--keep-log", "--topic /points"})
  {
    const CommandEnd refused = run(std::string("log.rawlog --static ") + option);
    EXPECT_EQ(refused.code, 2) << option;
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
    EXPECT_TRUE(refused.says(name + ": is for scans of other programs")) << refused.err;
  }
  EXPECT_TRUE(run("none --static --mount none=0,0,1,0,0,0").says("none: no such file"));
}

TEST_F(TalusMapSources, may_be_bags_of_which_one_topic_is_mapped)
{
  const std::string make = std::string("python3 -S '") + TALUS_SOURCE_DIR +
                           "/test/import/make_bags.py' '" + path("") + "' parts 2>/dev/null";
  if (std::system(make.c_str()) != 0) GTEST_SKIP() << "no bags can be made here: python3?";
  const CommandEnd done = run("parts --topic /front/points --output out");
  if (done.says("was built without")) GTEST_SKIP() << done.err;
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(summary("out")["sensors"], nlohmann::json({{"/front/points", 10}}));
  EXPECT_SAYS(done.out, "poses are those of 'base_link' in 'map' in TF");
}

TEST_F(TalusMapSources, keep_the_snapshots_in_a_log_of_their_own)
{
  write_scans("front", 3);
  runs("front --static --mount front=0,0,0.5,0,0,0 --rawlog-out terrain.rawlog --output out");
  EXPECT_TRUE(exists("terrain.rawlog"));
  fails(
      "front --static --keep-log --rawlog-out out/front.rawlog --output out", 1,
      {"is one of the results in out"});
}

TEST_F(TalusMapSources, that_a_result_would_replace_are_refused)
{
  write_log(path("site.tif"), floor_scans(2), Packing::Plain);
  write_log(path("map.tif"), floor_scans(2), Packing::Plain);
  for (const std::string log : {"site.tif", "map.tif"})
  {
    const std::string bytes = read_bytes(path(log));
    fails(
        log + " --static --output .", 1,
        {"/" + log + "' would be overwritten, but it is an input"});
    EXPECT_TRUE(read_bytes(path(log)) == bytes) << log;
  }
  write_log(path("log.rawlog"), floor_scans(2), Packing::Plain);
  write_bytes(path("timing.csv"), straight_tum(2));
  EXPECT_TRUE(run("log.rawlog --trajectory timing.csv --output .")
                  .says("timing.csv' would be overwritten"));
  runs("site.tif --static --output elsewhere");
}
