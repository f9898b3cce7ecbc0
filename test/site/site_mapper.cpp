// A whole drive is kept: what leaves the window comes back when the robot does, floor by floor.
#include <gtest/gtest.h>
#include <talus/baselines/method.h>
#include <talus/map_view.h>
#include <talus/site/site_mapper.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sites.h"

using namespace talus;
using namespace talus::site;

namespace
{
using baselines::ScanFrame;

constexpr const char* kSensor = "sensor: {at_m: [0, 0, 0.7], rate_hz: 10}\n";

std::vector<ScanFrame> drive(const std::string& world, double z_drift = 0)
{
  sim::DriveOptions options;
  options.noise_m = 0;
  options.noise_per_m = 0;
  options.z_drift = z_drift;
  const sim::World w = sim::parse_world("seed: 5\n" + world + kSensor, "test.yaml");
  const sim::Drive d(w, options);
  return baselines::simulate(w, d).frames;
}

/** A map whose drive is kept. */
struct KeptDrive
{
  explicit KeptDrive(bool restores = true, const std::string& channels = "")
      : site(Parameters().resolution_m, std::size_t{64} << 20, testing::TempDir()),
        mapper(site, restores),
        map(with_channels(channels), Backend::Cpu, 1)
  {
  }
  static Parameters with_channels(const std::string& channels)
  {
    Parameters p;
    p.channels = channels_from(channels);
    return p;
  }

  using OnFrame = std::function<void(std::size_t)>;
  KeptDrive& add(const std::vector<ScanFrame>& frames, const OnFrame& on_frame = {})
  {
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
      mapper.update(map, frames[i].view());
      if (on_frame) on_frame(i);
    }
    return *this;
  }
  KeptDrive& end()
  {
    mapper.keep_window(map);
    return *this;
  }

  SiteCell cell(double x_m, double y_m, int floor = 0)
  {
    return at(
        static_cast<std::int64_t>(std::floor(x_m / site.resolution_m)),
        static_cast<std::int64_t>(std::floor(y_m / site.resolution_m)), floor);
  }
  SiteCell at(std::int64_t x, std::int64_t y, int floor = 0)
  {
    return test::known_at(site, x, y, floor);
  }
  float in_window(Layer layer, double x_m, double y_m) const
  {
    EXPECT_TRUE(map.window().index_at(x_m, y_m)) << x_m << " " << y_m;
    return MapView(map).at(layer, x_m, y_m);
  }

  /** Calls f(cell, x of its middle, y) for the known cells of a floor. */
  void for_each_known(int floor, const std::function<void(const SiteCell&, double, double)>& f)
  {
    for (const TileKey& key : site.tiles.keys())
    {
      if (key.floor != floor) continue;
      const Tile& tile = *site.tiles.find(key);
      for (int i = 0; i < kTileCells * kTileCells; ++i)
        if (const SiteCell& c = tile.cells[static_cast<std::size_t>(i)]; c.known())
          f(c, middle_of_cell_m(cell_of_tile(key.x, i % kTileCells), site.resolution_m),
            middle_of_cell_m(cell_of_tile(key.y, i / kTileCells), site.resolution_m));
    }
  }

  Site site;
  SiteMapper mapper;
  ElevationMapper map;
};

/** Adds the floor of the robot where it is another one than before. */
void note_floor(const KeptDrive& kept, std::vector<int>& floors)
{
  if (floors.empty() || floors.back() != kept.mapper.floor()) floors.push_back(kept.mapper.floor());
}

bool is_measured(const SiteCell& c) { return c.cell.state == 1; }

/** Of those measured on a floor within a rectangle: how many, and farthest off a height. */
struct Off
{
  int cells = 0, far = 0;  //!< far: by more than 0.3 m
  double most_m = 0;
};
Off off_ground(
    KeptDrive& kept, int floor, double height_m, double x0 = -1e9, double x1 = 1e9,
    double y0 = -1e9, double y1 = 1e9)
{
  Off off;
  kept.for_each_known(
      floor,
      [&](const SiteCell& c, double x, double y)
      {
        if (!is_measured(c) || x < x0 || x > x1 || y < y0 || y > y1) return;
        const double by = std::abs(c.cell.ground_m - height_m);
        ++off.cells;
        off.far += by > 0.3;
        off.most_m = std::max(off.most_m, by);
      });
  return off;
}

/** What stands highest in a rectangle. */
double highest(KeptDrive& kept, double x0, double x1, double y0, double y1, int floor = 0)
{
  double most_m = -1e9;
  kept.for_each_known(
      floor,
      [&](const SiteCell& c, double x, double y)
      {
        if (x > x0 && x < x1 && y > y0 && y < y1 && c.cell.elevation_m > most_m)
          most_m = c.cell.elevation_m;
      });
  return most_m;
}

const std::string kFlat = "ground: [plane: {}]\n";
const std::string kStraight = kFlat + "robot: {path_m: [[0, 0], [16, 3]], speed_mps: 2}\n";
}  // namespace

TEST(SiteMapper, keeps_every_cell_of_a_straight_drive)
{
  const auto frames = drive(kStraight);
  KeptDrive kept;
  std::map<std::pair<std::int64_t, std::int64_t>, int> seen;
  kept.add(
      frames,
      [&](std::size_t)
      {
        const Window w = kept.map.window();
        const auto& state = kept.map.layer(Layer::State);
        for (int i = 0; i < w.cells * w.cells; ++i)
          if (state[static_cast<std::size_t>(i)] == 1)
            seen[{w.min_cell_x + i % w.cells, w.min_cell_y + i / w.cells}] = 1;
      });
  kept.end();
  ASSERT_GT(seen.size(), 10000u);
  std::size_t lost = 0;
  for (const auto& entry : seen)
    lost += !is_measured(kept.at(entry.first.first, entry.first.second));
  EXPECT_EQ(lost, 0u);
  const Off off = off_ground(kept, 0, 0);
  EXPECT_LT(off.most_m, 0.005);
  EXPECT_EQ(kept.cell(15, 3).seen_s, static_cast<std::uint32_t>(frames.back().stamp_s));
  const std::uint32_t left_s = kept.cell(-1, 0).seen_s;
  EXPECT_NEAR(left_s - frames.front().stamp_s, 1.5, 1) << "when it left the window";
  EXPECT_EQ(kept.mapper.floor(), 0);
  ASSERT_EQ(kept.site.ways.size(), 1u);
  const auto& way = kept.site.ways.front();
  EXPECT_NEAR(static_cast<double>(way.size()), 14, 3) << "about a point a metre";
  EXPECT_NEAR(way.front().x_m, 0, 0.01);
  EXPECT_NEAR(way.back().x_m, 16, 0.5);
  EXPECT_NEAR(way.back().y_m, 3, 0.2);
}

TEST(SiteMapper, keeps_the_judgement_of_when_all_around_a_cell_was_in_the_window)
{
  // Kerbs across the way: at the edge of the window half of one is out of sight.
  const auto frames = drive(
      "ground: [plane: {}, step: {at_m: [4, 0], height_m: 0.22}, step: {at_m: [7, 0], height_m: "
      "-0.22}]\n"
      "objects: [posts: {from_m: [0, 2], to_m: [12, 2.5], count: 12, height_m: 0.8, radius_m: "
      "0.1}]\n"
      "robot: {path_m: [[0, 0], [16, 0]], speed_mps: 2}\n");
  constexpr int kEdge = 3;
  KeptDrive kept;
  std::map<std::pair<std::int64_t, std::int64_t>, float> judged;
  kept.add(
      frames,
      [&](std::size_t)
      {
        const Window w = kept.map.window();
        const auto& layer = kept.map.layer(Layer::Traversability);
        for (int y = kEdge; y < w.cells - kEdge; ++y)
          for (int x = kEdge; x < w.cells - kEdge; ++x)
            judged[{w.min_cell_x + x, w.min_cell_y + y}] =
                layer[static_cast<std::size_t>(y * w.cells + x)];
      });
  int compared = 0, blocked = 0, other = 0;
  for (const auto& [at, before] : judged)
  {
    if (at.first >= kept.map.window().min_cell_x) continue;
    const SiteCell c = kept.at(at.first, at.second);
    if (!is_measured(c)) continue;
    ++compared;
    blocked += before == 0;
    other += (c.cell.traversability == 0) != (before == 0);
  }
  EXPECT_GT(compared, 10000);
  EXPECT_GT(blocked, 300);
  EXPECT_LT(other, blocked / 20) << "of " << blocked;
}

TEST(SiteMapper, a_robot_that_turns_round_finds_the_map_that_it_made)
{
  const auto frames = drive(
      kFlat +
      "objects: [box: {at_m: [2, 1.5], size_m: [0.5, 0.5, 0.6]}]\n"
      "robot: {path_m: [[0, 0], [9, 0], [9.6, 0.3], [9, 0.6], [0, 0.6]], speed_mps: 2}\n");
  KeptDrive kept, forgets(false);
  int came_back = 0, forgotten = 0, seams = 0;
  const auto is_box = [](const Window& w, std::size_t k)
  {
    const double x = w.min_x_m() + static_cast<double>(k % 160) * 0.05 - 2;
    const double y = w.min_y_m() + static_cast<double>(k / 160) * 0.05 - 1.5;
    return std::abs(x) < 0.5 && std::abs(y) < 0.5;
  };
  const auto count_measured = [](KeptDrive& k)
  {
    int n = 0;
    for (const float s : k.map.layer(Layer::State)) n += s == 1;
    return n;
  };
  for (std::size_t i = 0; i < frames.size(); ++i)
  {
    std::vector<float> told;
    kept.mapper.update(kept.map, frames[i].view(), [&] { told = kept.map.layer(Layer::State); });
    forgets.mapper.update(forgets.map, frames[i].view());
    const auto &state = kept.map.layer(Layer::State),
               &ground = kept.map.layer(Layer::GroundElevation);
    ASSERT_EQ(told, state) << "what comes back is there";
    for (std::size_t k = 0; k < state.size(); ++k)
      seams += state[k] == 1 && !(std::abs(ground[k]) < 0.005f) && !is_box(kept.map.window(), k);
    if (frames[i].time_s < 7 || frames[i].time_s > 9) continue;
    came_back += count_measured(kept);
    forgotten += count_measured(forgets);
  }
  EXPECT_EQ(seams, 0);
  EXPECT_GT(came_back, forgotten + forgotten / 20);
  EXPECT_NEAR(kept.in_window(Layer::Elevation, 2.1, 1.4), 0.6, 0.02) << "the box";
}

TEST(SiteMapper, without_restoring_cells_that_come_back_start_empty)
{
  const auto frames = drive(kStraight);
  constexpr std::ptrdiff_t kHalf = 160 * 75;  // of the cells, on the other side
  std::vector<ScanFrame> there_and_away{frames.front(), frames.back(), frames.front()};
  ScanFrame& again = there_and_away.back();  // sees one side only
  for (std::size_t i = 0; i < again.y_m.size(); ++i)
    if (again.y_m[i] < 0) again.x_m[i] = NAN;
  KeptDrive kept, forgets(false);
  kept.add(there_and_away);
  forgets.add(there_and_away);
  for (KeptDrive* k : {&kept, &forgets})
  {
    const auto& state = k->map.layer(Layer::State);
    const auto measured = std::count(state.begin(), state.begin() + kHalf, 1.0f);
    EXPECT_EQ(measured > 200, k == &kept) << measured;
  }
  forgets.end();
  EXPECT_GT(off_ground(forgets, 0, 0, -2, 2).cells, 100) << "unknown cells erase nothing";
}

TEST(SiteMapper, where_poses_have_drifted_what_comes_back_is_no_wall)
{
  constexpr double kDrift = 0.01;
  const std::string way = "[12, 0], [12, 10], [0, 10], [0, 0]";
  const auto frames =
      drive(kFlat + "robot: {path_m: [[0, 0], " + way + ", " + way + "], speed_mps: 2}\n", kDrift);
  KeptDrive kept, forgets(false);
  const auto blocked = [](const KeptDrive& k)
  {
    const auto& layer = k.map.layer(Layer::Traversability);
    return std::count(layer.begin(), layer.end(), 0.0f);
  };
  std::ptrdiff_t with = 0, without = 0;
  for (const ScanFrame& f : frames)
  {
    kept.mapper.update(kept.map, f.view());
    forgets.mapper.update(forgets.map, f.view());
    with += blocked(kept);
    without += blocked(forgets);
  }
  const auto cells = static_cast<std::ptrdiff_t>(frames.size()) * 160 * 160;
  EXPECT_LT(with - without, cells / 2000) << "of " << cells;
  EXPECT_LT(without, cells / 20000);
}

TEST(SiteMapper, a_lift_to_another_floor_and_back_gives_two_floors)
{
  const auto frames = drive(
      kFlat +
      "objects:\n- deck: {at_m: [0, 0], size_m: [20, 16], z_m: 3.2}\n"
      "- box: {at_m: [2.25, 1], size_m: [0.5, 0.5, 0.6]}\n"
      "- box: {at_m: [-2.25, -1], size_m: [0.5, 0.5, 0.6], lift_m: 3.2}\n"
      "robot: {path_m: [[-4, 0], [4, 0], [4, 0.5], [-4, 0.5], [-4, 0], [4, 0]], speed_mps: 2,\n"
      "  lifts: [{time_s: 4.1, z_m: 3.2}, {time_s: 8.4, z_m: -3.2}]}\n");
  KeptDrive kept;
  std::vector<int> floors;
  kept.add(frames, [&](std::size_t) { note_floor(kept, floors); });
  kept.end();
  EXPECT_EQ(floors, (std::vector<int>{0, 1, 0}));
  const Off lower = off_ground(kept, 0, 0), upper = off_ground(kept, 1, 3.2);
  EXPECT_GT(lower.cells, 10000);
  EXPECT_GT(upper.cells, 10000);
  EXPECT_EQ(lower.far, 0);
  EXPECT_EQ(upper.far, 0);
  EXPECT_NEAR(highest(kept, 2, 2.5, 0.7, 1.3, 0), 0.6, 0.05);
  EXPECT_NEAR(highest(kept, -2.5, -2, -1.3, -0.7, 1), 3.8, 0.05);
  EXPECT_LT(highest(kept, -2.5, -2, -1.3, -0.7, 0), 0.1);
  EXPECT_LT(highest(kept, 2, 2.5, 0.7, 1.3, 1), 3.3);
}

TEST(SiteMapper, on_the_way_down_a_ramp_the_robot_comes_back_to_the_floor_that_it_left)
{
  const auto frames = drive(
      "ground:\n- plane: {}\n"
      "- ramp: {at_m: [3, 8], length_m: 8, height_m: 2.2, width_m: 3.4, top_m: 0}\n"
      "objects:\n- deck: {at_m: [16.4, 4], size_m: [10.8, 14], z_m: 2.2}\n"
      "robot: {path_m: [[14, 0], [6, 0], [0, 0], [-2, 4], [0, 8], [4, 8], [14, 8], [17, 4], "
      "[14, 0], [17, 4], [14, 8], [4, 8], [0, 8], [-2, 4], [0, 0], [6, 0], [14, 0]], speed_mps: "
      "2}\n");
  KeptDrive kept;
  std::vector<int> floors;
  kept.add(frames, [&](std::size_t) { note_floor(kept, floors); }).end();
  EXPECT_EQ(floors, (std::vector<int>{0, 1, 0}));
  const Off lower = off_ground(kept, 0, 0, 12, 16, -2, 2);
  const Off upper = off_ground(kept, 1, 2.2, 12, 16, -2, 2);
  EXPECT_GT(lower.cells, 4000);
  EXPECT_GT(upper.cells, 4000);
  EXPECT_EQ(lower.far, 0);
  EXPECT_EQ(upper.far, 0);
  EXPECT_EQ(kept.site.tiles.keys().back().floor, 1) << "there is no third one";
}

/** Two turns of a narrow ramp that winds up around a post of air: decks in steps of 5 cm. */
struct Helix
{
  static constexpr double kRadius_m = 3, kWidth_m = 5, kRise_m = 2.4;  //!< rise of a turn

  static std::string world()
  {
    constexpr double kStep_m = 0.05, kPi = 3.14159265358979;
    const int steps = static_cast<int>(std::lround(kRise_m / kStep_m));
    const std::string size = "size_m: [" + std::to_string(1.35 * 2 * kPi * kRadius_m / steps) +
                             ", " + std::to_string(kWidth_m) + "]";
    std::string decks, way = "[0, " + std::to_string(-kRadius_m) + "]";
    for (int i = 1; i <= 2 * steps; ++i)
    {
      const double turn = static_cast<double>(i) / steps, a = 2 * kPi * turn;
      const std::string at = "[" + std::to_string(kRadius_m * std::sin(a)) + ", " +
                             std::to_string(-kRadius_m * std::cos(a)) + "]";
      decks += "- deck: {at_m: " + at + ", " + size + ", yaw_deg: " + std::to_string(360 * turn) +
               ", z_m: " + std::to_string(i * kStep_m) + "}\n";
      if (i % 3 == 0) way += ", " + at;
    }
    return kFlat + "objects:\n" + decks + "robot: {path_m: [" + way + "], speed_mps: 1.5}\n";
  }
};

TEST(SiteMapper, a_turn_of_a_helix_begins_one_floor)
{
  KeptDrive kept;
  kept.add(drive(Helix::world())).end();
  EXPECT_LE(kept.site.tiles.keys().back().floor, 2) << "two turns, and the end of the second";
  int lower = 0, upper = 0;
  kept.for_each_known(
      0,
      [&](const SiteCell& c, double x, double y)
      {
        const bool on_ramp = std::abs(std::hypot(x, y) - Helix::kRadius_m) < Helix::kWidth_m / 2;
        if (!on_ramp || !is_measured(c)) return;
        const double part = std::atan2(x, -y) / 6.28318530717959;
        const double above_m = c.cell.ground_m - Helix::kRise_m * (part < 0 ? part + 1 : part);
        lower += above_m < Helix::kRise_m / 2;
        upper += above_m > Helix::kRise_m / 2;
      });
  EXPECT_GT(lower, 20000);
  EXPECT_LT(upper, lower / 100) << "heights of the turn above";
}

TEST(SiteMapper, goes_on_with_a_site_that_there_was_before)
{
  const auto frames = drive(kStraight);
  const std::ptrdiff_t half = static_cast<std::ptrdiff_t>(frames.size() / 2);
  KeptDrive kept;
  kept.add({frames.begin(), frames.begin() + half}).end();
  ElevationMapper map(Parameters(), Backend::Cpu);
  SiteMapper next_day(kept.site);
  next_day.update(map, frames[static_cast<std::size_t>(half)].view());
  int measured = 0;
  for (const float s : map.layer(Layer::State)) measured += s == 1;
  EXPECT_GT(measured, 4000) << "restored with the first frame";
  EXPECT_EQ(next_day.floor(), 0);
  EXPECT_EQ(kept.site.ways.size(), 2u);
}

namespace
{
/** Drives there and back. Points have a value on the way out only: what they hit stands or not. */
struct ValuedDrive : KeptDrive
{
  explicit ValuedDrive(const std::string& channels) : KeptDrive(true, channels)
  {
    const std::string world =
        "ground: [plane: {}]\n"
        "objects: [box: {at_m: [3, 1.5], size_m: [0.6, 0.6, 0.5]}]\n"
        "robot: {path_m: [[0, 0], [9, 0], [0, 0]], speed_mps: 2}\n";
    const auto frames = drive(world);
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
      Frame frame = frames[i].view();
      std::vector<float> values;
      for (std::size_t p = 0; p < frame.size; ++p)
        values.push_back(frame.z_m[p] > -0.6F ? 7.0F : 3.0F);
      const bool goes_out = i < frames.size() / 2;
      if (goes_out && !map.parameters().channels.empty()) frame.channels[0] = values.data();
      mapper.update(map, frame);
      if (i == frames.size() / 2) keep_of_middle();
    }
    end();
  }
  float kept(double x_m, double y_m, std::size_t layer)
  {
    const auto x = static_cast<std::int64_t>(std::floor(x_m / site.resolution_m));
    const auto y = static_cast<std::int64_t>(std::floor(y_m / site.resolution_m));
    const bool has_tile = site.channel_tiles.has({0, tile_of(x), tile_of(y)});
    return has_tile ? test::value_at(site, x, y, layer) : NAN;
  }
  void keep_of_middle()
  {
    at_end_of_window = map.window().index_at(2.5, 0.5).has_value();
    standing_in_middle = kept(2.75, 1.25, 1);
    for (int i = 0; i < 40; ++i)
      for (int k = 0; k < 40; ++k)
        if (const double x_m = 2.025 + 0.05 * i, y_m = -1.975 + 0.05 * k; kept(x_m, y_m, 0) == 3)
          ground_in_middle.emplace_back(x_m, y_m);
  }

  bool at_end_of_window = false;
  float standing_in_middle = NAN;
  std::vector<std::pair<double, double>> ground_in_middle;  //!< where the value is known
};
}  // namespace

TEST(SiteMapper, KeepsChannelsOfWhatLeavesAndGivesThemBack)
{
  for (const std::string rule : {"vote", "mean"})
  {
    ValuedDrive kept("sort:" + rule);
    EXPECT_FALSE(kept.at_end_of_window);
    EXPECT_EQ(kept.standing_in_middle, 7) << rule << ", behind the robot";
    EXPECT_GT(kept.ground_in_middle.size(), 300U) << rule;
    const MapView now(kept.map);
    std::size_t back = 0;
    for (const auto& [x_m, y_m] : kept.ground_in_middle) back += now.at("sort", x_m, y_m) == 3;
    EXPECT_GE(back, kept.ground_in_middle.size() * 98 / 100) << rule << ", seen without a value";
    EXPECT_EQ(now.at("sort_standing", 2.75, 1.25), 7) << rule;
    EXPECT_TRUE(std::isnan(now.at("sort_standing", 2.5, 0.5))) << "nothing stands there";
    EXPECT_EQ(kept.kept(2.75, 1.25, 1), 7) << rule;
    EXPECT_EQ(channels_text(kept.site.channels), "sort:" + rule);
  }
}

TEST(SiteMapper, KeepsNothingOfChannelsThatNobodyAskedFor)
{
  ValuedDrive kept("");
  EXPECT_TRUE(kept.site.channels.empty());
  EXPECT_TRUE(kept.site.channel_tiles.keys().empty());
  EXPECT_EQ(kept.site.channel_tiles.memory().open, 0U);
}
