// Several logs of talus-map at once, and which device they get.
#include "talus_map_run.h"

#include <filesystem>
#include <map>
#include <regex>

namespace fs = std::filesystem;
using namespace talus::test;

namespace
{
/** All files below a folder; what is a time in them is blank. */
std::map<std::string, std::string> files_without_times(const std::string& folder)
{
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
  {
    if (!entry.is_regular_file()) continue;
    std::string text = read_bytes(entry.path().string());
    if (entry.path().filename() == "timing.csv") text = std::to_string(text.size() > 0);
    if (entry.path().filename() == "summary.json")
    {
      auto json = nlohmann::json::parse(text);
      for (const char* time : {"milliseconds", "wall_seconds"}) json.erase(time);
      text = json.dump();
    }
    files[entry.path().lexically_relative(folder).string()] = text;
  }
  return files;
}

std::string without_times(const std::string& text)
{
  return std::regex_replace(text, std::regex("[0-9.]+ ms a frame .*\\) on"), "on");
}

class TalusMapJobs : public TalusMap
{
 protected:
  /** Logs a, b, ... of drives of different length, the first the longest. */
  std::string logs(int count) const
  {
    std::string names;
    for (int i = 0; i < count; ++i)
    {
      const std::string name(1, static_cast<char>('a' + i));
      const int scans = 4 * (count - i);
      write_log(path(name + ".rawlog"), floor_scans(scans), Packing::Gz);
      write_bytes(path(name + ".tum"), straight_tum(scans));
      names += " " + name + ".rawlog";
    }
    return names;
  }
};
}  // namespace

TEST_F(TalusMapJobs, write_and_print_what_logs_one_after_the_other_do)
{
  const std::string names = logs(5) + " missing.rawlog";
  const CommandEnd one = run(names + " --jobs 1 --output one"),
                   many = run(names + " --jobs 4 --memory 16 --output one", "mv one first;");
  EXPECT_EQ(one.code, 1);
  EXPECT_EQ(many.code, 1);
  EXPECT_EQ(without_times(many.out), without_times(one.out));
  EXPECT_EQ(many.err, one.err);
  EXPECT_SAYS(many.out, "6 logs: 5 done, 1 failed");
  const auto first = files_without_times(path("first")), second = files_without_times(path("one"));
  EXPECT_EQ(first.size(), 5U * 9U);
  for (const auto& [name, bytes] : first)
  {
    ASSERT_EQ(second.count(name), 1U) << name;
    EXPECT_TRUE(second.at(name) == bytes) << name;
  }
}

TEST_F(TalusMapJobs, go_on_where_one_of_them_crashes_or_is_refused)
{
  logs(2);
  write_bytes(path("broken.rawlog"), "no log at all");
  const CommandEnd done =
      run("a.rawlog broken.rawlog missing.rawlog b.rawlog --jobs 3 --output out");
  EXPECT_EQ(done.code, 1);
  EXPECT_EQ(summary("out/a")["frames"], 8);
  EXPECT_EQ(summary("out/b")["frames"], 4);
  EXPECT_FALSE(exists("out/broken"));
  EXPECT_FALSE(exists("out/missing"));
  EXPECT_TRUE(done.says("2 of the logs failed:\n  broken.rawlog\n  missing.rawlog")) << done.err;
  EXPECT_LT(done.err.find("broken.rawlog: "), done.err.find("missing.rawlog: ")) << done.err;
}

// By then two logs are being read, which takes far longer. A sanitizer makes starting slow.
#ifdef TALUS_SANITIZER
const std::string kStopsAfter_s = "8";
#else
const std::string kStopsAfter_s = "3";
#endif

TEST_F(TalusMapJobs, end_with_the_signal_that_stops_the_command_and_leave_nothing)
{
  for (const char* name : {"a", "b", "c"})
  {
    write_log(path(name + std::string(".rawlog")), floor_scans(2000), Packing::Gz);
    write_bytes(path(name + std::string(".tum")), straight_tum(2000));
  }
  const std::size_t before = entries();
  const CommandEnd stopped =
      run("a.rawlog b.rawlog c.rawlog --jobs 2 -s window_m=30 --output out",
          "timeout --preserve-status -s TERM " + kStopsAfter_s);
  EXPECT_EQ(stopped.code, 128 + 15) << stopped.err;
  EXPECT_TRUE(stopped.says("a.rawlog: stopped; nothing was written")) << stopped.err;
  EXPECT_TRUE(stopped.says("b.rawlog: stopped; nothing was written")) << stopped.err;
  EXPECT_FALSE(stopped.says("c.rawlog")) << stopped.err;
  EXPECT_EQ(entries(), before);
}

TEST_F(TalusMapJobs, show_one_line_on_a_terminal)
{
  if (std::system("script --version >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "there is no `script` to make a terminal with";
  const std::string names = logs(3);
  const std::string command =
      "cd '" + path("") + "' && TERM=xterm script -qec \"'" TALUS_MAP_EXE "' --backend cpu" +
      names + " --jobs 3 --output out\" " + path("typescript") + " >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string shown = read_bytes(path("typescript"));
  EXPECT_SAYS(shown, "3 logs [");
  EXPECT_SAYS(shown, "3 logs: 3 done, 0 failed");
}

TEST_F(TalusMapJobs, fall_back_to_the_cpu_once_where_the_device_is_not_there)
{
  const std::string names = logs(2);
  write_bytes(
      path("robot.ini"),
      "[CDualElevationMap_creationOpts]\nbackend = auto\ndevice = 1000\n"
      "[CDualElevationMap_insertOpts]\n");
  const CommandEnd done = runs(names + " --backend auto --config robot.ini --output out");
  const std::string warning = "warning: device 1000: there are only ";
  EXPECT_TRUE(done.says(warning)) << done.err;
  EXPECT_EQ(done.err.find(warning), done.err.rfind(warning)) << done.err;
  EXPECT_EQ(summary("out/a")["backend"], "cpu");

  fails(names + " --backend cuda --device 1000 --output none", 2, {"device 1000: there are only "});
  EXPECT_FALSE(exists("none"));
  EXPECT_EQ(run(names + " --device 1000 --output out").code, 0) << "the cpu needs no device";
  fails(names + " --device first", 2, {});
  fails(names + " --jobs 0", 2, {});
}
