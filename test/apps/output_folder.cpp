// Where a command puts its results: all of them appear, or none.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <set>
#include <stdexcept>
#include <thread>

#include "apps/common/child_process.h"
#include "apps/common/output_folder.h"
#include "log_files.h"

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

TEST(OutputFolder, moves_everything_back_when_the_file_elsewhere_cannot_be_replaced)
{
  const ScratchDir dir;
  fs::create_directory(dir / "out");
  write_bytes(dir / "out/map.tif", "old");
  write_bytes(dir / "out/seal", "old");
  {
    OutputFolder output(dir / "out");
    for (const char* name : {"/map.tif", "/timing.csv", "/seal"})
      write_bytes(output.staging() + name, "new");
    output.elsewhere(dir / "copy").write("new");
    fs::create_directories(dir / "copy/of another");
    EXPECT_THROW(output.commit("seal"), std::runtime_error);
  }
  EXPECT_EQ(read_bytes(dir / "out/map.tif"), "old");
  EXPECT_EQ(read_bytes(dir / "out/seal"), "old");
  EXPECT_FALSE(fs::exists(dir / "out/timing.csv"));
  EXPECT_EQ(names_in(dir / ""), (Names{"copy", "out"}));
  EXPECT_EQ(names_in(dir / "out"), (Names{"map.tif", "seal"}));
}

TEST(OutputFolder, has_without_its_seal_no_results)
{
  const ScratchDir dir;
  OutputFolder output(dir / "out");
  write_bytes(output.staging() + "/map.tif", "new");
  EXPECT_THROW(output.commit("seal"), std::runtime_error);
  EXPECT_FALSE(fs::exists(dir / "out/map.tif"));
}

TEST(OutputFolder, replaces_no_pipe)
{
  const ScratchDir dir;
  fs::create_directory(dir / "out");
  ASSERT_EQ(::mkfifo((dir / "out/map.tif").c_str(), 0600), 0);
  OutputFolder output(dir / "out");
  write_bytes(output.staging() + "/map.tif", "new");
  EXPECT_THROW(output.commit("map.tif"), std::runtime_error);
  EXPECT_TRUE(fs::is_fifo(dir / "out/map.tif"));
}

TEST(OutputFolder, can_be_made_while_another_run_removes_the_same_folder_again)
{
  const ScratchDir dir;
  const auto make_often = [&]
  {
    for (int i = 0; i < 1000; ++i) EXPECT_NO_THROW(OutputFolder(dir / "new/deep"));
  };
  std::thread other(make_often);
  make_often();
  other.join();
}

TEST(OutputFolder, tells_of_its_hidden_folder_by_the_name_that_was_given)
{
  const ScratchDir dir;
  const std::string name = dir / "out";
  OutputFolder output(name);
  EXPECT_EQ(
      output.told(output.staging() + "/a and " + output.staging() + "/b"),
      name + "/a and " + name + "/b");
  try
  {
    output.commit("map.tif");
    ADD_FAILURE() << "nothing thrown";
  }
  catch (const std::runtime_error& e)
  {
    EXPECT_NE(std::string(e.what()).find(name + "/map.tif"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find(output.staging()), std::string::npos) << e.what();
  }
}

TEST(OutputFolder, makes_of_a_limit_on_the_size_of_files_an_error_that_can_be_told)
{
  const auto end = talus::app::run_in_child(
      []
      {
        const ScratchDir dir;
        const OutputFolder output(dir / "out");
        const rlimit limit{8, 8};
        if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 1;
        return (std::ofstream(output.staging() + "/a") << "too long"
                                                       << " for it")
                       .flush()
                   ? 2
                   : 0;
      });
  EXPECT_EQ(end.signal, 0);
  EXPECT_EQ(end.exit_code, 0);
}

TEST(OutputFolder, is_not_left_behind_when_nobody_reads_what_is_printed)
{
  const ScratchDir dir;
  const auto print_to_nobody = [&]
  {
    std::signal(SIGPIPE, SIG_DFL);
    int ends[2];
    if (::pipe(ends) != 0 || ::close(ends[0]) != 0) return 2;
    const OutputFolder output(dir / "out");
    return ::write(ends[1], "x", 1) == -1 && errno == EPIPE ? 0 : 1;
  };
  const auto end = talus::app::run_in_child(print_to_nobody);
  EXPECT_EQ(end.signal, 0);
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_FALSE(fs::exists(dir / "out"));
}

TEST(FolderLock, is_of_one_process_at_a_time_by_whatever_name_and_lost_where_the_folder_is_gone)
{
  using talus::io::FolderLock;
  const ScratchDir dir;
  fs::create_directory(dir / "out");
  fs::create_directory_symlink(dir / "out", dir / "link");
  {
    const FolderLock lock(dir / "link", FolderLock::IfTaken::GiveUp);
    EXPECT_TRUE(lock.is_held());
    EXPECT_TRUE(FolderLock(dir / "out", FolderLock::IfTaken::GiveUp).is_lost());
  }
  EXPECT_TRUE(FolderLock(dir / "out", FolderLock::IfTaken::GiveUp).is_held());
  EXPECT_TRUE(FolderLock(dir / "none", FolderLock::IfTaken::GiveUp).is_lost());
}

TEST(HiddenFolder, that_a_process_left_is_removed_and_no_link_or_folder_of_another_name)
{
  const ScratchDir dir;
  using talus::io::HiddenFolder;
  fs::create_directories(dir / ".talus-file.left00/in it");
  fs::create_directories(dir / "mine/in it");
  fs::create_directory_symlink(dir / "mine", dir / ".talus-file.link00");
  fs::create_directory(dir / ".talus-file.mine");
  const HiddenFolder held(dir / "", talus::io::kFilePrefix);
  EXPECT_EQ(talus::io::remove_abandoned_files(dir / "a.txt"), 1u);
  const std::string held_name = held.path().filename().string();
  EXPECT_EQ(
      names_in(dir / ""), (Names{".talus-file.link00", ".talus-file.mine", "mine", held_name}));
  EXPECT_EQ(names_in(dir / "mine"), Names{"in it"});
}

TEST(OutputFolder, has_no_result_that_is_an_input)
{
  const ScratchDir dir;
  write_bytes(dir / "path.csv", "input");
  using talus::app::require_results_apart;
  require_results_apart(dir / "", {"map.tif"}, {dir / "path.csv", ""});
  talus::test::expect_error(
      [&] {
        require_results_apart(dir / "", {"map.tif", "path.csv"}, {dir / "path.csv"});
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
