// The tiles of a site: as many in memory as the budget allows, the others on disk.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <talus/site/tile_store.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <string_view>

#include "log_files.h"

namespace fs = std::filesystem;
using talus::test::expect_error;
using talus::test::ScratchDir;
using talus::test::write_bytes;

using namespace talus;
using namespace talus::site;

namespace
{
constexpr std::size_t kEight = 8 * sizeof(Tile);

/** Another one for each key, with unknown cells, NaN and numbers of all kinds. */
void fill(Tile& tile, const TileKey& key)
{
  for (std::size_t i = 0; i < tile.cells.size(); ++i)
  {
    if (i % 3 == 0) continue;
    SiteCell& c = tile.cells[i];
    c.cell.ground_m = static_cast<float>(key.x) + 0.001f * static_cast<float>(i);
    c.cell.ground_variance_m2 = 1e-4f;
    if (i % 2) c.cell.elevation_m = static_cast<float>(key.y);
    c.cell.state = static_cast<std::uint8_t>(1 + i % 3);
    c.cell.evidence[0] = static_cast<std::uint8_t>(i % 200);
    c.cell.evidence[CellRecord::kEvidenceBytes - 1] = static_cast<std::uint8_t>(i);
    c.seen_s = static_cast<std::uint32_t>(4000000000U + i);
  }
}

template <class T>
std::string_view bytes_in(const T& what)
{
  return {reinterpret_cast<const char*>(&what), sizeof what};
}

void expect_filled(const Tile* tile, const TileKey& key)
{
  ASSERT_NE(tile, nullptr);
  static Tile expected;
  expected = Tile{};
  fill(expected, key);
  EXPECT_TRUE(bytes_in(*tile) == bytes_in(expected)) << "not " << key.x << " " << key.y;
}

class Tiles : public testing::Test
{
 protected:
  ScratchDir dir;
};

TileKey nth(int i) { return {i % 3, i / 5 - 4, i % 5 - 2}; }

/** So many tiles, which are too many for the store. */
void fill(TileStore& store, int tiles)
{
  for (int i = 0; i < tiles; ++i) fill(store.at(nth(i)), nth(i));
}

std::vector<fs::path> files_below(const std::string& folder)
{
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}
}  // namespace

TEST_F(Tiles, keeps_no_more_tiles_in_memory_than_the_budget_and_the_others_on_disk)
{
  TileStore store(kEight, dir / "");
  fill(store, 8);
  EXPECT_EQ(store.tiles_in_memory(), 8u);
  EXPECT_TRUE(files_below(dir / "").empty()) << "nothing is written before it must";
  for (int i = 8; i < 40; ++i)
  {
    fill(store.at(nth(i)), nth(i));
    EXPECT_EQ(store.tiles_in_memory(), 8u);
  }
  EXPECT_EQ(files_below(dir / "").size(), 32u);
  const auto keys = store.keys();
  EXPECT_EQ(keys.size(), 40u);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end())) << "by floor, then row by row";
}

TEST_F(Tiles, gives_back_what_was_on_disk_byte_for_byte)
{
  TileStore store(0, dir / "");
  fill(store, 40);
  EXPECT_EQ(store.tiles_in_memory(), TileStore::kMinInMemory);
  for (const int i : {0, 39, 7, 7, 21, 0}) expect_filled(store.find(nth(i)), nth(i));
  store.at(nth(3)).cells[5].cell.ground_m = 42;
  for (int i = 10; i < 30; ++i) expect_filled(store.find(nth(i)), nth(i));
  EXPECT_EQ(store.find(nth(3))->cells[5].cell.ground_m, 42) << "a change of what had been on disk";
  EXPECT_EQ(store.find({7, 7, 7}), nullptr);
}

TEST_F(Tiles, gives_back_what_was_packed_byte_for_byte)
{
  TileStore store(kEight, dir / "");
  fill(store, 40);
  store.at({9, 0, 0});  // of unknown cells
  for (int i = 30; i < 40; ++i) store.pack(nth(i));
  store.pack({9, 0, 0});
  store.pack({7, 7, 7});
  for (const int i : {39, 38, 38, 39, 2, 31}) expect_filled(store.find(nth(i)), nth(i));
  expect_filled(&store.at(nth(38)), nth(38));
  store.at(nth(39)).cells[5].cell.ground_m = -0.0F;
  EXPECT_EQ(store.find(nth(39))->cells[5].cell.ground_m, 0);
  store.pack(nth(39));
  EXPECT_TRUE(std::signbit(store.find(nth(39))->cells[5].cell.ground_m));
  EXPECT_TRUE(bytes_in(*store.find({9, 0, 0})) == bytes_in(Tile()));
  for (int i = 0; i < 39; ++i) expect_filled(store.find(nth(i)), nth(i));
}

TEST_F(Tiles, gives_back_values_of_channels_byte_for_byte_packed_or_on_disk)
{
  ChannelStore store(kEight, dir / "");
  const auto value = [](std::size_t i, int tile, std::size_t layer)
  {
    const auto n = static_cast<float>(i % 250 + static_cast<std::size_t>(tile));
    if (layer == 0) return i % 3 == 0 ? std::nanf("") : 0.37F * n;
    if (layer == 3) return static_cast<float>(i % 16);
    return layer == 4 ? (i % 2 ? -0.0F : -1e7F) : std::nanf("");
  };
  const auto fill_values = [&](ChannelTile& tile, int t)
  {
    for (std::size_t i = 0; i < tile.cells.size(); ++i)
      for (std::size_t l = 0; l < 8; ++l) tile.cells[i].values[l] = value(i, t, l);
  };
  for (int t = 0; t < 40; ++t)
  {
    fill_values(store.at(nth(t)), t);
    if (t % 2) store.pack(nth(t));
  }
  static ChannelTile expected;
  for (int t = 0; t < 40; ++t)
  {
    fill_values(expected, t);
    EXPECT_TRUE(bytes_in(*store.find(nth(t))) == bytes_in(expected)) << t;
  }
  EXPECT_FALSE(files_below(dir / "").empty()) << "some are on disk";
}

TEST_F(Tiles, packs_classes_in_a_hundredth_of_their_memory)
{
  ChannelStore store(kEight, dir / "");
  ChannelTile& tile = store.at(nth(0));
  for (std::size_t i = 0; i < tile.cells.size(); ++i)
    tile.cells[i].values[0] = static_cast<float>(i / 1000 % 16);
  store.pack(nth(0));
  EXPECT_GT(store.memory().packed, 0u);
  EXPECT_LT(store.memory().packed, sizeof(ChannelTile) / 50);
}

/** As a site keeps them: heights and variances of ground that is not level, and a few objects. */
TEST_F(Tiles, packs_tiles_into_a_fifth_of_their_memory)
{
  TileStore store(kEight, dir / "");
  Tile& tile = store.at(nth(0));
  for (int i = 0; i < kTileCells * kTileCells; ++i)
  {
    SiteCell& c = tile.cells[static_cast<std::size_t>(i)];
    c.cell.ground_m = static_cast<float>(i / 7 % 300 + i % 13) / 1024;
    c.cell.ground_variance_m2 = std::ldexp(static_cast<float>(128 + i % 100), -20);
    c.cell.elevation_m = i % 50 == 0 ? 1.5F : c.cell.ground_m;
    c.cell.elevation_variance_m2 = c.cell.ground_variance_m2;
    c.cell.traversability = static_cast<float>(i % 257) / 256;
    c.cell.state = 1;
    c.cell.evidence[0] = static_cast<std::uint8_t>(i % 10);
    c.seen_s = 1700000000 + static_cast<std::uint32_t>(i / 1000);
  }
  const Tile before = tile;
  EXPECT_EQ(store.memory().packed, 0u);
  store.pack(nth(0));
  EXPECT_GT(store.memory().packed, 0u);
  EXPECT_LT(store.memory().packed, sizeof(Tile) / 5) << "all its cells are known";
  EXPECT_TRUE(bytes_in(*store.find(nth(0))) == bytes_in(before));
}

TEST_F(Tiles, two_in_one_folder_do_not_disturb_each_other_and_leave_nothing_behind)
{
  {
    TileStore a(0, dir / "new/folder");
    EXPECT_FALSE(fs::exists(dir / "new"));
    fill(a, 10);
    {
      TileStore b(0, dir / "new/folder");
      for (int i = 0; i < 10; ++i) b.at(nth(i));
    }
    for (int i = 0; i < 10; ++i) expect_filled(a.find(nth(i)), nth(i));
    // Those that were asked for last are in memory.
    for (int i = 0; i < 3; ++i) a.find(nth(i));
    for (const auto& file : files_below(dir / "")) fs::remove(file);
    for (int i = 0; i < 3; ++i) expect_filled(a.find(nth(i)), nth(i));
  }
  EXPECT_TRUE(fs::is_empty(dir / "new/folder"));
}

TEST_F(Tiles, names_a_tile_file_that_is_gone_or_damaged)
{
  TileStore store(0, dir / "");
  fill(store, 10);
  const auto path_of = [&](const std::string& part)
  {
    for (const auto& file : files_below(dir / ""))
      if (file.string().find(part) != std::string::npos) return file.string();
    return std::string();
  };
  const std::string damaged = path_of("floor_0_x_-4_y_-2."), gone = path_of("floor_1_x_-4_y_-1.");
  std::string bytes = talus::test::read_bytes(damaged);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_bytes(damaged, bytes);
  fs::remove(gone);
  expect_error([&] { store.find(nth(0)); }, {damaged, "damaged", "--memory"});
  expect_error([&] { store.at(nth(1)); }, {gone, "No such file", "--memory"});
  write_bytes(damaged, "");
  expect_error([&] { store.find(nth(0)); }, {damaged, "damaged"});
  expect_filled(store.find(nth(9)), nth(9));
}

TEST_F(Tiles, says_what_to_do_where_the_disk_is_full_and_loses_nothing)
{
  TileStore store(kEight, dir / "");
  fill(store, 8);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit tight = before;
  tight.rlim_cur = 100;
  setrlimit(RLIMIT_FSIZE, &tight);
  expect_error([&] { store.at(nth(8)); }, {dir / "", ".tile.zst", "free some space", "--memory"});
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(store.keys().size(), 8u);
  for (int i = 0; i < 8; ++i) expect_filled(store.find(nth(i)), nth(i));
  fill(store, 9);
  for (int i = 0; i < 9; ++i) expect_filled(store.find(nth(i)), nth(i));
}

TEST_F(Tiles, forgets_tiles_in_memory_and_on_disk_and_goes_on)
{
  TileStore store(kEight, dir / "");
  fill(store, 12);
  store.erase(nth(0));  // the oldest: on disk
  store.erase(nth(11));
  store.erase(nth(11));
  EXPECT_EQ(store.keys().size(), 10U);
  EXPECT_EQ(store.find(nth(0)), nullptr);
  EXPECT_EQ(store.find(nth(11)), nullptr);
  for (int i = 1; i < 11; ++i) expect_filled(store.find(nth(i)), nth(i));
  EXPECT_FALSE(store.at(nth(0)).cells[1].known()) << "anew";
}

TEST(TileOf, counts_cells_on_both_sides_of_the_origin)
{
  EXPECT_EQ(tile_of(0), 0);
  EXPECT_EQ(tile_of(127), 0);
  EXPECT_EQ(tile_of(128), 1);
  EXPECT_EQ(tile_of(-1), -1);
  EXPECT_EQ(tile_of(-128), -1);
  EXPECT_EQ(tile_of(-129), -2);
  EXPECT_EQ(index_in_tile(-1), 127);
  EXPECT_EQ(index_in_tile(-128), 0);
  EXPECT_EQ(index_in_tile(130), 2);
}
