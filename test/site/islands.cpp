// Tiles far from all others, where a pose jumped or a drive went on: one file of all would be
// enormous.
#include <gtest/gtest.h>
#include <talus/site/islands.h>
#include <talus/site/merge.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <filesystem>

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

TEST_F(Islands, what_a_pose_that_jumped_has_left_gets_a_file_of_its_own)
{
  drive(site_, -10, 20);
  drive(site_, 9000, 4, -9000);  // 58 km off in both directions
  const auto islands = islands_of(site_, 0);
  ASSERT_EQ(islands.size(), 2U);
  EXPECT_EQ(islands[0].tiles.size(), 20U) << "the largest is the first";
  EXPECT_EQ(islands[1].tiles.size(), 4U);
  EXPECT_NEAR(islands[1].x_m, 9000 * kTile_m, 4 * kTile_m);
  EXPECT_NEAR(islands[1].y_m, -9000 * kTile_m, kTile_m);
  write_site_files(dir_ / "site.tif", dir_ / "site.png", site_);
  EXPECT_LT(std::filesystem::file_size(dir_ / "site.tif"), 1'000'000U);
  EXPECT_TRUE(std::filesystem::exists(dir_ / "site_island_1.png"));
  EXPECT_FALSE(std::filesystem::exists(dir_ / "site_island_2.tif"));
  EXPECT_EQ(info_of_site(dir_ / "site.tif").islands, 1U);
  EXPECT_EQ(info_of_site(dir_ / "site_island_1.tif").islands, 0U);
}

TEST_F(Islands, come_back_with_the_same_bits_and_with_their_ways)
{
  drive(site_, 0, 12);
  drive(site_, 200000, 8, 200000);
  drive(site_, -100, 5, 70000);
  site_.ways = {site_.ways[0], site_.ways[1]};
  site_.ways[0].insert(site_.ways[0].end(), site_.ways[1].begin(), site_.ways[1].end());
  site_.ways.resize(1);  // one way through two of them
  write_site_files(dir_ / "site.tif", "", site_);
  Site back(kResolution_m, std::size_t{64} << 20, dir_ / "back");
  read_site_files(dir_ / "site.tif", back);
  EXPECT_EQ(talus::test::different_cells(site_, back), 0);
  ASSERT_EQ(back.ways.size(), 2U) << "the jump is no way";
  EXPECT_EQ(back.ways[0].size() + back.ways[1].size(), 20U);
  std::filesystem::remove(dir_ / "site_island_2.tif");
  Site none(kResolution_m, std::size_t{64} << 20, dir_ / "none");
  talus::test::expect_error(
      [&] { read_site_files(dir_ / "site.tif", none); },
      {"site_island_2.tif: no such file", "first of 3 islands"});
  EXPECT_TRUE(none.tiles.keys().empty());
}

TEST_F(Islands, belong_to_their_floor)
{
  drive(site_, 0, 30);
  drive(site_, 90000, 4, 90000);
  for (const int x : {0, 90000}) cell_at(site_, std::int64_t{x} * kTileCells, 0, 2) = measured(9);
  cell_at(site_, 1, 1, 1) = measured(4);
  write_site_files(dir_ / "site.tif", dir_ / "site.png", site_);
  for (const char* name :
       {"site_island_1.tif", "site_floor_1.tif", "site_floor_2.tif", "site_floor_2_island_1.tif"})
    EXPECT_TRUE(std::filesystem::exists(dir_ / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(dir_ / "site_floor_1_island_1.tif"));
  Site back(kResolution_m, std::size_t{64} << 20, dir_ / "back");
  read_site_files(dir_ / "site.tif", back);
  EXPECT_EQ(talus::test::different_cells(site_, back), 0);
}

TEST_F(Islands, and_floors_are_merged_with_what_they_belong_to)
{
  drive(site_, 0, 30);
  drive(site_, 90000, 4, 90000);
  cell_at(site_, 1, 1, 3) = measured(4);
  write_site_files(dir_ / "site.tif", "", site_);
  Site other(kResolution_m, std::size_t{64} << 20, dir_ / "other");
  drive(other, 20, 30);
  write_site_files(dir_ / "other.tif", "", other);
  Site merged(kResolution_m, std::size_t{64} << 20, dir_ / "merged");
  merge_sites({dir_ / "other.tif", dir_ / "site.tif"}, merged, 0);
  EXPECT_EQ(merged.ways.size(), 3U);
  write_site_files(dir_ / "all.tif", "", merged);
  EXPECT_EQ(info_of_site(dir_ / "all.tif").floors, (std::vector<int>{0, 3}));
  EXPECT_EQ(info_of_site(dir_ / "all.tif").islands, 1U);
}

TEST_F(Islands, are_none_of_long_drives_of_what_one_file_takes_and_of_unknown_tiles)
{
  for (int i = 0; i < 250; ++i) drive(site_, i, 1, i);  // 1.6 km in both directions
  EXPECT_TRUE(islands_of(site_, 0).empty());
  Site far(kResolution_m, std::size_t{64} << 20, dir_ / "far");
  drive(far, 0, 50);
  drive(far, 1000, 2);
  drive(far, 1000, 2, 4);
  EXPECT_TRUE(islands_of(far, 0).empty());
  Site small(kResolution_m, std::size_t{64} << 20, dir_ / "small");
  drive(small, 0, 1);
  small.tiles.at({0, 90000, 90000});
  EXPECT_EQ(islands_of(small, 0).size(), 1U);
  write_site_files(dir_ / "site.tif", "", small);
  EXPECT_EQ(info_of_site(dir_ / "site.tif").islands, 0U);
}

TEST_F(Islands, many_parts_that_are_not_so_far_from_each_other_are_divided_too)
{
  for (int i = 0; i < 20; ++i) drive(site_, 250 * i, 4, 250 * i);  // gaps of 1.6 km
  EXPECT_GT(islands_of(site_, 0).size(), 5U);
}
