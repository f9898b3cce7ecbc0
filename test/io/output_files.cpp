// Files that appear whole or not at all, timing.csv and summary.json.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <talus/io/atomic_file.h>
#include <talus/io/quantile.h>
#include <talus/io/summary_json.h>

#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <cmath>
#include <sstream>

#include "log_files.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::io;
using talus::test::expect_error;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
std::size_t files_in(const std::string& folder)
{
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::vector<FrameReport> two_frames()
{
  std::vector<FrameReport> frames(2);
  frames[0].stamp_s = 1700000000.25;
  frames[0].points_in = 100;
  frames[0].points_accepted = 90;
  frames[0].rejected[static_cast<int>(Reject::Height)] = 10;
  frames[0].stage_ms[0] = 0.5;
  frames[0].total_ms = 2;
  frames[1] = frames[0];
  frames[1].total_ms = 4;
  return frames;
}
}  // namespace

TEST(AtomicFile, has_the_old_bytes_until_commit_and_the_new_ones_after)
{
  const ScratchDir dir;
  write_bytes(dir / "a.txt", "old");
  {
    const AtomicFile half(dir / "a.txt");
    write_bytes(half.temporary_path(), "half");
    EXPECT_EQ(files_in(dir / ""), 2u);
  }
  EXPECT_EQ(files_in(dir / ""), 1u) << "without commit nothing is left";
  AtomicFile file(dir / "a.txt");
  write_bytes(file.temporary_path(), "new");
  EXPECT_EQ(read_bytes(dir / "a.txt"), "old");
  file.commit();
  EXPECT_EQ(read_bytes(dir / "a.txt"), "new");
  EXPECT_EQ(files_in(dir / ""), 1u);
}

TEST(AtomicFile, keeps_the_permissions_of_the_file_it_replaces_and_follows_links)
{
  const ScratchDir dir;
  write_bytes(dir / "a.txt", "old");
  fs::permissions(dir / "a.txt", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(dir / "a.txt", dir / "link.txt");
  write_file(dir / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(dir / "link.txt"));
  EXPECT_EQ(read_bytes(dir / "a.txt"), "new");
  EXPECT_EQ(
      fs::status(dir / "a.txt").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const mode_t before = ::umask(022);
  write_file(dir / "b.txt", "x");
  ::umask(before);
  EXPECT_EQ(fs::status(dir / "b.txt").permissions(), fs::perms{0644}) << "as any other";
}

TEST(AtomicFile, names_the_file_that_cannot_be_written)
{
  const ScratchDir dir;
  expect_error([&] { write_file(dir / "none/a.txt", "x"); }, {"none/a.txt", "folder exist"});
  fs::create_directory(dir / "a.txt");
  expect_error([&] { write_file(dir / "a.txt", "x"); }, {"a.txt", "folder has this name"});
}

TEST(AtomicFile, replaces_no_pipe_or_device)
{
  const ScratchDir dir;
  ASSERT_EQ(::mkfifo((dir / "pipe").c_str(), 0600), 0);
  fs::create_symlink(dir / "pipe", dir / "link");
  for (const char* name : {"pipe", "link"})
    expect_error([&] { AtomicFile(dir / name).commit(); }, {"pipe", "device or a pipe"});
  EXPECT_TRUE(fs::is_fifo(dir / "pipe"));
  EXPECT_EQ(files_in(dir / ""), 2u);
}

TEST(WrittenFile, is_complete_only_with_all_of_its_bytes)
{
  const ScratchDir dir;
  {
    mrpt::io::CFileGZOutputStream file(dir / "a.gz");
    const std::string text = "what a full disk cuts off";
    file.Write(text.data(), text.size());
  }
  const std::string bytes = read_bytes(dir / "a.gz");
  EXPECT_NO_THROW(require_complete_packed(dir / "a.gz"));
  for (std::size_t size = 0; size < bytes.size(); ++size)
  {
    write_bytes(dir / "cut.gz", bytes.substr(0, size));
    EXPECT_THROW(require_complete_packed(dir / "cut.gz"), std::runtime_error) << size << " bytes";
  }
  expect_error([&] { require_complete_packed(dir / "cut.gz"); }, {"cut.gz", "disk full"});
  expect_error([&] { require_complete_packed(dir / "cut.gz", "shown"); }, {"shown", "disk full"});
}

TEST(Quantile, is_a_value_of_the_list_and_nan_without_one)
{
  EXPECT_EQ(quantile(std::vector<double>{4, 1, 3, 2}, 0.5), 2);
  EXPECT_EQ(quantile(std::vector<double>{4, 1, 3, 2}, 0.99), 4);
  EXPECT_EQ(quantile(std::vector<double>{4, 1, 3, 2}, 0.0), 1);
  EXPECT_TRUE(std::isnan(quantile(std::vector<double>{}, 0.5)));
}

TEST(TimingCsv, has_a_column_for_each_reason_and_stage_and_a_row_a_frame)
{
  std::istringstream text(timing_csv(two_frames()));
  std::string header, row, second, end;
  std::getline(text, header);
  std::getline(text, row);
  std::getline(text, second);
  EXPECT_FALSE(std::getline(text, end));
  EXPECT_EQ(
      header,
      "stamp_s,points_in,points_accepted,rejected_not_finite,rejected_range,rejected_height,"
      "rejected_body,rejected_outside,rejected_voxel,rejected_buried,accept_ms,roll_ms,update_ms,"
      "classify_ms,cleanup_ms,fill_ms,traversability_ms,total_ms");
  EXPECT_EQ(
      row,
      "1700000000.250000,100,90,0,0,10,0,0,0,0,0.5000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,"
      "2.0000");
}

TEST(SummaryJson, counts_frames_points_and_cells_and_lists_every_parameter)
{
  RunSummary run;
  run.log = "a.rawlog";
  run.frames = two_frames();
  run.skipped = {{"no_pose", 3}, {"undecodable", 1}};
  run.parameters.window_m = 20;
  LayerStack map;
  map.cells_x = map.cells_y = 2;
  map.resolution_m = 0.5;
  map.names = {"state"};
  map.layers = {{1, 1, 2, 0}};
  const auto j = nlohmann::json::parse(summary_json(run, map));
  EXPECT_EQ(j["frames"], 2);
  EXPECT_EQ(j["skipped"], 4);
  EXPECT_EQ(j["points"]["in"], 200);
  EXPECT_EQ(j["points"]["rejected"]["height"], 20);
  EXPECT_EQ(j["milliseconds"]["total"]["median"], 2.0);
  EXPECT_EQ(j["milliseconds"]["total"]["p99"], 4.0);
  EXPECT_EQ(j["coverage"]["measured"], 0.5);
  EXPECT_EQ(j["coverage"]["filled_two_sided"], 0.25);
  EXPECT_EQ(j["coverage"]["unknown"], 0.25);
  EXPECT_EQ(j["parameters"].size(), parameter_table().size());
  EXPECT_EQ(j["parameters"]["window_m"], 20.0);
  EXPECT_EQ(j["parameters"]["fill_samples"], 2);
}

TEST(SummaryJson, is_valid_even_when_a_name_is_not_utf8)
{
  RunSummary run;
  run.log = "caf\xe9.rawlog";
  EXPECT_TRUE(nlohmann::json::accept(summary_json(run, {})));
}
