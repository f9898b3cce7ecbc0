// What the logs of a batch of talus-map share when several are mapped at once.
#include <gtest/gtest.h>

#include "apps/talus-map/job.h"

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
