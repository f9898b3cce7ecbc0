// Where a command puts its results: all of them appear, or none.
#include <gtest/gtest.h>
#include <talus/io/atomic_file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <set>
#include <stdexcept>

#include "apps/common/child_process.h"
#include "apps/common/output_folder.h"
#include "log_files.h"
#include "message_of.h"

namespace fs = std::filesystem;
using talus::app::OutputFolder;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
using Names = std::set<std::string>;

/** Of all that is in a folder, hidden or not. */
Names names_in(const std::string& folder)
{
  Names names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}
}  // namespace

TEST(OutputFolder, changes_nothing_where_one_of_the_results_cannot_be_replaced)
{
  const ScratchDir dir;
  fs::create_directories(dir / "out/timing.csv");
  ASSERT_EQ(::mkfifo((dir / "out/pipe").c_str(), 0600), 0);
  write_bytes(dir / "out/map.tif", "old");
  write_bytes(dir / "out/seal", "old");
  for (const char* taken : {"timing.csv", "pipe"})
  {
    OutputFolder output(dir / "out");
    for (const char* name : {"map.tif", taken, "seal"})
      write_bytes(output.staging() + "/" + name, "new");
    talus::test::expect_error([&] { output.commit("seal"); }, {taken, "write elsewhere"});
  }
  EXPECT_EQ(read_bytes(dir / "out/map.tif"), "old");
  EXPECT_EQ(read_bytes(dir / "out/seal"), "old");
  EXPECT_EQ(names_in(dir / "out"), (Names{"map.tif", "pipe", "seal", "timing.csv"}));
}

TEST(OutputFolder, removes_parts_of_a_run_before_and_nothing_else)
{
  const ScratchDir dir;
  fs::create_directories(dir / "out/frames");
  const Names parts{
      "site.png",
      "site_floor_1.tif",
      "site_island_2_way.gpkg",
      "site_floor_1_island_2.png",
      "traffic_floor_1.tif",
      "frames/frame_000007.png"};
  const Names others{"site_plan.tif", "site_floor_.tif",    "my_site.tif",
                     "notes.label",   "frames/frame_1.png", "frames/mine.txt"};
  for (const Names& names : {parts, others})
    for (const std::string& name : names) write_bytes(dir / ("out/" + name), "old");
  OutputFolder output(dir / "out");
  fs::create_directory(output.staging() + "/frames");
  for (const char* name : {"/site.tif", "/frames/frame_000001.png", "/seal"})
    write_bytes(output.staging() + name, "new");
  output.commit("seal");
  for (const std::string& name : parts) EXPECT_FALSE(fs::exists(dir / ("out/" + name))) << name;
  for (const std::string& name : others) EXPECT_TRUE(fs::exists(dir / ("out/" + name))) << name;
}

TEST(OutputFolder, exports_of_a_site_go_with_it)
{
  const ScratchDir dir;
  const Names exports{"site.pgm", "site_floor_1.html", "site_height.json"};
  const Names others{"site.qml", "map.yaml", "site.txt"};
  const auto run = [&](const std::string& seal)
  {
    OutputFolder output(dir / "out");
    for (const std::string name : {"/site.tif", "/site.yaml"})
      write_bytes(output.staging() + name, "new");
    write_bytes(output.staging() + "/" + seal, "new");
    output.commit(seal);
  };
  fs::create_directory(dir / "out");
  for (const std::string& name : exports) write_bytes(dir / ("out/" + name), "old");
  for (const std::string& name : others) write_bytes(dir / ("out/" + name), "old");
  run("seal");
  for (const std::string& name : exports)
    EXPECT_TRUE(fs::exists(dir / ("out/" + name))) << "there was no site: whose is " << name;
  run("seal");
  for (const std::string& name : exports) EXPECT_FALSE(fs::exists(dir / ("out/" + name))) << name;
  for (const std::string& name : others) EXPECT_TRUE(fs::exists(dir / ("out/" + name))) << name;
  EXPECT_EQ(read_bytes(dir / "out/site.yaml"), "new");
}

TEST(OutputFolder, makes_no_folder_of_snapshots_where_there_are_none)
{
  const ScratchDir dir;
  OutputFolder output(dir / "out");
  fs::create_directory(output.staging() + "/frames");
  write_bytes(output.staging() + "/seal", "new");
  output.commit("seal");
  EXPECT_EQ(read_bytes(dir / "out/seal"), "new");
  EXPECT_FALSE(fs::exists(dir / "out/frames"));
}

TEST(OutputFolder, has_without_its_seal_no_results)
{
  const ScratchDir dir;
  OutputFolder output(dir / "out");
  write_bytes(output.staging() + "/map.tif", "new");
  EXPECT_THROW(output.commit("seal"), std::runtime_error);
  EXPECT_FALSE(fs::exists(dir / "out/map.tif"));
}

TEST(OutputFolder, shows_its_hidden_folder_by_the_name_that_was_given)
{
  const ScratchDir dir;
  const std::string name = dir / "out";
  OutputFolder output(name);
  EXPECT_EQ(
      output.shown(output.staging() + "/a and " + output.staging() + "/b"),
      name + "/a and " + name + "/b");
  const std::string said = message_of([&] { output.commit("map.tif"); });
  EXPECT_SAYS(said, name + "/map.tif");
  EXPECT_SAYS_NOT(said, output.staging());
}

TEST(ChildProcess, makes_of_a_limit_on_the_size_of_files_and_of_a_closed_pipe_errors_of_writing)
{
  const auto write_in_vain = []
  {
    const ScratchDir dir;
    talus::app::forward_signals();
    int ends[2];
    const rlimit limit{8, 8};
    if (::pipe(ends) != 0 || ::close(ends[0]) != 0 || ::setrlimit(RLIMIT_FSIZE, &limit)) return 1;
    if (::write(ends[1], "x", 1) != -1 || errno != EPIPE) return 2;
    return (std::ofstream(dir / "a") << "too long for it").flush() ? 3 : 0;
  };
  const auto end = talus::app::run_in_child(write_in_vain);
  EXPECT_EQ(end.signal, 0);
  EXPECT_EQ(end.exit_code, 0);
}

TEST(HiddenFolder, that_a_process_left_is_removed_and_no_link_nor_one_that_is_held)
{
  const ScratchDir dir;
  using talus::io::HiddenFolder;
  fs::create_directories(dir / ".talus-file.left00/in it");
  fs::create_directories(dir / "mine/in it");
  fs::create_directory_symlink(dir / "mine", dir / ".talus-file.link00");
  const HiddenFolder held(dir / "", talus::io::kFilePrefix);
  EXPECT_EQ(HiddenFolder::remove_abandoned(dir / "", talus::io::kFilePrefix), 1u);
  const std::string held_name = held.path().filename().string();
  EXPECT_EQ(names_in(dir / ""), (Names{".talus-file.link00", "mine", held_name}));
  EXPECT_EQ(names_in(dir / "mine"), Names{"in it"});
}

TEST(OutputFolder, has_no_result_that_is_an_input)
{
  const ScratchDir dir;
  write_bytes(dir / "path.csv", "input");
  using talus::app::require_apart;
  require_apart(dir / "", {"map.tif"}, {dir / "path.csv", ""});
  talus::test::expect_error(
      [&] {
        require_apart(dir / "", {"map.tif", "path.csv"}, {dir / "path.csv"});
      },
      {"path.csv", "is an input; write elsewhere"});
}

TEST(ChildProcess, goes_on_ignoring_what_the_program_ignores)
{
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const auto end = talus::app::run_in_child([] { return std::raise(SIGHUP); });
  std::signal(SIGHUP, before);
  EXPECT_EQ(end.signal, 0) << "as under nohup";
}
