// What a drive saw later, and from farther away, corrects its site.
#include <gtest/gtest.h>
#include <talus/baselines/method.h>
#include <talus/io/geotiff.h>
#include <talus/site/site_mapper.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <string>

using namespace talus;
using namespace talus::site;

namespace
{
using baselines::ScanFrame;

/** A drive on level ground with what `things` describe, kept as a site. */
struct KeptDrive
{
  explicit KeptDrive(
      const std::string& things, const std::string& ground = "[plane: {}]", bool traffic = false)
      : site(p.resolution_m, std::size_t{64} << 20, testing::TempDir()),
        mapper(site),
        map(p, Backend::Cpu, 1)
  {
    if (traffic) mapper.note_traffic();
    drive(things, ground, mapper, map);
  }
  /** Another one that goes on with the site. */
  void drive_again(const std::string& things)
  {
    SiteMapper later(site);
    ElevationMapper new_map(p, Backend::Cpu, 1);
    drive(things, "[plane: {}]", later, new_map);
    later.look_back(new_map);
  }
  static void drive(
      const std::string& things, const std::string& ground, SiteMapper& mapper,
      ElevationMapper& map)
  {
    const sim::World world = sim::parse_world(
        "seed: 5\nground: " + ground + "\nsensor: {at_m: [0, 0, 0.7], rate_hz: 10}\n" + things,
        "test.yaml");
    for (const ScanFrame& f : baselines::simulate(world, sim::Drive(world, {})).frames)
      mapper.update(map, f.view());
    mapper.keep_window(map);
  }

  struct Counts
  {
    int stand = 0, blocked = 0, free = 0, known = 0;
  };
  Counts count(double x0, double x1, double y0, double y1)
  {
    Counts n;
    for (const TileKey& key : site.tiles.keys())
    {
      const Tile& tile = *site.tiles.find(key);
      for (int i = 0; i < kTileCells * kTileCells; ++i)
      {
        const SiteCell& c = tile.cells[static_cast<std::size_t>(i)];
        const double x = (key.x * kTileCells + i % kTileCells + 0.5) * p.resolution_m;
        const double y = (key.y * kTileCells + i / kTileCells + 0.5) * p.resolution_m;
        if (!c.known() || x < x0 || x > x1 || y < y0 || y > y1) continue;
        ++n.known;
        n.stand += c.cell.elevation_m > c.cell.ground_m + 0.2F;
        n.blocked += c.cell.traversability < 0.05F;
        n.free += c.cell.traversability >= 0.05F;
      }
    }
    return n;
  }

  const Parameters p;
  Site site;
  SiteMapper mapper;
  ElevationMapper map;
};
}  // namespace

TEST(Traffic, a_car_that_drove_beside_the_robot_leaves_nothing)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [40, 0]], speed_mps: 5}\n"
      "movers: [box: {path: [[0, -6, 2.6], [8, 36, 2.6]], size_m: [4, 1.6, 1.5]}]\n");
  const auto lane = [&] { return kept.count(2, 30, 1.8, 3.4); };
  EXPECT_GT(lane().blocked, 300) << "the window forgets it by itself: this says nothing";
  kept.mapper.look_back(kept.map);
  EXPECT_LT(lane().blocked, 0.02 * lane().known);
  EXPECT_EQ(lane().stand, 0);
}

TEST(Traffic, a_car_that_is_gone_today_goes_where_the_window_passes)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [8, 0]], speed_mps: 1}\n"
      "objects: [box: {at_m: [4, 2], size_m: [3, 1.6, 1.5]}]\n");
  kept.mapper.look_back(kept.map);
  const auto car = [&] { return kept.count(2, 6, 0.8, 3.2); };
  const int yesterday = car().stand;
  EXPECT_GT(yesterday, 100);
  kept.drive_again("robot: {path_m: [[0, -5], [8, -5]], speed_mps: 1}\n");
  EXPECT_EQ(car().stand, yesterday) << "outside of the window";
  kept.drive_again("robot: {path_m: [[0, 0], [8, 0]], speed_mps: 1}\n");
  EXPECT_EQ(car().stand, 0);
  EXPECT_EQ(car().blocked, 0);
}

/** No ray passes below and behind it. */
TEST(Traffic, a_car_that_follows_the_robot_leaves_nothing)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [30, 0]], speed_mps: 4}\n"
      "movers: [box: {path: [[0, -4.5, 0], [7.5, 25.5, 0]], size_m: [4, 1.6, 1.5]}]\n");
  const auto lane = [&] { return kept.count(0, 26, -1, 1); };
  EXPECT_GT(lane().stand, 500) << "the window forgets it by itself: this says nothing";
  kept.mapper.look_back(kept.map);
  EXPECT_LT(lane().stand, 10);
  EXPECT_LT(lane().blocked, 0.02 * lane().known);
}

/** Its times are others. */
TEST(Traffic, what_somebody_walks_by_stays)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [12, 0]], speed_mps: 1}\n"
      "objects:\n"
      "- railing: {from_m: [1, 2], to_m: [11, 2], height_m: 0.9}\n"
      "- posts: {from_m: [1, -2], to_m: [11, -2], count: 6, height_m: 0.9, radius_m: 0.06}\n"
      "movers:\n"
      "- person: {path: [[2, 10, 1.7], [10, 2, 1.7]]}\n"
      "- person: {path: [[0, 2, -1.65], [10, 12, -1.65]]}\n");
  const auto railing = [&] { return kept.count(0, 12, 1.95, 2.05).blocked; };
  const auto posts = [&] { return kept.count(0, 12, -2.05, -1.95).blocked; };
  const int railing_before = railing(), posts_before = posts();
  kept.mapper.look_back(kept.map);
  EXPECT_GT(railing_before, 200);
  EXPECT_GT(posts_before, 10);
  EXPECT_EQ(railing(), railing_before);
  EXPECT_EQ(posts(), posts_before);
}

TEST(Traffic, what_came_to_stay_is_kept)
{
  const std::string round = "[8, 0], [8, 6], [0, 6], [0, 0]";
  KeptDrive kept(
      "robot: {path_m: [[0, 0], " + round + ", " + round +
      "], speed_mps: 1}\nobjects: [box: {at_m: [4, 1.6], size_m: [0.6, 0.6, 0.5], from_s: 26}]\n");
  const auto box = [&] { return kept.count(3.5, 4.5, 1.1, 2.1).stand; };
  const int before = box();
  kept.mapper.look_back(kept.map);
  EXPECT_GT(before, 20);
  EXPECT_EQ(box(), before);
}

/** What is told of the cells of a lane and of those outside of it. */
struct LaneTraffic
{
  int cells = 0, elsewhere = 0;
  std::map<int, int> times;  //!< how many cells of the lane so often

  explicit LaneTraffic(KeptDrive& kept)
  {
    const std::string path = testing::TempDir() + "traffic.tif";
    write_traffic_files(path, *kept.mapper.traffic(), kept.site);
    const io::LayerStack stack = io::read_geotiff(path);
    const auto &n = *stack.find("times"), &scans = *stack.find("scans");
    for (std::size_t i = 0; i < n.size(); ++i)
    {
      if (std::isnan(n[i])) continue;
      EXPECT_LE(n[i], scans[i]);
      const std::size_t row = i / static_cast<std::size_t>(stack.cells_x);
      const double y = stack.min_y_m + (static_cast<double>(row) + 0.5) * stack.resolution_m;
      const bool is_lane = y > 1.7 && y < 3.5;
      ++(is_lane ? cells : elsewhere);
      if (is_lane) ++times[static_cast<int>(n[i])];
    }
  }
};

TEST(Traffic, says_in_which_cells_something_moved_and_changes_nothing_by_it)
{
  const std::string things =
      "robot: {path_m: [[0, 0], [30, 0]], speed_mps: 5}\n"
      "objects: [box: {at_m: [12, -2.6], size_m: [4, 1.6, 1.5]}]\n"
      "movers: [box: {path: [[0, -6, 2.6], [6, 26, 2.6]], size_m: [4, 1.6, 1.5]}]\n";
  KeptDrive kept(things, "[plane: {}]", true), not_asked(things);
  kept.mapper.look_back(kept.map);
  not_asked.mapper.look_back(not_asked.map);
  EXPECT_EQ(not_asked.mapper.traffic(), nullptr);
  EXPECT_EQ(kept.count(-5, 35, -5, 5).blocked, not_asked.count(-5, 35, -5, 5).blocked);
  LaneTraffic traffic(kept);
  EXPECT_GT(traffic.cells, 500);
  EXPECT_GT(traffic.times[1], 0.95 * traffic.cells) << "one car";
  EXPECT_EQ(traffic.elsewhere, 0) << "the box stands";
}

TEST(Traffic, counts_each_visit)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [5, 0]], speed_mps: 0.5}\n"
      "movers: [box: {path: [[0, -12, 2.6], [3, 12, 2.6], [6.5, 12, 2.6], [9.5, -12, 2.6]], "
      "size_m: [4, 1.6, 1.5]}]\n",
      "[plane: {}]", true);
  kept.mapper.look_back(kept.map);
  LaneTraffic traffic(kept);
  EXPECT_GT(traffic.times[2], 100) << "a scan with 16 beams hits few cells of it";
  EXPECT_EQ(traffic.times[3], 0);
}

TEST(Hindsight, packs_the_tiles_that_the_robot_has_left_far_behind)
{
  const KeptDrive kept("robot: {path_m: [[0, 0], [80, 0]], speed_mps: 8}\n");
  const TileStore::Memory memory = kept.site.tiles.memory();
  EXPECT_GE(kept.site.tiles.keys().size(), 28U) << "two for each 6.4 m";
  EXPECT_LE(memory.open, 16 * sizeof(Tile));
  EXPECT_GT(memory.packed, 0U);
  EXPECT_LT(memory.packed, 16 * sizeof(Tile) / 5);
}

/** The edge is in the window, and all that was hit below it is not. */
TEST(Guesses, nobody_drives_over_the_edge_of_a_quay)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [15, 0]], speed_mps: 1}\n",
      "[plane: {}, step: {at_m: [0, 3.3], yaw_deg: 90, height_m: -1.7}]");
  const auto beyond = [&] { return kept.count(1, 14, 3.35, 5); };
  EXPECT_EQ(beyond().free, 0) << "the window knows it by itself";
  kept.mapper.look_back(kept.map);
  EXPECT_EQ(beyond().free, 0);
  EXPECT_GT(kept.count(1, 14, -3.2, 3.2).free, 0.99 * kept.count(1, 14, -3.2, 3.2).known);
}

TEST(Guesses, nobody_drives_into_a_ditch_behind_the_rim)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [15, 0]], speed_mps: 1}\n",
      "[plane: {}, ditch: {at_m: [7, 3.7], width_m: 0.8, depth_m: 0.45, length_m: 30}]");
  const auto inside = [&] { return kept.count(1, 14, 3.35, 4); };
  EXPECT_GT(inside().free, 1000) << "the window knows it by itself: this says nothing";
  kept.mapper.look_back(kept.map);
  EXPECT_LT(inside().free, 0.01 * inside().known);
}

TEST(Guesses, what_nothing_hit_in_the_shadow_of_a_box_is_not_judged)
{
  KeptDrive kept(
      "robot: {path_m: [[0, 0], [2, 0]], speed_mps: 1}\n"
      "objects: [box: {at_m: [1, 2.2], size_m: [5, 0.8, 0.4]}]\n");
  const auto shadow = [&] { return kept.count(0, 2, 2.7, 3.9); };
  EXPECT_GT(shadow().free, 50) << "the window judges nothing there: this says nothing";
  kept.mapper.look_back(kept.map);
  EXPECT_EQ(shadow().free, 0);
}

TEST(Guesses, level_ground_stays_free_up_to_the_rim)
{
  KeptDrive kept("robot: {path_m: [[0, 0], [15, 0]], speed_mps: 1}\n");
  const int before = kept.count(-5, 20, -5, 5).free;
  kept.mapper.look_back(kept.map);
  EXPECT_GT(before, 40000);
  EXPECT_GT(kept.count(-5, 20, -5, 5).free, 0.99 * before);
}
