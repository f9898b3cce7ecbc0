// The command talus-map fed with what is wrong: exit codes, messages, and nothing half-written.
#include "sanitizer.h"
#include "talus_map_run.h"

#include <mrpt/obs/CObservationVelodyneScan.h>
#include <sys/resource.h>

#include <cstdint>
#include <random>

using namespace talus;
using namespace talus::test;

namespace
{
class TalusMapBadInput : public TalusMap
{
 protected:
  /** Mapping the log must fail, say the words, and leave no output. */
  void expect_failure(
      const std::string& arguments, int code, const std::vector<std::string>& words) const
  {
    const std::size_t before = entries();
    const CommandEnd failed = run(arguments + " --output out/deep");
    EXPECT_EQ(failed.code, code) << failed.err;
    for (const auto& word : words)
      EXPECT_TRUE(failed.says(word)) << "'" << word << "' not in: " << failed.err;
    EXPECT_FALSE(exists("out")) << "a folder was made for nothing";
    EXPECT_EQ(entries(), before) << "something was left behind";
  }

  void write_good_log(const std::string& name) const
  {
    write_log(path(name), floor_scans(3), Packing::Gz);
  }
};
}  // namespace

TEST_F(TalusMapBadInput, a_name_with_a_line_break_is_told_in_one_line)
{
  write_bytes(path("a\nb.tum"), "no poses");
  write_good_log("x.rawlog");
  EXPECT_TRUE(run("x.rawlog --trajectory 'a\nb.tum' --output out").says("a\\x0ab.tum"));
  write_bytes(path("c\nd.rawlog"), "");
  EXPECT_TRUE(run("x.rawlog 'c\nd.rawlog' --static --output out").says("\n  c\\x0ad.rawlog"));
}

TEST_F(TalusMapBadInput, a_log_that_cannot_be_mapped_says_why_and_what_to_pass)
{
  write_good_log("a.rawlog");
  write_bytes(path("old.tum"), straight_tum(5, 1600000000));
  write_bytes(
      path("far.tum"), straight_tum(1, kFirstStamp_s - 5) + straight_tum(1, kFirstStamp_s + 5));
  write_bytes(path("short.tum"), "1 2 3\n");
  auto scan = floor_scan(kFirstStamp_s);
  scan->timestamp = INVALID_TIMESTAMP;
  write_log(path("unstamped.rawlog"), {scan}, Packing::Gz);
  write_log(
      path("imu.rawlog"), {observation_at<mrpt::obs::CObservationIMU>(kFirstStamp_s)}, Packing::Gz);
  const auto fails = [&](const std::string& arguments, const std::vector<std::string>& words)
  { expect_failure(arguments, 1, words); };
  fails("a.rawlog", {"a.rawlog", "--trajectory", "a.tum", "--static"});
  fails(
      "a.rawlog --trajectory old.tum",
      {"a.rawlog", "old.tum", "1700000000.000", "1600000000.000", "do not overlap"});
  fails("a.rawlog --trajectory far.tum", {"--max-gap"});
  fails("a.rawlog --trajectory short.tum", {"short.tum:1: 3 words"});
  fails("unstamped.rawlog --trajectory old.tum", {"no time stamps", "--static"});
  fails("--static imu.rawlog", {"imu.rawlog", "CObservationIMU", "CObservationPointCloud"});
  fails("--static a.rawlog -s min_height_m=0", {"100 % height", "min_height_m"});
}

TEST_F(TalusMapBadInput, a_damaged_length_is_not_believed)
{
  TALUS_SKIP_UNDER_SANITIZER("it ends the program where memory ends");
  constexpr std::uint32_t kPackets = 1237;
  const auto scan = observation_at<mrpt::obs::CObservationVelodyneScan>(kFirstStamp_s);
  scan->scan_packets.resize(kPackets);
  write_log(path("a.rawlog"), {scan}, Packing::Plain);
  const std::string bytes = read_bytes(path("a.rawlog"));
  const auto at = bytes.find(std::string(reinterpret_cast<const char*>(&kPackets), 4));
  ASSERT_NE(at, std::string::npos);
  for (const std::uint32_t damaged : {1U << 22, 1U << 20})  // 5 GB, 1.3 GB
  {
    std::string changed = bytes;
    changed.replace(at, 4, reinterpret_cast<const char*>(&damaged), 4);
    write_bytes(path("a.rawlog"), changed);
    expect_failure("--static a.rawlog", 1, {"a.rawlog", "byte 0", "more memory", "damaged"});
  }
  rusage used{};
  ASSERT_EQ(::getrusage(RUSAGE_CHILDREN, &used), 0);
  EXPECT_LT(used.ru_maxrss, 400 * 1024) << "KB, the most of a command";
}

TEST_F(TalusMapBadInput, what_is_wrong_with_a_configuration_is_told_with_its_file_once)
{
  write_good_log("a.rawlog");
  const std::string section = "[CDualElevationMap_insertOpts]\n";
  write_bytes(path("other.ini"), "[Other]\nwindow = 3\n");
  expect_failure("--static a.rawlog --config none.ini", 2, {"none.ini", "no such file"});
  expect_failure("--static a.rawlog --config .", 2, {"directory"});
  expect_failure(
      "--static a.rawlog --config other.ini", 2, {"other.ini", "CDualElevationMap_insertOpts"});
  for (const auto& [text, told] : std::vector<std::pair<std::string, std::string>>{
           {section + "window_m 4\n", "talus-map: m.ini:2: 'window_m 4' has no '='"},
           {section + "window_m = ${W}\n", "talus-map: m.ini: Line 2: Unknown variable `${W}`\n"},
           {section + "window_m = x\n", "(in section CDualElevationMap_insertOpts of m.ini)\n"}})
  {
    write_bytes(path("m.ini"), text);
    const CommandEnd failed = run("--static a.rawlog --config m.ini");
    EXPECT_EQ(failed.code, 2) << text;
    EXPECT_TRUE(failed.says(told)) << failed.err;
    EXPECT_EQ(failed.err.find("m.ini"), failed.err.rfind("m.ini")) << failed.err;
  }
  EXPECT_FALSE(exists("a_map"));
  write_bytes(path("m.ini"), section + "clearence_m = 0.7\n");
  expect_failure("--static a.rawlog --config m.ini", 2, {"m.ini", "clearence_m", "'clearance_m'"});
}

TEST_F(TalusMapBadInput, parameters_and_options_that_are_wrong_are_refused_before_any_work)
{
  write_good_log("a.rawlog");
  write_bytes(path("m.ini"), "[CDualElevationMap_creationOpts]\nresolution = -0.05\n");
  expect_failure("--static a.rawlog --config m.ini", 2, {"m.ini", "resolution_m", "-0.05"});
  expect_failure("--static a.rawlog -s resolution_m=-1", 2, {"resolution_m", "-1"});
  expect_failure("--static a.rawlog -s window_m=5000", 2, {"100000 x 100000", "smaller window"});
  expect_failure("--static a.rawlog -s windo=5", 2, {"windo", "did you mean"});
  expect_failure("--static a.rawlog -s window_m", 2, {"NAME=VALUE"});
  expect_failure("", 2, {"LOG"});
  expect_failure("a.rawlog --colour red", 2, {"--colour"});
  expect_failure("a.rawlog --every 0", 2, {"--every"});
  expect_failure("a.rawlog --threads -1", 2, {"--threads"});
  expect_failure("a.rawlog --static --trajectory t.tum", 2, {"--static"});
  for (const std::string name : {"--trajectory", "--sensor", "--config", "--rawlog-out"})
    expect_failure("a.rawlog " + name + " ''", 2, {name + ": is empty"});
  const CommandEnd refused =
      run("--static a.rawlog --backend cuda", "export CUDA_VISIBLE_DEVICES=-1;");
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(refused.says("--backend cuda") && refused.says("--backend cpu")) << refused.err;
}

TEST_F(TalusMapBadInput, output_that_cannot_be_written_is_refused_before_any_work)
{
  write_good_log("a.rawlog");
  write_bytes(path("file"), "mine");
  for (const char* folder : {"file", "file/deeper", "/proc/talus"})
  {
    fails(
        std::string("--static a.rawlog --output ") + folder, 2,
        {"--output", std::string(folder).substr(0, 4)});
  }
  EXPECT_EQ(read_bytes(path("file")), "mine");
}

TEST_F(TalusMapBadInput, results_of_an_earlier_run_survive_one_that_fails)
{
  write_good_log("a.rawlog");
  runs("--static a.rawlog --output out");
  const std::string map = read_bytes(path("out/map.tif")), csv = read_bytes(path("out/timing.csv"));
  const std::size_t before = entries();
  fails("--static a.rawlog --output out", 1, {"out/"}, "ulimit -f 4;");
  write_bytes(path("a.rawlog"), "nonsense");
  fails("--static a.rawlog --output out", 1, {});
  EXPECT_TRUE(read_bytes(path("out/map.tif")) == map);
  EXPECT_TRUE(read_bytes(path("out/timing.csv")) == csv);
  EXPECT_EQ(entries(), before) << "nothing hidden was left";
}

TEST_F(TalusMapBadInput, the_copy_of_the_log_replaces_no_input_and_no_result)
{
  write_good_log("a.rawlog");
  write_bytes(path("a.tum"), straight_tum(3));
  write_bytes(path("t.tum"), straight_tum(3));
  write_bytes(path("m.ini"), "[CDualElevationMap_creationOpts]\nwindow = 4\n");
  const std::string options = "a.rawlog --trajectory t.tum --config m.ini --rawlog-out ";
  for (const char* name : {"a.rawlog", "a.tum", "./t.tum", "m.ini"})
  {
    const std::string before = read_bytes(path(name));
    expect_failure(options + name, 1, {name, "is an input; write elsewhere"});
    EXPECT_TRUE(read_bytes(path(name)) == before) << name;
  }
  const std::string result = "out/../out/deep/map.tif";
  expect_failure(options + result, 1, {result, "one of the results"});
  runs(options + "out/deep/log.rawlog --output out/deep");
}

TEST_F(TalusMapBadInput, a_copy_of_the_log_that_a_full_disk_cuts_short_replaces_nothing)
{
  // Noise, which does not shrink: the copy is then the largest of all files.
  std::mt19937 random(7);
  std::uniform_real_distribution<float> coordinate_m(-2, 2);
  auto scan = floor_scan(kFirstStamp_s);
  for (int i = 0; i < 200000; ++i)
    scan->pointcloud->insertPoint(coordinate_m(random), coordinate_m(random), 0);
  write_log(path("a.rawlog"), {scan}, Packing::Gz);
  const std::string arguments = "--static a.rawlog -s window_m=4 --rawlog-out copy.rawlog";
  runs(arguments);
  const auto size = std::filesystem::file_size(path("copy.rawlog"));
  write_bytes(path("copy.rawlog"), "precious");
  // The limit falls into the last bytes, which zlib writes when the file is closed, or earlier.
  for (const auto blocks : {(size - 1) / 512, size / 4 * 3 / 512})
  {
    fails(
        arguments, 1, {"copy.rawlog: could not be written", "is the disk full?"},
        "ulimit -f " + std::to_string(blocks) + ";");
    EXPECT_EQ(read_bytes(path("copy.rawlog")), "precious");
  }
}
