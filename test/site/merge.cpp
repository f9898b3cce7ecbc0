// What several maps know of a place becomes one map.
#include <gtest/gtest.h>
#include <talus/site/merge.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "log_files.h"
#include "sites.h"

namespace fs = std::filesystem;
using namespace talus;
using namespace talus::site;
using namespace talus::test;

namespace
{
constexpr double kStep_m = 0.2;

SiteCell filled(SiteCell c, std::uint8_t state = 2)
{
  c.cell.state = state;
  return c;
}
SiteCell merged(std::vector<SiteCell> cells)
{
  const SiteCell m = merge_cells(cells.data(), static_cast<int>(cells.size()), kStep_m);
  std::reverse(cells.begin(), cells.end());
  EXPECT_EQ(
      bytes_of(merge_cells(cells.data(), static_cast<int>(cells.size()), kStep_m)), bytes_of(m));
  return m;
}

class MergeSites : public testing::Test
{
 protected:
  std::unique_ptr<Site> site(double resolution_m = 0.05) const
  {
    return std::make_unique<Site>(resolution_m, std::size_t{64} << 20, dir_ / "tiles");
  }
  /** A square of random cells, some measured, some filled, with holes. */
  void write(const std::string& name, unsigned seed, int x, int y, int size) const
  {
    const auto s = site();
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> height(0, 0.3F);
    for (int i = x; i < x + size; ++i)
      for (int k = y; k < y + size; ++k)
      {
        if (random() % 8 == 0) continue;
        SiteCell c = measured(height(random), 1000 + seed, 1e-4F + height(random));
        if (random() % 4 == 0) c = filled(c, static_cast<std::uint8_t>(2 + random() % 3));
        if (random() % 5 == 0) c = with_obstacle(c, height(random));
        cell_at(*s, i, k) = c;
      }
    s->ways = {{{static_cast<float>(x), 0, 0, 0}, {static_cast<float>(seed), 1, 0, 0}}};
    write_site(dir_ / name, *s, 0);
  }
  std::string merged_bytes(std::vector<std::string> names, int threads = 1) const
  {
    for (std::string& name : names) name = dir_ / name;
    const auto s = site();
    MergeOptions options;
    options.threads = threads;
    merge_sites(names, *s, 0, options);
    write_site(dir_ / "merged.tif", *s, 0);
    return read_bytes(dir_ / "merged.tif");
  }
  ScratchDir dir_;
};
}  // namespace

TEST(MergeCells, ground_is_told_by_the_state_with_the_best_evidence)
{
  constexpr std::uint8_t kBestFirst[] = {1, 2, 4, 3};
  for (std::size_t i = 0; i + 1 < std::size(kBestFirst); ++i)
  {
    SiteCell best = filled(measured(0.5F, 1000), kBestFirst[i]);
    SiteCell next = filled(measured(1, 2000), kBestFirst[i + 1]);
    const SiteCell m = merged({best, next});
    EXPECT_EQ(m.cell.state, kBestFirst[i]);
    EXPECT_EQ(m.cell.ground_m, 0.5F);
  }
}

TEST(MergeCells, what_only_one_map_knows_stays_as_it_is)
{
  const SiteCell c = with_obstacle(measured(1.1F, 7), 0.4F);
  EXPECT_EQ(bytes_of(merged({c, SiteCell{}, SiteCell{}})), bytes_of(c));
  EXPECT_FALSE(merged({SiteCell{}, SiteCell{}}).known());
  EXPECT_EQ(bytes_of(merged({c, c, c})), bytes_of(c)) << "the same observation counts once";
}

TEST(MergeCells, heights_that_agree_are_weighed_by_their_information)
{
  const SiteCell m = merged({measured(1.0F, 1, 4e-4F), measured(1.01F, 2, 1e-4F)});
  EXPECT_NEAR(m.cell.ground_m, 1.008, 1e-6);
  EXPECT_NEAR(m.cell.ground_variance_m2, 0.8e-4, 1e-9);
  EXPECT_EQ(m.seen_s, 2u);
  const SiteCell tops =
      merged({with_obstacle(measured(1, 1), 0.5F), with_obstacle(measured(1, 2), 0.51F)});
  EXPECT_NEAR(tops.cell.elevation_m, 1.505, 1e-6);
  EXPECT_NEAR(tops.cell.elevation_variance_m2, 1e-4, 1e-9);
}

TEST(MergeCells, the_deviation_of_a_mean_tells_how_far_its_maps_disagree)
{
  // 2.5 mm each, 150 mm apart: either may be right, the mean is 75 mm wrong.
  const SiteCell two = merged({measured(1.0F, 1, 6.25e-6F), measured(1.15F, 2, 6.25e-6F)});
  EXPECT_NEAR(two.cell.ground_m, 1.075, 1e-6);
  EXPECT_NEAR(std::sqrt(two.cell.ground_variance_m2), 0.075, 1e-5);
  // One that claims to be much better is not believed where they disagree.
  const SiteCell sure = merged({measured(1.0F, 1, 1e-8F), measured(1.15F, 2, 1e-4F)});
  EXPECT_NEAR(sure.cell.ground_m, 1.075, 1e-3);
  EXPECT_GT(std::sqrt(sure.cell.ground_variance_m2), 0.07);
  const SiteCell tops = merged(
      {with_obstacle(measured(1, 1, 1e-6F), 0.5F), with_obstacle(measured(1, 2, 1e-6F), 0.6F)});
  EXPECT_NEAR(tops.cell.elevation_m, 1.55, 1e-6);
  EXPECT_NEAR(std::sqrt(tops.cell.elevation_variance_m2), 0.05, 1e-4);
}

TEST(MergeCells, the_newest_wins_where_they_contradict)
{
  const SiteCell m = merged({measured(1.0F, 1, 1e-6F), measured(1.5F, 2, 1e-2F)});
  EXPECT_EQ(m.cell.ground_m, 1.5F);
  EXPECT_EQ(m.cell.ground_variance_m2, 1e-2F);
  const SiteCell three = merged({measured(1.0F, 3), measured(1.5F, 2), measured(1.1F, 1)});
  EXPECT_NEAR(three.cell.ground_m, 1.05, 1e-6) << "the older that agrees counts";
}

TEST(MergeCells, a_box_that_was_taken_away_is_gone)
{
  const SiteCell m = merged({with_obstacle(measured(1, 1), 0.5F), measured(1, 2)});
  EXPECT_TRUE(std::isnan(m.cell.elevation_m));
  EXPECT_EQ(m.cell.traversability, 1);
  EXPECT_EQ(m.cell.evidence[1], 0);
}

TEST(MergeCells, a_new_box_on_ground_that_it_hides_is_there)
{
  const SiteCell m = merged({measured(1, 1), filled(with_obstacle(measured(1.1F, 2), 0.5F))});
  EXPECT_EQ(m.cell.state, 1) << "the ground was measured before";
  EXPECT_EQ(m.cell.ground_m, 1);
  EXPECT_EQ(m.cell.elevation_m, 1.6F);
  EXPECT_EQ(m.cell.traversability, 0);
  EXPECT_EQ(m.seen_s, 2u);
}

TEST(MergeCells, a_box_stays_where_a_newer_drive_did_not_see_the_place)
{
  const SiteCell m = merged({with_obstacle(measured(1, 1), 0.5F), filled(measured(1, 2))});
  EXPECT_EQ(m.cell.elevation_m, 1.5F);
  EXPECT_EQ(m.cell.traversability, 0);
}

TEST(MergeCells, no_order_makes_a_difference_to_any_bit)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<float> height(0, 0.5F);
  for (int trial = 0; trial < 300; ++trial)
  {
    std::vector<SiteCell> cells;
    for (int i = 0; i < 5; ++i)
    {
      SiteCell c = measured(height(random), 1 + random() % 3, height(random) * 1e-3F);
      if (random() % 3 == 0) c = with_obstacle(c, height(random));
      cells.push_back(filled(c, static_cast<std::uint8_t>(1 + random() % 3)));
    }
    const std::string first = bytes_of(merge_cells(cells.data(), 5, kStep_m));
    for (int i = 0; i < 5; ++i)
    {
      std::shuffle(cells.begin(), cells.end(), random);
      ASSERT_EQ(bytes_of(merge_cells(cells.data(), 5, kStep_m)), first);
    }
  }
}

TEST_F(MergeSites, has_the_same_bytes_for_every_order_and_number_of_threads)
{
  write("a.tif", 1, -100, -80, 250);
  write("b.tif", 2, 0, 0, 300);
  write("c.tif", 3, 200, -200, 250);
  const std::string once = merged_bytes({"a.tif", "b.tif", "c.tif"});
  EXPECT_EQ(merged_bytes({"c.tif", "a.tif", "b.tif"}), once);
  EXPECT_EQ(merged_bytes({"b.tif", "c.tif", "a.tif"}, 5), once);
}

TEST_F(MergeSites, is_what_merge_cells_says_of_each_cell)
{
  write("a.tif", 1, -100, -80, 250);
  write("b.tif", 2, 0, 0, 300);
  merged_bytes({"a.tif", "b.tif"}, 2);
  const auto a = site(), b = site(), m = site();
  read_site(dir_ / "a.tif", *a, 0);
  read_site(dir_ / "b.tif", *b, 0);
  read_site(dir_ / "merged.tif", *m, 0);
  ASSERT_EQ(m->ways.size(), 2u);
  int known = 0;
  for (int x = -110; x < 310; ++x)
    for (int y = -90; y < 310; ++y)
    {
      const std::vector<SiteCell> both{cell_at(*a, x, y), cell_at(*b, x, y)};
      const SiteCell expected = merge_cells(both.data(), 2, kStep_m), is = cell_at(*m, x, y);
      ASSERT_EQ(bytes_of(is), bytes_of(expected)) << x << " " << y;
      known += is.known();
    }
  EXPECT_GT(known, 100'000);
}

TEST_F(MergeSites, a_map_merged_with_itself_is_itself)
{
  write("a.tif", 1, -100, -80, 250);
  EXPECT_EQ(merged_bytes({"a.tif", "a.tif"}), read_bytes(dir_ / "a.tif"));
}

TEST_F(MergeSites, refuses_maps_of_other_frames)
{
  write("a.tif", 1, 0, 0, 10);
  const auto coarse = site(0.1);
  cell_at(*coarse, 0, 0) = measured(1);
  write_site(dir_ / "coarse.tif", *coarse, 0);
  const auto earth = site();
  cell_at(*earth, 0, 0) = measured(1);
  earth->origin = GeoOrigin{48, 11, 0, 0};
  write_site(dir_ / "earth.tif", *earth, 0);
  expect_error([&] { merged_bytes({"a.tif", "coarse.tif"}); }, {"coarse.tif", "resolution"});
  expect_error([&] { merged_bytes({"a.tif", "earth.tif"}); }, {"earth.tif", "origin", "map frame"});
  expect_error([&] { merged_bytes({"a.tif", "none.tif"}); }, {"none.tif", "no such file"});
  const auto one = site(), other = site();
  cell_at(*one, 0, 0) = cell_at(*other, 0, 0) = measured(0, 1000);
  one->channels = channels_from("v:mean");
  other->channels = channels_from("v:max");
  write_site(dir_ / "one.tif", *one, 0);
  write_site(dir_ / "other.tif", *other, 0);
  expect_error([&] { merged_bytes({"one.tif", "other.tif"}); }, {"'v:mean' has another rule"});
}

TEST_F(MergeSites, channels_of_all_come_along_the_newest_first)
{
  const auto old = site(), now = site(), plain = site();
  old->channels = channels_from("label:vote,intensity:mean");
  now->channels = channels_from("red:mean,label:vote");
  for (int i = 0; i < 4; ++i)
  {
    cell_at(*old, i, 0) = with_obstacle(measured(0, 1000), 0.5F);
    cell_at(*now, i, 0) = measured(0, 2000);
    cell_at(*plain, i, 0) = measured(0, 3000);
  }
  cell_at(*plain, 2, 0) = SiteCell();
  for (const std::size_t layer : {0U, 1U, 2U}) value_at(*old, 0, 0, layer) = 5;
  value_at(*old, 1, 0, 0) = 5;
  value_at(*now, 1, 0, 2) = 9;  // the label
  value_at(*now, 0, 0, 0) = 200;
  write_site(dir_ / "old.tif", *old, 0);
  write_site(dir_ / "now.tif", *now, 0);
  write_site(dir_ / "plain.tif", *plain, 0);
  const std::string bytes = merged_bytes({"old.tif", "now.tif", "plain.tif"}, 3);
  const auto all = site();
  read_site(dir_ / "merged.tif", *all, 0);
  EXPECT_EQ(channels_text(all->channels), "label:vote,intensity:mean,red:mean");
  EXPECT_EQ(value_at(*all, 0, 0, 0), 5) << "newer maps have no label there";
  EXPECT_TRUE(std::isnan(value_at(*all, 0, 0, 1))) << "what stood there has left";
  EXPECT_EQ(value_at(*all, 0, 0, 2), 5);
  EXPECT_EQ(value_at(*all, 0, 0, 4), 200);
  EXPECT_EQ(value_at(*all, 1, 0, 0), 9);
  EXPECT_EQ(merged_bytes({"old.tif", "now.tif", "plain.tif"}, 1), bytes);
}
