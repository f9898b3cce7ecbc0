// Bags that were cut, or changed byte by byte: refused with a message, or read; nothing else.
#include "bags.h"

#include <cmath>
#include <random>

#include "formats.h"

using namespace talus;
using namespace talus::import;
using namespace talus::test;

namespace
{
/** Whether it was read; what was is as promised. */
bool is_read(const std::string& path, bool partial = false)
{
  try
  {
    SourceOptions options;
    options.partial = partial;
    const auto source = open_bag_source({path}, options);
    for (const auto& scan : all_of(*source))
      for (std::size_t i = 0; i < scan.x_m.size(); ++i)
        EXPECT_TRUE(std::isfinite(scan.x_m[i]) && std::isfinite(scan.y_m.at(i)));
    source->poses();
    return true;
  }
  catch (const std::runtime_error& e)
  {
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    return false;
  }
}

std::string changed(std::string bytes, std::mt19937& random)
{
  for (std::uint32_t n = 1 + random() % 4; n > 0; --n)
  {
    const char values[] = {0, 1, static_cast<char>(0xff), static_cast<char>(random())};
    for (std::size_t at = random() % bytes.size(), length = 1 + random() % 8; length > 0; --length)
      bytes[std::min(at++, bytes.size() - 1)] = values[random() % 4];
  }
  return bytes;
}

const char* const kBags[] = {
    "log.db3", "none.mcap", "zstd.mcap", "lz4.mcap", "loose_no_summary.mcap"};
}  // namespace

TEST(BagDamaged, WhatIsCutShortIsRefused)
{
  if (const auto why = why_no_bags(); !why.empty()) GTEST_SKIP() << why;
  const ScratchDir dir;
  for (const std::string name : kBags)
  {
    ASSERT_TRUE(make_bags(dir, name));
    const auto whole = read_bytes(dir / name);
    for (std::size_t cut = 1; cut < 40; ++cut)
    {
      write_bytes(dir / name, whole.substr(0, whole.size() * cut / 40));
      EXPECT_FALSE(is_read(dir / name)) << name << " cut at " << cut << "/40";
    }
    std::filesystem::remove(dir / name);
  }
}

TEST(BagDamaged, ChangedBytesAreRefusedOrRead)
{
  if (const auto why = why_no_bags(); !why.empty()) GTEST_SKIP() << why;
  const ScratchDir dir;
  std::mt19937 random(20240607);
  int read = 0, refused = 0, in_part = 0;
  for (const std::string name : kBags)
  {
    ASSERT_TRUE(make_bags(dir, name));
    const auto whole = read_bytes(dir / name);
    for (int round = 0; round < 200; ++round)
    {
      write_bytes(dir / name, changed(whole, random));
      const bool is_whole = is_read(dir / name);
      (is_whole ? read : refused)++;
      if (is_read(dir / name, true) && !is_whole) ++in_part;
    }
    std::filesystem::remove(dir / name);
  }
  EXPECT_GT(read, 50);  // else nothing behind the first check was looked at
  EXPECT_GT(refused, 50);
  EXPECT_GT(in_part, 50);
}

TEST(BagDamaged, ChangedBytesInAWalOrAJournalAreRefusedOrRead)
{
  MAKE_BAGS("wal_killed.db3 journal.db3");
  std::mt19937 random(20240608);
  int read = 0;
  for (const std::string name : {"wal_killed.db3", "journal.db3"})
  {
    const auto log = (dir / name) + (name == "journal.db3" ? "-journal" : "-wal");
    const auto whole = read_bytes(log);
    for (int round = 0; round < 100; ++round)
    {
      write_bytes(log, changed(whole, random));
      for (const bool partial : {false, true}) read += is_read(dir / name, partial) ? 1 : 0;
    }
  }
  EXPECT_GT(read, 20);
}

TEST(BagDamaged, WhatIsMadeToTakeForeverOrAllMemoryIsRefused)
{
  if (const auto why = why_no_bags(); !why.empty()) GTEST_SKIP() << why;
  const ScratchDir dir;
  for (const std::string name :
       {"endless_view.db3", "generated.db3", "bomb.mcap", "large_claim.mcap"})
  {
    ASSERT_TRUE(make_bags(dir, name));
    EXPECT_FALSE(is_read(dir / name)) << name;
  }
}
