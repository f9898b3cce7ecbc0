// What an index and a summary tell is held against the messages: an index orders, it never decides
// what is there.
#include "bag_log.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;

TEST(BagLies, WhatAnIndexHidesIsRead)
{
  MAKE_BAGS(
      "lie_index_zstd.mcap lie_index_lz4.mcap lose_index_zstd.mcap lose_index_lz4.mcap "
      "lost_index.db3");
  for (const std::string name :
       {"lie_index_zstd.mcap", "lie_index_lz4.mcap", "lose_index_zstd.mcap", "lose_index_lz4.mcap",
        "lost_index.db3"})
  {
    SCOPED_TRACE(name);
    expect_log(dir / name);
  }
}

TEST(BagLies, CountsAreHeldAgainstStatistics)
{
  MAKE_BAGS("lie_statistics.mcap lie_channel.mcap lost_chunk.mcap lost_message.mcap");
  const auto expect = [&](const std::string& name, const std::string& part)
  {
    const auto error = error_of(dir / name);
    EXPECT_TRUE(holds(error, name) && holds(error, part) && holds(error, "--partial")) << error;
  };
  expect("lie_statistics.mcap", "has 85 messages, and its Statistics count 86");
  expect("lie_channel.mcap", "has 10 messages of /imu, and its Statistics count 11");
  expect("lost_chunk.mcap", "has 7 chunks, and its Statistics count 8");
  expect("lost_message.mcap", "messages of /");
}

TEST(BagLies, ChecksumsOfDataAndSummaryAreChecked)
{
  MAKE_BAGS("flip_index.mcap flip_summary.mcap twice.mcap");
  const auto expect = [&](const std::string& name, const std::string& part)
  {
    const auto error = error_of(dir / name);
    EXPECT_TRUE(holds(error, name) && holds(error, part)) << error;
  };
  expect("flip_index.mcap", "the checksum of its data (DataEnd) does not agree");
  expect("flip_summary.mcap", "the checksum of its summary (Footer) does not agree");
  expect("twice.mcap", "goes on behind its end");
}

TEST(BagLies, WhatIsWhollyThereIsReadInPartWhereItsEndLies)
{
  MAKE_BAGS("lie_statistics.mcap flip_index.mcap flip_summary.mcap twice.mcap");
  SourceOptions options;
  options.partial = true;
  for (const std::string name :
       {"lie_statistics.mcap", "flip_index.mcap", "flip_summary.mcap", "twice.mcap"})
  {
    EXPECT_EQ(scans_of(dir / name, "/front/points", options).size(), 10u) << name;
    EXPECT_TRUE(holds(remarks_of(dir / name, options), "read in part")) << name;
  }
}
