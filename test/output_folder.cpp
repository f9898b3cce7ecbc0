// Where talus-map puts its results: all of them appear, or none.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <stdexcept>
#include <thread>

#include "apps/talus-map/output_folder.h"
#include "log_files.h"

namespace fs = std::filesystem;
using talus::app::OutputFolder;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

TEST(OutputFolder, moves_everything_back_when_the_last_step_fails)
{
  const ScratchDir dir;
  fs::create_directory(dir / "out");
  write_bytes(dir / "out/map.tif", "old");
  {
    OutputFolder output(dir / "out");
    write_bytes(output.staging() + "/map.tif", "new");
    write_bytes(output.staging() + "/timing.csv", "new");
    const auto fail = [&]
    {
      EXPECT_EQ(read_bytes(dir / "out/map.tif"), "new") << "it is the last step";
      throw std::runtime_error("the disk is full");
    };
    EXPECT_THROW(output.commit(fail), std::runtime_error);
  }
  EXPECT_EQ(read_bytes(dir / "out/map.tif"), "old");
  EXPECT_FALSE(fs::exists(dir / "out/timing.csv"));
}

TEST(OutputFolder, replaces_no_pipe)
{
  const ScratchDir dir;
  fs::create_directory(dir / "out");
  ASSERT_EQ(::mkfifo((dir / "out/map.tif").c_str(), 0600), 0);
  OutputFolder output(dir / "out");
  write_bytes(output.staging() + "/map.tif", "new");
  EXPECT_THROW(output.commit(), std::runtime_error);
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
