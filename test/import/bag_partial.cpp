// Bags that are cut: refused, with the switch that reads what is before the cut.
#include <algorithm>

#include "bag_log.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;

namespace
{
SourceOptions in_part()
{
  SourceOptions options;
  options.partial = true;
  return options;
}

/** The scans of /front/points in a bag that ends after so many twentieths; none where nothing can
 * be read. */
std::size_t scans_before(const std::string& path, const std::string& whole, std::size_t twentieths)
{
  std::ofstream(path, std::ios::binary) << whole.substr(0, whole.size() * twentieths / 20);
  EXPECT_TRUE(holds(error_of(path), "--partial") || twentieths < 3) << error_of(path);
  if (!error_of(path, in_part()).empty()) return 0;
  const auto scans = scans_of(path, "/front/points", in_part());
  for (std::size_t i = 0; i < scans.size(); ++i)
    EXPECT_EQ(scans[i].x_m.at(1), static_cast<float>(i) + 0.25F);
  return scans.size();
}

/** The same of many_scans() of odd_bags.py, all points of which are there. */
std::size_t many_scans_before(const std::string& path, const std::string& whole, std::size_t bytes)
{
  std::ofstream(path, std::ios::binary) << whole.substr(0, bytes);
  const auto scans = scans_of(path, "/front/points", in_part());
  for (std::size_t i = 0; i < scans.size(); ++i)
    for (const float x_m : scans[i].x_m) EXPECT_EQ(x_m, static_cast<float>(i)) << bytes;
  return scans.size();
}
}  // namespace

class BagPartial : public testing::TestWithParam<const char*>
{
};

TEST_P(BagPartial, WhatIsBeforeTheCutIsReadAndItIsSaid)
{
  const std::string name = GetParam();
  MAKE_BAGS(name);
  const auto whole = read_bytes(dir / name);
  std::size_t before = 0;
  for (std::size_t twentieths = 1; twentieths < 20; ++twentieths)
  {
    const auto scans = scans_before(dir / name, whole, twentieths);
    EXPECT_GE(scans, before) << twentieths;
    EXPECT_GE(scans + 4, twentieths / 2) << twentieths;  // a chunk has up to three of them
    before = scans;
  }
  EXPECT_GE(before, 9u);
  const auto remarks = remarks_of(dir / name, in_part());
  EXPECT_TRUE(holds(remarks, name + ": ") && holds(remarks, " cut")) << remarks;
}

INSTANTIATE_TEST_SUITE_P(
    All, BagPartial,
    testing::Values(
        "log.db3", "none.mcap", "zstd.mcap", "lz4.mcap", "loose.mcap", "no_summary.mcap"));

TEST(BagPartial, AChunkThatIsCutGivesWhatComesOutOfIt)
{
  MAKE_BAGS("one_chunk_zstd.mcap one_chunk_lz4.mcap one_chunk.mcap");
  for (const std::string name : {"one_chunk_zstd.mcap", "one_chunk_lz4.mcap", "one_chunk.mcap"})
  {
    const auto whole = read_bytes(dir / name);
    std::ofstream(dir / name, std::ios::binary) << whole.substr(0, whole.size() / 2);
    const auto scans = scans_of(dir / name, "/front/points", in_part()).size();
    EXPECT_TRUE(scans >= 30 && scans < 190) << name << ": " << scans;
  }
}

TEST(BagPartial, MessagesBeforeTheCutAreReadWhereThePagesThatLeadToThemAreBehindIt)
{
  MAKE_BAGS("deep.db3");
  const auto whole = read_bytes(dir / "deep.db3");
  for (const std::size_t twentieth : {2, 4, 10, 18})
  {
    const auto scans = many_scans_before(dir / "deep.db3", whole, whole.size() * twentieth / 20);
    EXPECT_TRUE(scans + 8 >= 10 * twentieth && scans <= 10 * twentieth) << scans;
  }
}

TEST(BagPartial, AMessageThatEndsInThePageThatIsCutIsLeftOut)
{
  MAKE_BAGS("wide.db3");
  const auto whole = read_bytes(dir / "wide.db3");
  const std::size_t half = whole.size() / 2;
  for (std::size_t cut = half; cut < half + 3000; cut += 100)
    EXPECT_GT(many_scans_before(dir / "wide.db3", whole, cut), 85u) << cut;
}

TEST(BagPartial, AChunkThatIsDamagedIsLeftOutAndToldAlone)
{
  MAKE_BAGS("zstd.mcap");
  auto bytes = read_bytes(dir / "zstd.mcap");
  bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 0x55);
  std::ofstream(dir / "zstd.mcap", std::ios::binary) << bytes;
  EXPECT_TRUE(holds(error_of(dir / "zstd.mcap"), "--partial"));
  const auto scans = scans_of(dir / "zstd.mcap", "/front/points", in_part()).size();
  EXPECT_TRUE(scans >= 7 && scans < 10) << scans;
  EXPECT_TRUE(holds(remarks_of(dir / "zstd.mcap", in_part()), "left out is the chunk at byte"));
}

TEST(BagPartial, AWholeBagIsReadWhole)
{
  MAKE_BAGS("log.db3 zstd.mcap wal_killed.db3 journal.db3 parts");
  for (const std::string name : {"log.db3", "zstd.mcap", "wal_killed.db3", "journal.db3", "parts"})
  {
    SCOPED_TRACE(name);
    expect_log(dir / name, {}, in_part());
  }
}

TEST(BagPartial, OfAFolderOnePartMayBeCut)
{
  MAKE_BAGS("parts_without_metadata");
  const auto part = (dir / "parts_without_metadata") + "/part_4.db3";
  const auto whole = read_bytes(part);
  std::ofstream(part, std::ios::binary) << whole.substr(0, whole.size() * 2 / 3);
  EXPECT_TRUE(holds(error_of(dir / "parts_without_metadata"), "part_4.db3: is cut"));
  const auto scans = scans_of(dir / "parts_without_metadata", "/front/points", in_part()).size();
  EXPECT_TRUE(scans == 8 || scans == 9 || scans == 10) << scans;
  EXPECT_TRUE(holds(remarks_of(dir / "parts_without_metadata", in_part()), "part_4.db3: is cut"));
}
