// Bags as they lie on a disk: recorders that were killed, databases that others hold, folders that
// nobody may write, parts without a description. They are read, and nothing is left beside them.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bag_log.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;
namespace fs = std::filesystem;

namespace
{
/** Names, sizes and times of change of all in a folder. */
std::string state_of(const std::string& folder)
{
  std::set<std::string> lines;
  for (const auto& entry : fs::directory_iterator(folder))
    lines.insert(
        entry.path().string() + " " + std::to_string(entry.file_size()) + " " +
        std::to_string(entry.last_write_time().time_since_epoch().count()));
  std::string all;
  for (const auto& line : lines) all += line + "\n";
  return all;
}

/** Holds a lock on all of a file, in another process, as a recorder does that writes. */
class LockOfAnother
{
 public:
  explicit LockOfAnother(const std::string& path)
  {
    int ready[2] = {-1, -1};
    if (pipe(ready) != 0) return;
    child_ = fork();
    if (child_ == 0)
    {
      struct flock all
      {
      };
      all.l_type = F_WRLCK;
      const int file = open(path.c_str(), O_RDWR);
      const char is_locked = fcntl(file, F_SETLK, &all) == 0 ? '1' : '0';
      if (write(ready[1], &is_locked, 1) == 1) pause();
      _exit(0);
    }
    char is_locked = '0';
    is_locked_ = read(ready[0], &is_locked, 1) == 1 && is_locked == '1';
    close(ready[0]);
    close(ready[1]);
  }
  ~LockOfAnother()
  {
    if (child_ <= 0) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  bool is_locked() const { return is_locked_; }

 private:
  pid_t child_ = -1;
  bool is_locked_ = false;
};
}  // namespace

TEST(BagDisk, WhatAKilledRecorderLeftInItsWalOrJournalIsReadAndTheFolderIsAsBefore)
{
  MAKE_BAGS("wal_killed.db3 wal_closed.db3 journal.db3");
  const auto before = state_of(dir / "");
  for (const std::string name : {"wal_killed.db3", "wal_closed.db3", "journal.db3"})
  {
    SCOPED_TRACE(name);
    expect_log(dir / name);
    EXPECT_EQ(state_of(dir / ""), before);
  }
}

TEST(BagDisk, AFolderThatNobodyMayWriteIsRead)
{
  MAKE_BAGS("wal_killed.db3 wal_closed.db3 journal.db3 zstd.mcap");
  for (const auto& entry : fs::directory_iterator(dir / ""))
    fs::permissions(entry.path(), fs::perms::owner_read);
  fs::permissions(dir / "", fs::perms::owner_read | fs::perms::owner_exec);
  for (const std::string name : {"wal_killed.db3", "wal_closed.db3", "journal.db3", "zstd.mcap"})
  {
    SCOPED_TRACE(name);
    expect_log(dir / name);
  }
  fs::permissions(dir / "", fs::perms::owner_all);
}

TEST(BagDisk, ADatabaseThatAnotherHoldsLockedIsRead)
{
  MAKE_BAGS("log.db3 wal_killed.db3 journal.db3");
  for (const std::string name : {"log.db3", "wal_killed.db3", "journal.db3"})
  {
    SCOPED_TRACE(name);
    const LockOfAnother lock(dir / name);
    ASSERT_TRUE(lock.is_locked());
    expect_log(dir / name);
  }
}

TEST(BagDisk, ADatabaseThatIsWrittenMeanwhileIsRefused)
{
  MAKE_BAGS("log.db3");
  const auto source = open_bag_source({dir / "log.db3"}, {});
  std::ofstream(dir / "log.db3-wal") << "the first of what comes";
  expect_error([&] { all_of(*source); }, {"log.db3: was changed while it was read"});
}

TEST(BagDisk, AWalThatIsCutIsToldOf)
{
  MAKE_BAGS("wal_killed.db3");
  EXPECT_FALSE(holds(remarks_of(dir / "wal_killed.db3"), "-wal"));
  std::ofstream(dir / "wal_killed.db3-wal", std::ios::app) << "the head of a frame";
  expect_log(
      dir / "wal_killed.db3",
      {(dir / "wal_killed.db3-wal") + ": is cut: of what it has, the whole transactions are read"});
}

TEST(BagDisk, ACopyWithoutItsWalSaysWhatIsMissing)
{
  MAKE_BAGS("wal_lost.db3 wal_lost_early.db3");
  for (const std::string name : {"wal_lost.db3", "wal_lost_early.db3"})
  {
    const auto error = error_of(dir / name);
    EXPECT_TRUE(holds(error, name + "-wal, which is not beside it")) << error;
  }
}

TEST(BagDisk, PartsWithoutADescriptionAreOneBagInTheOrderOfRecording)
{
  MAKE_BAGS(
      "parts_without_metadata split_names_lie split_empty_metadata split_bad_metadata "
      "two_recorders");
  const auto one_bag = [&](const std::string& name, const std::string& why, int files)
  {
    SCOPED_TRACE(name);
    expect_log(
        dir / name, {(dir / name) + ": " + why + ": its " + std::to_string(files) +
                     " files are read as one bag, in the order of recording"});
  };
  one_bag("parts_without_metadata", "has no metadata.yaml", 13);
  one_bag("split_names_lie", "has no metadata.yaml", 5);
  one_bag("split_empty_metadata", "its metadata.yaml is empty", 5);
  one_bag("split_bad_metadata", "its metadata.yaml names no files", 5);
  one_bag("two_recorders", "has no metadata.yaml", 2);
}

TEST(BagDisk, MessagesThatTheDescriptionTellsOfAndThatAreNotThereAreTold)
{
  MAKE_BAGS("parts_with_loss");
  const auto remarks = remarks_of(dir / "parts_with_loss");
  for (const char* part :
       {"/front/points: the messages that are there are 10, those that metadata.yaml counts 13",
        "/tf_static: the messages that are there are 1, those that metadata.yaml counts 4"})
    EXPECT_TRUE(holds(remarks, part)) << remarks;
}

TEST(BagDisk, PartsThatAreNamedOneByOneAreOneBag)
{
  MAKE_BAGS("parts_without_metadata");
  std::vector<std::string> parts;
  for (int i = 0; i < 13; ++i)
    parts.push_back((dir / "parts_without_metadata/part_") + std::to_string(i) + ".db3");
  parts.push_back(parts.front());  // twice is once
  const auto source = open_bag_source(parts, {});
  EXPECT_EQ(all_of(*source).size(), 20u);
  EXPECT_EQ(source->poses().entries().size(), 21u);
  EXPECT_EQ(source->remarks().size(), 1u);
}

TEST(BagDisk, APartAloneTellsThatThereAreMore)
{
  MAKE_BAGS("parts_without_metadata");
  const auto remarks = remarks_of(dir / "parts_without_metadata/part_3.db3");
  EXPECT_TRUE(holds(remarks, "part_3.db3: is one of 13 parts of a bag; its folder reads them all"))
      << remarks;
}

TEST(BagDisk, APartThatIsEmptyIsLeftOut)
{
  MAKE_BAGS("split_names_lie");
  std::ofstream empty(dir / "split_names_lie/last.db3");
  EXPECT_EQ(scans_of(dir / "split_names_lie", "/front/points").size(), 10u);
  const auto remarks = remarks_of(dir / "split_names_lie");
  EXPECT_TRUE(holds(remarks, "left out, as they are empty: last.db3")) << remarks;
}

TEST(BagDisk, ATopicThatTwoFilesHaveAtTheSameTimeIsRefused)
{
  MAKE_BAGS("log.db3 zstd.mcap");
  const auto both = inputs_of({dir / "log.db3", dir / "zstd.mcap"}).front();
  expect_error(
      [&] { all_of(*open_scan_source(both, {})); }, {"log.db3", "zstd.mcap", "/front/points"});
}

TEST(BagDisk, TheDescriptionMayBeNamedItself)
{
  MAKE_BAGS("parts");
  const auto source = open_scan_source(Input(dir / "parts/metadata.yaml"), {});
  EXPECT_EQ(all_of(*source).size(), 20u);
}

TEST(BagDisk, PartsThatTheDescriptionDoesNotNameAreTold)
{
  MAKE_BAGS("split_metadata_ends");
  const auto remarks = remarks_of(dir / "split_metadata_ends");
  EXPECT_TRUE(holds(remarks, "does not name them: part_2.db3, part_3.db3, part_4.db3")) << remarks;
}

TEST(BagDisk, TheDescriptionNamesNoFilesElsewhereAndIsNotEndless)
{
  MAKE_BAGS("log.db3");
  std::filesystem::create_directory(dir / "bag");
  const std::string begin = "rosbag2_bagfile_information:\n  relative_file_paths: [";
  for (const std::string& name :
       {std::string("../log.db3"), dir / "log.db3", std::string("x/../../log.db3")})
  {
    write_bytes(dir / "bag/metadata.yaml", begin + name + "]\n");
    EXPECT_TRUE(holds(error_of(dir / "bag"), "bag/log.db3")) << error_of(dir / "bag");
  }
  write_bytes(dir / "bag/metadata.yaml", begin + "]\n" + std::string(5 << 20, '#') + "\n");
  EXPECT_TRUE(holds(error_of(dir / "bag"), "metadata.yaml")) << error_of(dir / "bag");
}

TEST(BagDisk, AFolderWithScansAndABagIsRefused)
{
  MAKE_BAGS("log.db3");
  std::ofstream(dir / "1.pcd") << "VERSION 0.7\n";
  expect_error([&] { open_scan_source(Input(dir / ""), {}); }, {"scans of several kinds"});
}
