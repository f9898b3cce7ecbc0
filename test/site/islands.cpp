// Tiles far from all others, where a pose jumped: they would make the file of a site enormous.
#include <gtest/gtest.h>
#include <talus/site/islands.h>
#include <talus/site/site_geotiff.h>

#include "log_files.h"
#include "sites.h"

using namespace talus::site;
using talus::test::cell_at;
using talus::test::measured;
using talus::test::ScratchDir;

namespace
{
constexpr double kResolution_m = 0.05, kTile_m = kResolution_m * kTileCells;

/** A way of so many tiles along x, from a tile on. */
void drive(Site& site, int first_tile, int tiles, int tile_y = 0)
{
  auto& way = site.ways.emplace_back();
  for (int i = first_tile; i < first_tile + tiles; ++i)
  {
    cell_at(site, std::int64_t{i} * kTileCells + 5, std::int64_t{tile_y} * kTileCells + 5) =
        measured(1, 1000);
    way.push_back(
        {static_cast<float>((i + 0.5) * kTile_m), static_cast<float>((tile_y + 0.5) * kTile_m), 0,
         0});
  }
}

class Islands : public testing::Test
{
 protected:
  ScratchDir dir_;
  Site site_{kResolution_m, std::size_t{64} << 20, dir_ / "tiles"};
};
}  // namespace

TEST_F(Islands, what_a_pose_that_jumped_has_left_is_found_and_left_out)
{
  drive(site_, -50, 100);
  drive(site_, 9000, 4, -9000);  // 58 km off in both directions
  const auto islands = far_islands(site_, 0);
  ASSERT_EQ(islands.size(), 1U);
  EXPECT_EQ(islands[0].tiles.size(), 4U);
  EXPECT_NEAR(islands[0].x_m, 9000 * kTile_m, 4 * kTile_m);
  EXPECT_NEAR(islands[0].y_m, -9000 * kTile_m, kTile_m);
  leave_out(islands[0], site_);
  EXPECT_EQ(site_.tiles.keys().size(), 100U);
  ASSERT_EQ(site_.ways.size(), 1U) << "the way there is gone";
  EXPECT_EQ(site_.ways[0].size(), 100U);
  EXPECT_TRUE(far_islands(site_, 0).empty());
  write_site(dir_ / "site.tif", site_, 0);
  EXPECT_LT(std::filesystem::file_size(dir_ / "site.tif"), 1'000'000U);
}

TEST_F(Islands, long_drives_and_sites_of_many_parts_stay_whole)
{
  drive(site_, 0, 400);
  for (int i = 0; i < 40; ++i) drive(site_, 400 + 250 * i, 4, 250 * i);  // gaps of 1.6 km
  EXPECT_TRUE(far_islands(site_, 0).empty());
}

TEST_F(Islands, two_places_that_were_both_driven_stay)
{
  drive(site_, 0, 60);
  drive(site_, 20000, 20, 20000);
  EXPECT_TRUE(far_islands(site_, 0).empty());
}

TEST_F(Islands, what_is_far_stays_where_the_file_is_not_enormous)
{
  drive(site_, 0, 100);
  drive(site_, 1000, 2);
  EXPECT_TRUE(far_islands(site_, 0).empty());
}

TEST_F(Islands, are_of_one_floor)
{
  drive(site_, -50, 100);
  drive(site_, 9000, 4, 9000);
  EXPECT_TRUE(far_islands(site_, 1).empty());
}
