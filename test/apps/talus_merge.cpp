// The command talus-merge from end to end: its files, messages and exit codes.
#include <gtest/gtest.h>
#include <talus/io/geotiff.h>
#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include <memory>

#include "command_run.h"
#include "sites.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::site;
using namespace talus::test;

namespace
{
class TalusMerge : public CommandTest
{
 protected:
  TalusMerge() : CommandTest(TALUS_MERGE_EXE) {}
  std::unique_ptr<Site> site() const
  {
    return std::make_unique<Site>(0.05, std::size_t{64} << 20, dir_ / "tiles");
  }
  /** A square of ground at a height; `box`: from there on something stands on 20 x 20 cells. */
  void write_map(
      const std::string& name, std::uint32_t seen_s, int x, float ground_m, int box = -1) const
  {
    const auto s = site();
    for (int i = x; i < x + 300; ++i)
      for (int k = 0; k < 300; ++k)
      {
        SiteCell c = measured(ground_m, seen_s);
        if (box >= 0 && i >= box && i < box + 20 && k >= 100 && k < 120) c = with_obstacle(c, 0.5F);
        cell_at(*s, i, k) = c;
      }
    s->ways = {
        {{static_cast<float>(x) * 0.05F, 5, 0, 0}, {static_cast<float>(x) * 0.05F + 10, 5, 0, 0}}};
    write_site(dir_ / name, *s, 0);
  }
};
}  // namespace

TEST_F(TalusMerge, fuses_maps_in_any_order_into_the_same_bytes_and_draws_them)
{
  write_map("a.tif", 1000, 0, 1.0F);
  write_map("b.tif", 2000, 200, 1.02F);
  const CommandEnd o = runs("a.tif b.tif --output ab.tif --picture ab.png");
  EXPECT_SAYS(o.text, "2 maps: 375.00 m2 known");
  EXPECT_SAYS(o.text, "ab.tif");
  EXPECT_GT(fs::file_size(dir_ / "ab.png"), 1000u);
  ASSERT_EQ(run("b.tif a.tif --output ba.tif --threads 3 --quiet").text, "");
  EXPECT_EQ(read_bytes(dir_ / "ab.tif"), read_bytes(dir_ / "ba.tif"));
  const auto merged = site();
  read_site(dir_ / "ab.tif", *merged, 0);
  EXPECT_NEAR(cell_at(*merged, 250, 50).cell.ground_m, 1.01, 1e-6);
  EXPECT_EQ(merged->ways.size(), 2u);
  write_bytes(dir_ / "a.yaml", "of the map before");
  EXPECT_SAYS(run("a.tif b.tif --output a.tif").text, "warning: a.yaml is of the map before");
  EXPECT_EQ(read_bytes(dir_ / "a.tif"), read_bytes(dir_ / "ab.tif")) << "over one of its inputs";
  EXPECT_EQ(hidden(), 0);
}

TEST_F(TalusMerge, a_site_is_all_its_files)
{
  constexpr int kFar = 400'000;  // cells
  write_map("a.tif", 1000, 0, 1.0F);
  write_map("b.tif", 1000, kFar, 1.0F);
  write_map("c.tif", 1000, 2 * kFar, 1.0F);
  fs::create_directory(dir_ / "all");
  write_bytes(dir_ / "all/site_floor_1.tif", "of the map before");
  runs("a.tif b.tif --output all/site.tif");
  EXPECT_FALSE(fs::exists(dir_ / "all/site_floor_1.tif"));
  runs("all/site.tif a.tif --output again/site.tif");
  EXPECT_EQ(
      read_bytes(dir_ / "again/site_island_1.tif"), read_bytes(dir_ / "all/site_island_1.tif"));
  const CommandEnd o = runs("all/site.tif c.tif --output all/site.tif --picture all/site.png");
  EXPECT_SAYS(o.text, "2 maps: 675.00 m2 known");
  const auto all = site();
  read_site_files(dir_ / "all/site.tif", *all);
  for (const int x : {0, kFar, 2 * kFar}) EXPECT_TRUE(cell_at(*all, x, 0).known()) << x;
  EXPECT_TRUE(fs::exists(dir_ / "all/site_island_2.png"));
  runs("a.tif c.tif --output all/site.tif");
  for (const char* old : {"site_island_2.tif", "site_island_2.png"})
    EXPECT_FALSE(fs::exists(dir_ / ("all/" + std::string(old)))) << "is of the map before: " << old;
}

TEST_F(TalusMerge, takes_a_site_of_one_cell)
{
  const auto one = site();
  cell_at(*one, 400, 7) = measured(1.5F, 1000);
  write_site(dir_ / "one.tif", *one, 0);
  write_map("a.tif", 1000, 0, 1);
  EXPECT_SAYS(runs("one.tif a.tif --output all.tif").text, "2 maps: 225.00 m2 known");
  runs("a.tif one.tif --output other.tif");
  EXPECT_EQ(read_bytes(dir_ / "all.tif"), read_bytes(dir_ / "other.tif"));
  runs("one.tif one.tif --output twice.tif");
  for (const char* name : {"all.tif", "twice.tif"})
  {
    const auto merged = site();
    read_site(dir_ / name, *merged, 0);
    EXPECT_EQ(cell_at(*merged, 400, 7).cell.ground_m, 1.5F) << name;
    EXPECT_FALSE(known_at(*merged, 401, 7).known()) << name;
  }
}

TEST_F(TalusMerge, opens_no_more_files_at_once_than_it_may)
{
  std::string names;
  for (std::uint32_t i = 0; i < 40; ++i)
  {
    const auto s = site();
    for (int x = 0; x < 20; ++x) cell_at(*s, x, 0) = measured(1, 1000 + i);
    const std::string name = std::to_string(i) + ".tif";
    write_site(dir_ / name, *s, 0);
    names += " " + name;
  }
  runs(names + " --output all.tif");
  const CommandEnd few = runs(names + " --output few.tif --threads 3", "ulimit -n 32;");
  EXPECT_EQ(read_bytes(dir_ / "all.tif"), read_bytes(dir_ / "few.tif"));
}

TEST_F(TalusMerge, tells_what_changed_between_two_days)
{
  write_map("monday.tif", 1000, 0, 1.0F, 40);
  write_map("friday.tif", 2000, 0, 1.0F, 200);
  const auto dug = site();
  read_site(dir_ / "friday.tif", *dug, 0);
  for (int i = 0; i < 10; ++i) cell_at(*dug, 280, i).cell.ground_m = 0.5F;
  write_site(dir_ / "friday.tif", *dug, 0);
  const CommandEnd o = runs("--changes monday.tif friday.tif --output out");
  for (const char* line :
       {"built up     0.00 m2, 0.00 m3", "dug away     0.03 m2, 0.01 m3",
        "object gone  1.00 m2, 0.50 m3", "object new   1.00 m2, 0.50 m3"})
    EXPECT_SAYS(o.text, line);
  EXPECT_GT(fs::file_size(dir_ / "out/changes.png"), 1000u);
  const auto changes = io::read_geotiff(dir_ / "out/changes.tif");
  ASSERT_EQ(changes.names, (std::vector<std::string>{"change_m", "kind"}));
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * changes.cells_x + x; };
  EXPECT_EQ(changes.layers[1][at(45, 105)], 3);
  EXPECT_EQ(changes.layers[1][at(205, 105)], 4);
  EXPECT_EQ(changes.layers[1][at(280, 5)], 2);
  EXPECT_EQ(changes.layers[1][at(5, 5)], 0);
  EXPECT_EQ(changes.layers[0][at(280, 5)], -0.5F);
  EXPECT_TRUE(std::isnan(changes.layers[0][at(310, 5)]));
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_ / "out"), fs::directory_iterator()), 2);
}

TEST_F(TalusMerge, warns_where_the_newer_map_is_given_first)
{
  write_map("monday.tif", 1000, 0, 1.0F);
  write_map("friday.tif", 2000, 0, 1.0F);
  const CommandEnd swapped = runs("--changes friday.tif monday.tif --output out");
  EXPECT_SAYS(swapped.text, "warning: friday.tif was seen 1000 s after monday.tif");
  const CommandEnd right = run("--changes monday.tif friday.tif --output out");
  EXPECT_SAYS_NOT(right.text, "warning");
}

TEST_F(TalusMerge, says_what_is_wrong_with_an_input_and_leaves_what_was_there)
{
  write_map("a.tif", 1000, 0, 1.0F);
  write_bytes(dir_ / "site.tif", "precious");
  write_bytes(dir_ / "text.tif", "hello");
  io::write_geotiff(dir_ / "map.tif", io::snapshot(ElevationMapper()));
  fails("a.tif none.tif --output site.tif", 1, {"none.tif", "no such file"});
  fails("none.tif a.tif --output site.tif", 1, {"none.tif", "no such file"});
  fails("a.tif text.tif --output site.tif", 1, {"text.tif", "GeoTIFF"});
  fails("a.tif map.tif --output site.tif", 1, {"map.tif", "site.tif that lies beside it"});
  fails("--changes a.tif text.tif --output out", 1, {"text.tif", "GeoTIFF"});
  const std::string a = read_bytes(dir_ / "a.tif");
  fails("a.tif --output site.tif --picture a.tif", 1, {"a.tif", "is an input"});
  write_map("in_way.gpkg", 1000, 0, 1.0F);
  fails("in_way.gpkg --output in.tif", 1, {"in_way.gpkg", "is an input"});
  for (const char* name : {"new.tif", "new.qml", "new_way.gpkg", "new_island_1.tif"})
    fails("a.tif --output new.tif --picture " + std::string(name), 1, {name, "NAME.png"});
  for (const char* name : {"new", "new.png", "new_island_1.tif", "new_floor_2.tif"})
    fails("a.tif --output " + std::string(name), 1, {name, "call the map of all NAME.tif"});
  fs::copy_file(dir_ / "a.tif", dir_ / "new_floor_1.tif");
  fails("new_floor_1.tif a.tif --output new.tif", 1, {"new_floor_1.tif", "as a part of new.tif"});
  EXPECT_TRUE(fs::exists(dir_ / "new_floor_1.tif"));
  EXPECT_EQ(read_bytes(dir_ / "a.tif"), a);
  write_map("far.tif", 1000, 100'000, 1.0F);
  fails("--changes a.tif far.tif --output out", 1, {"no place in common"});
  EXPECT_FALSE(fs::exists(dir_ / "out"));
  EXPECT_EQ(read_bytes(dir_ / "site.tif"), "precious");
  EXPECT_EQ(hidden(), 0);
}

TEST_F(TalusMerge, tells_how_maps_fit_and_warns_where_they_do_not)
{
  write_map("a.tif", 1000, 0, 1.0F, 100);
  write_map("b.tif", 2000, 0, 1.15F, 100);
  const CommandEnd bad = runs("a.tif b.tif --output ab.tif");
  for (const char* words :
       {"fit     a.tif and b.tif: overlap 225.00 m2, the second lies +0.1500 m in z (median), "
        "100.0 "
        "% of the ground disagrees, 0.0 % of what stands",
        "warning: a.tif and b.tif do not fit: offset in z +0.150 m", "--align brings them"})
    EXPECT_SAYS(bad.text, words);
  EXPECT_SAYS(run("a.tif b.tif --output ab.tif --quiet").text, "warning");
  write_map("c.tif", 2000, 0, 1.0F, 100);
  EXPECT_SAYS_NOT(run("a.tif c.tif --output ac.tif").text, "warning");
  write_map("aside.tif", 2000, 0, 1.0F, 103);
  const CommandEnd aside = run("a.tif aside.tif --output ab.tif");
  EXPECT_SAYS(aside.text, "fit better where the second is moved by x -0.150 m");
  const CommandEnd changed = run("--changes a.tif b.tif --output out");
  EXPECT_SAYS(changed.text, "warning: a.tif and b.tif do not fit");
}

TEST_F(TalusMerge, align_brings_maps_into_the_frame_of_the_first)
{
  write_map("a.tif", 1000, 0, 1.0F, 100);
  write_map("b.tif", 2000, 3, 1.6F, 103);  // the same box, 0.15 m farther along x
  const CommandEnd o = runs("--align a.tif b.tif --output ab.tif");
  EXPECT_SAYS(
      o.text, "aligned b.tif: moved by x -0.150 m, y +0.000 m, z -0.6000 m, yaw +0.00 degrees");
  EXPECT_SAYS_NOT(o.text, "warning");
  const auto merged = site();
  read_site(dir_ / "ab.tif", *merged, 0);
  EXPECT_NEAR(cell_at(*merged, 110, 110).cell.ground_m, 1, 1e-6);
  const CommandEnd changes = run("--changes --align a.tif b.tif --output out");
  for (const char* line :
       {"built up     0.00 m2", "dug away     0.00 m2", "object gone  0.00 m2",
        "object new   0.00 m2", "moved by x -0.150 m"})
    EXPECT_SAYS(changes.text, line);
}

TEST_F(TalusMerge, makes_the_folders_of_its_files_and_leaves_none_where_it_fails)
{
  write_map("a.tif", 1000, 0, 1.0F);
  fails("a.tif none.tif --output new/deep/site.tif", 1, {"none.tif", "no such file"});
  EXPECT_FALSE(fs::exists(dir_ / "new"));
  runs("a.tif --output new/deep/site.tif --picture pictures/site.png");
  EXPECT_EQ(read_bytes(dir_ / "new/deep/site.tif"), read_bytes(dir_ / "a.tif"));
  EXPECT_GT(fs::file_size(dir_ / "pictures/site.png"), 1000u);
  fails("a.tif --output a.tif/site.tif", 1, {"a.tif", "folder"});
}

TEST_F(TalusMerge, says_when_the_disk_is_full_and_leaves_what_was_there)
{
  write_map("a.tif", 1000, 0, 1.0F);
  write_map("b.tif", 2000, 200, 1.1F);
  write_bytes(dir_ / "site.tif", "precious");
  fails("a.tif b.tif --output site.tif", 1, {"site.tif", "disk full"}, "ulimit -f 8;");
  EXPECT_EQ(read_bytes(dir_ / "site.tif"), "precious");
  EXPECT_EQ(hidden(), 0);
  const CommandEnd changes = run("--changes a.tif b.tif --output out", "ulimit -f 2;");
  EXPECT_EQ(changes.code, 1) << changes.text;
  EXPECT_FALSE(fs::exists(dir_ / "out"));
}

TEST_F(TalusMerge, explains_itself_and_refuses_wrong_usage)
{
  EXPECT_SAYS(run("--help").text, "Examples:");
  runs("--version");
  fails("", 2, {"MAP"});
  fails("a.tif", 2, {"--output"});
  fails("--changes a.tif --output out", 2, {"--changes", "two maps"});
  fails("--changes a.tif b.tif c.tif --output out", 2, {"there are 3"});
  fails("a.tif --output '' ", 2, {"--output", "empty"});
  fails("a.tif --output b.tif --step nan", 2, {"--step"});
}
