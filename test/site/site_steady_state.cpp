#include <gtest/gtest.h>
#include <talus/site/site_mapper.h>
#include "count_allocations.h"
#include "scene.h"

// A drive that is kept needs the heap where it comes to new ground only.

using namespace talus;
using namespace talus::test;

namespace
{
constexpr int kPlaces = 150;

/** Scans along 30 m. */
std::vector<Scan> scans()
{
  std::vector<Scan> all;
  all.reserve(kPlaces);
  for (int i = 0; i < kPlaces; i++)
    all.emplace_back(0.2 * i, 0.05 * (i % 7), 0.7).cast({}, 180, -0.6, 0.1, 16);
  return all;
}
}  // namespace

TEST(SteadyState, ADriveOverGroundThatIsKeptAllocatesNothing)
{
  const std::vector<Scan> drive = scans();
  site::Site site(0.05, std::size_t{64} << 20, testing::TempDir());
  site::SiteMapper mapper(site);
  site.ways.back().reserve(1000);
  ElevationMapper map({}, Backend::Cpu, 1);
  const auto to_and_fro = [&]
  {
    for (int i = 0; i < 2 * kPlaces; i++)
      mapper.update(
          map, drive[static_cast<std::size_t>(i < kPlaces ? i : 2 * kPlaces - 1 - i)].frame(i));
  };
  constexpr int kUntilMostScansAreKept = 6;  // which tell of traffic
  for (int i = 0; i < kUntilMostScansAreKept; i++) to_and_fro();
  const std::uint64_t before = allocations;
  to_and_fro();
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_GT(site.tiles.keys().size(), 10u);
}
