// What the logs of a batch of talus-map share when several are mapped at once.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "apps/common/memory_limit.h"
#include "apps/talus-map/job.h"
#include "sanitizer.h"

using namespace talus::app;

namespace
{
constexpr int kCores = 16;

Sharing of(const Options& options, int threads, std::size_t logs, int devices = 0)
{
  Settings settings;
  settings.threads = threads;
  return share(options, settings, logs, kCores, devices);
}
}  // namespace

TEST(Sharing, one_log_has_everything)
{
  const Sharing s = of({}, 0, 1);
  EXPECT_EQ(s.at_once, 1U);
  EXPECT_EQ(s.threads, 0) << "all cores";
  EXPECT_EQ(s.memory_mb, 512);
}

TEST(Sharing, cores_over_threads_and_enough_memory_say_how_many_by_themselves)
{
  EXPECT_EQ(of({}, 4, 100).at_once, 4U);
  EXPECT_EQ(of({}, 4, 3).at_once, 3U);
  EXPECT_EQ(of({}, 64, 100).at_once, 1U);
  const Sharing all = of({}, 0, 100);
  EXPECT_EQ(all.at_once, 8U) << "64 MB each";
  EXPECT_EQ(all.threads, 2);
  Options without_site;
  without_site.has_site = false;
  EXPECT_EQ(of(without_site, 0, 100).at_once, 16U);
  EXPECT_EQ(of(without_site, 0, 100, 2).at_once, 4U) << "two for each device";
}

TEST(Sharing, jobs_that_are_asked_for_get_equal_parts)
{
  Options options;
  options.jobs = 32;
  options.memory_mb = 640;
  const Sharing s = of(options, 0, 100, 1);
  EXPECT_EQ(s.at_once, 32U);
  EXPECT_EQ(s.threads, 1);
  EXPECT_EQ(s.memory_mb, 20);
  EXPECT_EQ(of(options, 3, 5).at_once, 5U);
  EXPECT_EQ(of(options, 3, 5).threads, 3) << "as asked for";
  EXPECT_EQ(of(options, 3, 5).memory_mb, 128);
}

TEST(Sharing, reading_a_log_takes_what_its_bytes_can_hold_and_a_part_of_100_mb)
{
  TALUS_SKIP_UNDER_SANITIZER("it takes memory of its own");
  constexpr std::size_t kMegabyte = 1U << 20, kSize = 5000;
  const std::string plain = testing::TempDir() + "/talus_sharing.rawlog";
  std::ofstream(plain, std::ios::binary) << std::string(kSize, 'x');
  EXPECT_EQ(memory_for_log(plain), 100 * kMegabyte + 64 * kSize);
  share_log_memory(4);
  EXPECT_EQ(memory_for_log(plain), 25 * kMegabyte + 64 * kSize);
  share_log_memory(1000);
  EXPECT_EQ(memory_for_log(plain), 8 * kMegabyte + 64 * kSize) << "the least that works";
  share_log_memory(1);
  std::ofstream(plain, std::ios::binary) << "\x1f\x8b" << std::string(kSize - 2, 'x');
  EXPECT_EQ(memory_for_log(plain), 100 * kMegabyte + 64 * 250 * kSize);
  std::ofstream(plain, std::ios::binary | std::ios::app) << std::string(kMegabyte, 'x');
  EXPECT_EQ(memory_for_log(plain), 2048 * kMegabyte);
  std::remove(plain.c_str());
}
