// What the map promises where the world, the robot or its localisation does what a calm drive does
// not: lifts and decks, poses that jump, several and tilted sensors, sweeps in
// pieces, the robot's own body, grass. Each test prints what it measured.
#include <gtest/gtest.h>
#include <talus/baselines/evaluate.h>
#include <talus/baselines/window_truth.h>
#include <talus/frame_gatherer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <sstream>

using namespace talus;
using namespace talus::baselines;

namespace
{
/** A figure for the report of the test. */
void record(const std::string& name, double value)
{
  std::ostringstream text;
  text << value;
  testing::Test::RecordProperty(name, text.str());
}

/** A figure against its budget; the report holds it too. */
void expect_at_least(const std::string& name, double value, double limit)
{
  record(name, value);
  EXPECT_GE(value, limit) << name;
}
void expect_at_most(const std::string& name, double value, double limit)
{
  record(name, value);
  EXPECT_LE(value, limit) << name;
}

Parameters with_window_m(double window_m)
{
  Parameters p;
  p.window_m = window_m;
  return p;
}

/** A world and the frames of a drive through it. */
struct Stage
{
  explicit Stage(const std::string& text, const sim::DriveOptions& options = {})
      : world(sim::parse_world("seed: 5\n" + text, "test.yaml")),
        drive(world, options),
        frames(simulate(world, drive).frames)
  {
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /** Number of frames before a time. */
  std::size_t until(double time_s) const
  {
    const auto at = std::find_if(
        frames.begin(), frames.end(),
        [&](const ScanFrame& f) { return f.time_s >= time_s - 1e-6; });
    return static_cast<std::size_t>(at - frames.begin());
  }

  sim::World world;
  sim::Drive drive;
  std::vector<ScanFrame> frames;
};

/** The map, asked as the scores ask: free, blocked, or neither where it is unknown. */
class Map
{
 public:
  explicit Map(const Parameters& p = {}) : map_(p, Backend::Cpu) {}
  Map(const Parameters& p, const std::vector<std::uint8_t>& state) : map_(p, state, Backend::Cpu) {}

  void add(const ScanFrame& frame) { map_.update(frame.view()); }
  void gather(const std::vector<ScanFrame>& parts)
  {
    for (const ScanFrame& part : parts)
      gatherer_.add(part.view(), [this](const Frame& scan) { map_.update(scan); });
  }
  void add(const std::vector<ScanFrame>& frames, std::size_t from, std::size_t to)
  {
    for (std::size_t i = from; i < std::min(to, frames.size()); ++i) add(frames[i]);
  }
  std::vector<std::uint8_t> save() const { return map_.save(); }

  Window window() const { return map_.window(); }
  std::size_t size() const { return map_.layer(Layer::State).size(); }
  bool passable(std::size_t k) const { return map_.layer(Layer::Traversability)[k] > 0; }
  bool blocked(std::size_t k) const { return map_.layer(Layer::Traversability)[k] == 0; }
  bool known(std::size_t k) const { return state(k) != CellState::Unknown; }
  bool measured(std::size_t k) const { return state(k) == CellState::Measured; }
  float ground_m(std::size_t k) const { return map_.layer(Layer::GroundElevation)[k]; }

  /** The cell of (x, y), which must be in the window. */
  std::size_t cell(double x_m, double y_m) const
  {
    return static_cast<std::size_t>(cell_index(window(), x_m, y_m));
  }
  double x_m(std::size_t k) const
  {
    const Window w = window();
    return w.min_x_m() +
           (static_cast<double>(k % static_cast<std::size_t>(w.cells)) + 0.5) * w.resolution_m;
  }
  double y_m(std::size_t k) const
  {
    const Window w = window();
    return w.min_y_m() +
           (static_cast<double>(k / static_cast<std::size_t>(w.cells)) + 0.5) * w.resolution_m;
  }

 private:
  CellState state(std::size_t k) const
  {
    return static_cast<CellState>(map_.layer(Layer::State)[k]);
  }

  ElevationMapper map_;
  FrameGatherer gatherer_;
};

/** What is really in the window of a map, on the floor of a height where there are several. */
class TruthOf
{
 public:
  TruthOf(const Map& map, const sim::World& world, double time_s, double level_m = 0)
  {
    sim::TruthOptions options = TruthMap::truth_options(Parameters(), true);
    options.level_m = level_m;
    options.samples = 3;
    const Window w = map.window();
    cells_ = w.cells;
    truth_ = sim::truth(
        world, {w.min_x_m(), w.min_y_m(), w.cells, w.cells, w.resolution_m}, time_s, options);
  }

  bool blocked(std::size_t k) const { return truth_.label[k] == 0; }
  /** Free, and so is all within so many cells. */
  bool free(std::size_t k, int around_cells) const
  {
    const int x = static_cast<int>(k) % cells_, y = static_cast<int>(k) / cells_;
    for (int dy = -around_cells; dy <= around_cells; ++dy)
      for (int dx = -around_cells; dx <= around_cells; ++dx)
      {
        const int i = x + dx, j = y + dy;
        if (i < 0 || j < 0 || i >= cells_ || j >= cells_) continue;
        if (truth_.label[j * cells_ + i] != 1) return false;
      }
    return true;
  }

 private:
  int cells_ = 0;
  sim::Truth truth_;
};

/** Of the cells that `which` names, the share for which `holds`. */
using Holds = bool (Map::*)(std::size_t) const;
template <class Which>
Share share_of(const Map& map, Holds holds, const Which& which)
{
  Share share;
  for (std::size_t k = 0; k < map.size(); ++k)
    if (which(k)) share.add((map.*holds)(k));
  return share;
}

/** Of the known cells that are free with all around them, the share that is blocked. */
double free_blocked(const Map& map, const TruthOf& truth)
{
  return share_of(map, &Map::blocked, [&](auto k) { return map.known(k) && truth.free(k, 2); })
      .value();
}

/** How many cells in a box of the map frame are not passable. */
double not_passable(const Map& map, double min_x, double max_x, double min_y, double max_y)
{
  const auto in_box = [&](auto k)
  { return map.x_m(k) > min_x && map.x_m(k) < max_x && map.y_m(k) > min_y && map.y_m(k) < max_y; };
  const Share passable = share_of(map, &Map::passable, in_box);
  return passable.of - passable.part;
}

/** A box on the floor to which a lift takes the robot, which is there at a time: it blocks as on a
 * map that has only seen that floor. */
void expect_box_after_lift(const std::string& objects, const std::string& robot, double there_s)
{
  const Stage stage(
      "ground: [plane: {}]\nobjects:\n" + objects +
      "- box: {at_m: [2.25, 0], size_m: [0.5, 1, 0.6], lift_m: 3.2}\n" + robot);
  const std::size_t raised = stage.until(there_s);
  Map map, fresh;
  map.add(stage.frames, 0, raised + 3);
  fresh.add(stage.frames, raised, raised + 3);
  const auto of_box = [](const Map& m) { return not_passable(m, 2, 2.5, -0.5, 0.5); };
  ASSERT_GT(of_box(fresh), 0);
  expect_at_least("box_cells_not_passable", of_box(map), 0.98 * of_box(fresh));
}

TEST(Floors, ABoxOnTheFloorToWhichTheRobotIsRaisedBlocksAsOnAFreshMap)
{
  expect_box_after_lift(
      "- wall: {from_m: [-3, 3], to_m: [3, 3], height_m: 2}\n"
      "- box: {at_m: [2.6, -1.5], size_m: [0.5, 0.5, 0.8]}\n"
      "- deck: {at_m: [0, 0], size_m: [16, 16], z_m: 3.2}\n",
      "robot: {path_m: [[-2, 0], [0, 0]], duration_s: 3.25, lifts: [{time_s: 3, z_m: 3.2}]}\n", 3);
}

TEST(Floors, ABoxBesideALiftThatRisesSlowlyBlocksAsOnAFreshMap)
{
  expect_box_after_lift(
      "- wall: {from_m: [-0.8, -1], to_m: [-0.8, 1], height_m: 3.2}\n"
      "- wall: {from_m: [-0.8, 1], to_m: [0.8, 1], height_m: 3.2}\n"
      "- wall: {from_m: [-0.8, -1], to_m: [0.8, -1], height_m: 3.2}\n"
      "- deck: {at_m: [5, 0], size_m: [8.4, 10], z_m: 3.2}\n"
      "- deck: {at_m: [-5, 0], size_m: [8.4, 10], z_m: 3.2}\n",
      "sensor: {rate_hz: 5}\n"
      "robot: {path_m: [[0, 0]], duration_s: 7.5, lifts: [{time_s: 1, duration_s: 6, z_m: 3.2}]}\n",
      7);
}

TEST(Floors, ACarOnTheUpperDeckOfACarParkBlocksAsOnAMapOfThatDeckOnly)
{
  // Up a ramp of ten degrees; a car stands on the lower deck where the upper one has free floor.
  const Stage stage(
      "ground:\n"
      "- plane: {}\n"
      "- ramp: {at_m: [4, 0], length_m: 12, height_m: 2.2, width_m: 3.4, top_m: 0}\n"
      "objects:\n"
      "- deck: {at_m: [22, 0], size_m: [12, 14], z_m: 2.2}\n"
      "- box: {at_m: [20, 3.5], size_m: [4, 1.8, 1.2], lift_m: 0.2}\n"
      "- box: {at_m: [13, 3.5], size_m: [4, 1.8, 1.2], lift_m: 0.2}\n"
      "- box: {at_m: [20.5, -2.5], size_m: [4, 1.8, 1.2], lift_m: 2.4}\n"
      "sensor: {scanner: VLP-16, at_m: [0, 0, 0.9], rate_hz: 5}\n"
      "robot: {path_m: [[2, 0], [18, 0]], speed_mps: 2}\n");
  const Parameters p = with_window_m(12);
  const std::size_t up = stage.until(7.2);
  Map map(p), fresh(p);
  map.add(stage.frames, 0, stage.frames.size());
  fresh.add(stage.frames, up, stage.frames.size());
  const auto of_car = [](const Map& m) { return not_passable(m, 18.5, 22.5, -3.4, -1.6); };
  ASSERT_GT(of_car(fresh), 0);
  // Inside the car, which nobody has seen, rays passed low over the floor below: two thirds hold.
  expect_at_least("car_cells_not_passable", of_car(map), 0.65 * of_car(fresh));
  // On the deck: beside the ramp, which the map has seen, it does drop.
  const TruthOf truth(map, stage.world, stage.frames.back().time_s, 2.2);
  const auto blocked = [&truth](const Map& m)
  {
    const auto on_deck = [&](auto k) { return m.known(k) && m.x_m(k) > 16.5 && truth.free(k, 2); };
    return share_of(m, &Map::blocked, on_deck).value();
  };
  // What the ramp showed to drop there stays so until it is measured.
  expect_at_most("floor_blocked", blocked(map), blocked(fresh) + 0.11);
}

const char* const kYard =
    "ground: [plane: {}]\n"
    "objects:\n"
    "- box: {at_m: [8, 1.6], size_m: [0.6, 0.6, 0.8]}\n"
    "- box: {at_m: [5, -1.8], size_m: [0.5, 0.8, 0.5]}\n"
    "- post: {at_m: [7, -1.2], height_m: 1.2, radius_m: 0.05}\n"
    "- wall: {from_m: [2, 3], to_m: [10, 3], height_m: 1.5}\n";

/** Of neighbours that are known, were measured by a drive without errors, and are free with all
 * around them, the number between which the ground steps by more than 5 cm. The yard is level: a
 * turned map rises by less from cell to cell. */
int steps(const Map& map, const Map& calm, const TruthOf& truth)
{
  constexpr float kMax_m = 0.05f;
  const auto n = static_cast<std::size_t>(map.window().cells);
  std::vector<std::uint8_t> asked(map.size());
  for (std::size_t k = 0; k < map.size(); ++k)
    asked[k] = map.known(k) && calm.measured(k) && truth.free(k, 3);
  int count = 0;
  for (std::size_t k = 0; k < map.size(); ++k)
    for (const std::size_t next : {k + 1, k + n})
    {
      if (next >= map.size() || (next == k + 1 && next % n == 0)) continue;
      if (!asked[k] || !asked[next]) continue;
      count += std::abs(map.ground_m(k) - map.ground_m(next)) > kMax_m;
    }
  return count;
}

/** A drive of 6 m, then a rest: the map of it just before a time, once for all corrections. */
class PoseJump : public testing::TestWithParam<std::pair<const char*, const char*>>
{
 protected:
  static constexpr int kFrames = 3;

  static std::string way(double jump_s, const std::string& jump)
  {
    std::ostringstream text;
    text << kYard << "robot: {path_m: [[0.02, 0], [6.02, 0]], duration_s: 7}\n";
    if (!jump.empty()) text << "poses: {jumps: [{time_s: " << jump_s << ", " << jump << "}]}\n";
    return text.str();
  }
  static const Stage& calm()
  {
    static const Stage stage(way(0, ""));
    return stage;
  }
  static const std::vector<std::uint8_t>& map_before(double jump_s)
  {
    static std::map<double, std::vector<std::uint8_t>> known;
    auto& state = known[jump_s];
    if (state.empty())
    {
      Map map;
      map.add(calm().frames, 0, calm().until(jump_s));
      state = map.save();
    }
    return state;
  }

  static bool turns() { return std::string(GetParam().second).find("_deg") != std::string::npos; }

  void measure(double jump_s)
  {
    const sim::World world = sim::parse_world(way(jump_s, GetParam().second), "test.yaml");
    const sim::Drive told(world);
    const std::size_t first = calm().until(jump_s);
    Map map(Parameters(), map_before(jump_s)), calm_map(Parameters(), map_before(jump_s));
    for (std::size_t i = first; i < first + kFrames; ++i)
    {
      calm_map.add(calm().frames[i]);
      ScanFrame frame = calm().frames[i];
      frame.T_map_sensor =
          sim::compose(told.T_map_base_noisy(static_cast<int>(i)), *frame.T_base_sensor);
      map.add(frame);
    }
    const TruthOf truth(calm_map, calm().world, jump_s);
    ASSERT_EQ(map.window().min_cell_x, calm_map.window().min_cell_x);
    expect_at_most(
        "free_cells_blocked", free_blocked(map, truth), free_blocked(calm_map, truth) + 0.01);
    // A turned pose leaves what is out of sight as it was: the map follows heights only.
    const int most = turns() ? static_cast<int>(map.size()) : steps(calm_map, calm_map, truth);
    expect_at_most("steps_over_5cm", steps(map, calm_map, truth), most);
  }
};

TEST_P(PoseJump, WhileItDrivesBlocksNoFreeGround) { measure(5); }
TEST_P(PoseJump, WhileItStandsBlocksNoFreeGround) { measure(6.5); }

INSTANTIATE_TEST_SUITE_P(
    Of, PoseJump,
    testing::Values(
        std::pair("Up35cm", "z_m: 0.35"), std::pair("Down35cm", "z_m: -0.35"),
        std::pair("Up10cm", "z_m: 0.1"), std::pair("Down10cm", "z_m: -0.1"),
        std::pair("Up1m", "z_m: 1"), std::pair("Down1m", "z_m: -1"),
        std::pair("Roll1Degree", "roll_deg: 1"), std::pair("Pitch1Degree", "pitch_deg: 1")),
    [](const auto& kind) { return std::string(kind.param.first); });

/** The worst that a drift of 1 cm/s for 30 s does, compared with none. */
void drift(const std::string& path, double way_m)
{
  std::ostringstream text;
  text << "ground: [plane: {}]\nobjects:\n";
  for (double x = 3; x < way_m + 5; x += 3)
    text << "- box: {at_m: [" << x << ", " << (std::lround(x) % 2 ? 1.7 : -1.7)
         << "], size_m: [0.5, 0.6, 0.6]}\n";
  text << "sensor: {rate_hz: 4}\nrobot: {path_m: " << path << ", duration_s: 30}\n"
       << "poses: {drift_mps: {z: 0.01}}\n";
  const Stage stage(text.str());
  Map map, calm;
  double worst = -1;
  for (std::size_t i = 0; i < stage.frames.size(); ++i)
  {
    map.add(stage.frames[i]);
    ScanFrame truly = stage.frames[i];
    truly.T_map_sensor = truly.T_true;
    calm.add(truly);
    if (i % 30 != 29) continue;
    const TruthOf truth(map, stage.world, truly.time_s);
    worst = std::max(worst, free_blocked(map, truth) - free_blocked(calm, truth));
  }
  expect_at_most("free_cells_blocked_more", worst, 0.01);
}

TEST(PoseDrift, WhileItDrivesBlocksNoFreeGround) { drift("[[0, 0], [30, 0]]", 30); }
TEST(PoseDrift, WhileItStandsBlocksNoFreeGround) { drift("[[-3, 0], [0, 0]]", 0); }

double measured(const std::vector<ScanFrame>& frames)
{
  Map map;
  map.add(frames, 0, frames.size());
  return share_of(map, &Map::measured, [](auto) { return true; }).value();
}

/** Two scanners, so far apart along the robot. */
class TwoSensors : public testing::TestWithParam<double>
{
 protected:
  static std::vector<ScanFrame> frames(double phase_s)
  {
    std::ostringstream text;
    text << kYard << "sensors:\n";
    for (const int side : {1, -1})
      text << "- {name: s" << 1 + side << ", scanner: VLP-16, rate_hz: 5, at_m: ["
           << 0.5 * side * GetParam() << ", 0, 0.9], phase_s: " << (side > 0 ? 0 : phase_s)
           << "}\n";
    text << "robot: {path_m: [[2, 0], [4, 0]], speed_mps: 1, duration_s: 2.19}\n";
    return Stage(text.str()).frames;
  }
  static std::vector<ScanFrame> of_one(const std::vector<ScanFrame>& all, std::uint32_t sensor)
  {
    std::vector<ScanFrame> out;
    for (const ScanFrame& f : all)
      if (f.sensor == sensor) out.push_back(f);
    return out;
  }
  static void measure(double phase_s)
  {
    const auto both = frames(phase_s);
    const double better = std::max(measured(of_one(both, 0)), measured(of_one(both, 1)));
    ASSERT_GT(better, 0.1);
    record("better_alone", better);
    expect_at_least("measured", measured(both), better);
  }
};

TEST_P(TwoSensors, InTurnsMeasureNoLessThanTheBetterAlone) { measure(0.1); }
TEST_P(TwoSensors, AtTheSameTimeMeasureNoLessThanTheBetterAlone) { measure(0); }

INSTANTIATE_TEST_SUITE_P(
    Apart, TwoSensors, testing::Values(0.8, 1.2, 6.0),
    [](const auto& far) { return std::to_string(std::lround(100 * far.param)) + "cm"; });

/** A drive of 2 m towards a box that is then 5 m away. */
Map map_of_mounting(const std::string& roll_pitch_yaw_deg)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects: [box: {at_m: [7.25, 0], size_m: [0.5, 1.5, 0.9]}]\n"
      "sensor: {scanner: OS0-128, rate_hz: 5, at_m: [0, 0, 0.8], roll_pitch_yaw_deg: " +
      roll_pitch_yaw_deg + "}\nrobot: {path_m: [[0, 0], [2, 0]], speed_mps: 2}\n");
  Map map(with_window_m(12));
  map.add(stage.frames, 0, stage.frames.size());
  return map;
}

class Mounting : public testing::TestWithParam<std::pair<const char*, const char*>>
{
};

TEST_P(Mounting, ShowsFloorAndBoxAsUpright)
{
  static const Map upright = map_of_mounting("[0, 0, 0]");
  const Map tilted = map_of_mounting(GetParam().second);
  ASSERT_EQ(upright.window().min_cell_x, tilted.window().min_cell_x);
  const auto judge = [&](bool box, const Map& map)
  {
    return share_of(
        map, box ? &Map::blocked : &Map::passable,
        [&](auto k)
        {
          const double x = map.x_m(k), y = std::abs(map.y_m(k));
          const bool in_box = x > 7 && x < 7.5 && y < 0.75;
          const bool ahead = x > 2 && x < 6.8 && y < 2;
          return (box ? in_box : ahead) && upright.measured(k) && tilted.measured(k);
        });
  };
  const Share floor = judge(false, tilted), box = judge(true, tilted);
  expect_at_least("floor_cells_that_both_see", static_cast<double>(floor.of), 300);
  expect_at_least("box_cells_that_both_see", static_cast<double>(box.of), 5);
  expect_at_least("floor_passable", floor.value(), judge(false, upright).value() - 0.03);
  expect_at_least("box_blocked", box.value(), judge(true, upright).value() - 0.03);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Mounting,
    testing::Values(
        std::pair("Pitch30", "[0, 30, 0]"), std::pair("Pitch45", "[0, 45, 0]"),
        std::pair("Roll30", "[30, 0, 0]"), std::pair("UpsideDown", "[180, 0, 0]")),
    [](const auto& kind) { return std::string(kind.param.first); });

/** Ten frames of a tenth of the points each, chosen at random: a scanner without a pattern that
 * repeats, at 100 Hz. */
std::vector<ScanFrame> random_tenths(const ScanFrame& whole)
{
  std::vector<ScanFrame> tenths(10, whole);
  for (std::size_t k = 0; k < tenths.size(); ++k)
  {
    ScanFrame& f = tenths[k];
    f.stamp_s += 0.01 * static_cast<double>(k);
    f.x_m.clear(), f.y_m.clear(), f.z_m.clear();
  }
  std::mt19937 random(static_cast<std::uint32_t>(std::lround(1000 * whole.time_s)));
  for (std::size_t i = 0; i < whole.x_m.size(); ++i)
  {
    ScanFrame& f = tenths[random() % tenths.size()];
    f.x_m.push_back(whole.x_m[i]), f.y_m.push_back(whole.y_m[i]), f.z_m.push_back(whole.z_m[i]);
  }
  return tenths;
}

/** Of the obstacle cells that were hit, the share that is blocked at the end of a drive between
 * posts, a railing and a hedge. */
Share hit_and_blocked(const sim::DriveOptions& options, bool in_random_tenths = false)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- posts: {from_m: [3, -1.5], to_m: [10, -1.5], count: 15, height_m: 1, radius_m: 0.05}\n"
      "- railing: {from_m: [3, 1.6], to_m: [7, 1.6], height_m: 1}\n"
      "- foliage: {at_m: [9, 1.8], size_m: [3, 0.8, 1.2], form: box}\n"
      "- foliage: {at_m: [5, -2.8], size_m: [4, 0.8, 1.2], form: box}\n"
      "- box: {at_m: [9, 0], size_m: [0.5, 0.5, 0.5]}\n"
      "robot: {path_m: [[0, 0], [6, 0]]}\n",
      options);
  EvaluationOptions evaluation;
  const TruthMap truth = truth_of(stage.world, evaluation);
  Observed observed(truth, evaluation.parameters);
  Map map;
  for (const ScanFrame& f : stage.frames)
  {
    observed.add(f);
    if (in_random_tenths)
      map.gather(random_tenths(f));
    else
      map.add(f);
  }
  const Window w = map.window();
  Share share;
  for (std::size_t k = 0; k < map.size(); ++k)
  {
    const auto cells = static_cast<std::size_t>(w.cells);
    const int at = truth.index(
        w.min_cell_x + static_cast<std::int64_t>(k % cells),
        w.min_cell_y + static_cast<std::int64_t>(k / cells));
    if (at < 0) continue;
    const auto i = static_cast<std::size_t>(at);
    if (!truth.doubtful[i] && !truth.platform[i] && observed.shows_obstacle(i))
      share.add(map.blocked(k));
  }
  return share;
}

TEST(Sweeps, InPiecesInRandomTenthsOrFewShowObstaclesAsWholeOnes)
{
  sim::DriveOptions cut, few;
  cut.cut_frames = 10;
  few.every = 10;
  const Share whole = hit_and_blocked({}), pieces = hit_and_blocked(cut),
              tenth = hit_and_blocked(few), scattered = hit_and_blocked({}, true);
  EXPECT_GT(whole.of, 150);
  EXPECT_GT(tenth.of, 100);
  expect_at_least("whole_blocked", whole.value(), 0.9);
  expect_at_least("pieces_blocked", pieces.value(), whole.value() - 0.02);
  expect_at_least("every_tenth_blocked", tenth.value(), whole.value() - 0.03);
  expect_at_least("random_tenths_blocked", scattered.value(), whole.value() - 0.02);
}

/** Where a robot starts whose scanner looks over the ground around it. */
struct Start
{
  const Stage stage{
      "ground: [plane: {}]\nobjects:\n"
      "- box: {at_m: [1.25, 0], size_m: [0.5, 0.5, 0.8]}\n"
      "sensor: {scanner: VLP-16, at_m: [0, 0, 0.68]}\n"
      "robot: {path_m: [[0, 0]], duration_s: 0.5}\n"};

  /** Of the cells within 2.3 m that are beside and before the box, the share that is passable. */
  static double passable(const Map& map)
  {
    const auto near = [&](auto k)
    {
      const double x = map.x_m(k), y = map.y_m(k);
      return std::hypot(x, y) < 2.3 && (x < 0.85 || std::abs(y) > 0.35 + 0.3 * x);
    };
    return share_of(map, &Map::passable, near).value();
  }
};

TEST(Start, IsFreeAroundTheRobotAfterTheFirstFrameAndABoxBlocks)
{
  const Start start;
  Map map, later;
  map.add(start.stage.frames, 0, 1);
  later.add(start.stage.frames, 0, start.stage.frames.size());
  for (const Map* m : {&map, &later})
  {
    expect_at_least("passable", Start::passable(*m), 0.999);
    expect_at_least("face_cells_not_passable", not_passable(*m, 1, 1.05, -0.25, 0.25), 10);
  }
}

TEST(Start, IsUnknownWhereNothingIsToBePresumed)
{
  const Start start;
  Parameters p;
  p.start_radius_m = 0;
  Map map(p);
  map.add(start.stage.frames, 0, 1);
  expect_at_most("passable", Start::passable(map), 0.97);
  EXPECT_FALSE(map.known(map.cell(-0.375, 0.025)));
}

TEST(Body, WhoseBoxesAreKnownLeavesNothingInTheMap)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "robot: {path_m: [[0, 0], [3, 0]], body: [\n"
      "  box: {at_m: [0.7, 0, 0.2], size_m: [0.2, 0.6, 0.35]},\n"
      "  box: {at_m: [-0.6, 0.3, 0.3], size_m: [0.1, 0.1, 0.9]}]}\n");
  Parameters p;  // 10 cm around each: points have noise
  p.body_boxes_m = {{0.5, 0.9, -0.4, 0.4, 0.1, 0.65}, {-0.75, -0.45, 0.15, 0.45, 0.2, 1.3}};
  Map map(p);
  map.add(stage.frames, 0, stage.frames.size());
  const Share blocked = share_of(map, &Map::blocked, [&](auto k) { return map.known(k); });
  EXPECT_GT(blocked.of, 10000);
  expect_at_most("cells_blocked", static_cast<double>(blocked.part), 0);
}

TEST(Grass, IsPassableWhereTheRobotHasDrivenThroughIt)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- grass: {at_m: [5, 0], size_m: [12, 8], height_m: 0.45, density_per_m: 1}\n"
      "- box: {at_m: [3, 0], size_m: [0.5, 0.5, 1], from_s: 5.5}\n"
      "robot: {path_m: [[0, 0], [5.5, 0]], duration_s: 7}\n");
  Map map;
  const auto on_track = [&map](Holds holds, double min_x, double max_x)
  {
    return share_of(
        map, holds,
        [&](auto k)
        { return std::abs(map.y_m(k)) < 0.2 && map.x_m(k) > min_x && map.x_m(k) < max_x; });
  };
  map.add(stage.frames, 0, stage.until(5.5));
  const Share track = on_track(&Map::passable, 1.6, 5.2);
  EXPECT_GT(track.of, 500);
  expect_at_least("track_passable", track.value(), 0.92);
  map.add(stage.frames, stage.until(5.5), stage.frames.size());
  expect_at_least("face_of_the_box_blocked", on_track(&Map::blocked, 3.2, 3.25).value(), 0.9);
}

/** What a map shows of a place after a drive on level ground with a 16-beam scanner 0.68 m up,
 * which sees no floor within 2.5 m. */
class Drops
{
 public:
  Drops(const std::string& ground, const std::string& path_m, const std::string& scanner)
      : stage_(
            "ground:\n  - plane: {z_m: 0}\n" + ground + "robot: {path_m: " + path_m +
            "}\nsensor: {scanner: " + scanner + ", at_m: [0, 0, 0.68]}\n")
  {
    map_.add(stage_.frames, 0, stage_.frames.size());
  }
  /** Share of the cells of a rectangle. */
  double passable(double x0_m, double y0_m, double x1_m, double y1_m) const
  {
    double of = 0, all = 0;
    for (double x = x0_m + 0.025; x < x1_m; x += 0.05)
      for (double y = y0_m + 0.025; y < y1_m; y += 0.05, ++all)
        of += map_.passable(map_.cell(x, y));
    return of / all;
  }

 private:
  Stage stage_;
  Map map_;
};

TEST(Drops, ADitchBesideTheWayStaysImpassableInTheBlindZone)
{
  const std::string ditch =
      "  - ditch: {at_m: [5, -1.4], width_m: 0.8, depth_m: 0.45, bank_m: 0.2, length_m: 9}\n";
  for (const char* const scanner : {"RS-LiDAR-16", "VLP-16", "OS1-64"})
  {
    const Drops drive(ditch, "[[0, 0], [6, 0]]", scanner);
    expect_at_most("passable", drive.passable(4.5, -1.6, 8.5, -1.2), 0.05);
    expect_at_least("beside_it", drive.passable(4.5, -0.6, 8.5, 0.6), 0.99);
  }
}

TEST(Drops, AShaftAndTheEdgeOfADockStayImpassable)
{
  const Drops shaft(
      "  - ditch: {at_m: [6, 0], width_m: 2.2, depth_m: 4.5, length_m: 2.2}\n",
      "[[0, 0], [3.5, 0]]", "VLP-16");
  expect_at_most("shaft", shaft.passable(5.0, -0.9, 6.9, 0.9), 0.05);
  const Drops dock(
      "  - step: {at_m: [5, 0], height_m: -1.2}\n", "[[0, 0], [3.5, 0]]", "RS-LiDAR-16");
  expect_at_most("dock", dock.passable(5.1, -1, 6.5, 1), 0.05);
}

TEST(Drops, TheFarSideOfARampAKerbAndAShallowHollowStayPassable)
{
  const Drops ramp(
      "  - ramp: {at_m: [4, 0], length_m: 1.4, height_m: 0.375, top_m: 1, down_m: 1.4, width_m: "
      "2.4}\n",
      "[[0, 0], [5.9, 0]]", "RS-LiDAR-16");
  expect_at_least("ramp", ramp.passable(5.6, -0.8, 7.6, 0.8), 0.95);
  const Drops kerb("  - step: {at_m: [4, 0], height_m: -0.12}\n", "[[0, 0], [2, 0]]", "OS1-64");
  expect_at_least("kerb", kerb.passable(4.2, -1, 6, 1), 0.95);
  const Drops hollow(
      "  - ditch: {at_m: [4, 0], yaw_deg: 90, width_m: 1.2, depth_m: 0.12, bank_m: 0.3}\n",
      "[[0, 0], [2, 0]]", "OS1-64");
  expect_at_least("hollow", hollow.passable(3.5, -1, 4.5, 1), 0.95);
}

/** What a sensor of that range returns. */
ScanFrame within_m(const ScanFrame& frame, float range_m)
{
  ScanFrame near = frame;
  for (auto* v : {&near.x_m, &near.y_m, &near.z_m}) v->clear();
  for (std::size_t i = 0; i < frame.x_m.size(); ++i)
  {
    if (std::hypot(frame.x_m[i], frame.y_m[i], frame.z_m[i]) > range_m) continue;
    near.x_m.push_back(frame.x_m[i]), near.y_m.push_back(frame.y_m[i]);
    near.z_m.push_back(frame.z_m[i]);
  }
  return near;
}

TEST(Movers, ACarBehindWhichNoRayReturnsLeavesNothingAndAFenceBesideItsWayStays)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- railing: {from_m: [-3, 3.4], to_m: [4, 3.4], height_m: 1}\n"
      "movers:\n"
      "- box: {path: [[0.5, -4, 2.4], [4.5, 8, 2.4]], size_m: [2, 1, 0.8], lift_m: 0.2}\n"
      "robot: {path_m: [[0, 0], [1, 0]], duration_s: 6}\n"
      "sensor: {scanner: OS1-64}\n");
  Map map;
  for (const ScanFrame& frame : stage.frames) map.add(within_m(frame, 9));
  const TruthOf truth(map, stage.world, stage.frames.back().time_s);
  const Share way = share_of(
      map, &Map::blocked,
      [&](auto k)
      { return std::abs(map.y_m(k) - 2.4) < 0.6 && std::abs(map.x_m(k)) < 3 && truth.free(k, 1); });
  EXPECT_GT(way.of, 1000);
  expect_at_most("way_blocked", way.value(), 0.005);
  const Share fence = share_of(
      map, &Map::blocked,
      [&](auto k) { return truth.blocked(k) && map.y_m(k) > 3.3 && std::abs(map.x_m(k)) < 2; });
  EXPECT_GT(fence.of, 20);
  expect_at_least("fence_blocked", fence.value(), 0.9);
}

TEST(Movers, WhoFollowsTheRobotLeavesNothingInTheirOwnShadow)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- box: {at_m: [6, 2], size_m: [1, 1, 1]}\n"
      "- posts: {from_m: [2, -1.5], to_m: [8, -1.5], count: 7, height_m: 1, radius_m: 0.05}\n"
      "movers: [person: {path: [[0, -1.5, 0], [8, 6.5, 0]]}]\n"
      "robot: {path_m: [[0, 0], [8, 0]], speed_mps: 1}\n");
  Map map;
  map.add(stage.frames, 0, stage.frames.size());
  const TruthOf truth(map, stage.world, stage.frames.back().time_s);
  // Where they walked until three seconds ago.
  const auto left = [&](auto k)
  { return std::abs(map.y_m(k)) < 0.3 && map.x_m(k) > 4 && map.x_m(k) < 5 && truth.free(k, 1); };
  const Share trail = share_of(map, &Map::blocked, left);
  EXPECT_GT(trail.of, 200);
  expect_at_most("trail_blocked", trail.value(), 0.02);
  const Share posts =
      share_of(map, &Map::blocked, [&](auto k) { return truth.blocked(k) && map.y_m(k) < -1.4; });
  EXPECT_GT(posts.of, 10);
  expect_at_least("posts_blocked", posts.value(), 0.98);
}

/** Single points in the air, in place of what their rays would have met. */
void let_it_snow(ScanFrame& frame, int flakes, std::mt19937& random)
{
  const auto share = [&random] { return static_cast<float>(random() % 1024) / 1024.0F; };
  for (int i = 0; i < flakes; ++i)
  {
    const std::size_t k = random() % frame.x_m.size();
    const float range_m = std::hypot(frame.x_m[k], frame.y_m[k], frame.z_m[k]);
    const float at = share();
    if (at * range_m < 0.5F || range_m > 10) continue;
    for (auto* v : {&frame.x_m, &frame.y_m, &frame.z_m}) (*v)[k] *= at;
  }
}

TEST(Weather, SnowBlocksNothingAndPostsAndRailingsStay)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- box: {at_m: [6, 2.5], size_m: [1, 1, 1]}\n"
      "- posts: {from_m: [3, -1.5], to_m: [9, -1.5], count: 12, height_m: 1, radius_m: 0.03}\n"
      "- railing: {from_m: [3, 1.6], to_m: [7, 1.6], height_m: 1}\n"
      "robot: {path_m: [[0, 0], [6, 0]], duration_s: 8}\n");
  Map map, calm;
  std::mt19937 random(1);
  const std::size_t end = stage.until(7);
  const auto free_blocked_now = [&]
  { return share_of(map, &Map::blocked, [&](auto k) { return calm.passable(k); }).value(); };
  double mean = 0;
  for (std::size_t i = 0; i < end; ++i)
  {
    ScanFrame snow = stage.frames[i];
    let_it_snow(snow, 200, random);
    map.add(snow);
    calm.add(stage.frames[i]);
    mean += free_blocked_now() / static_cast<double>(end);
  }
  expect_at_most("free_blocked_while_it_snows", mean, 0.008);
  const Share kept = share_of(map, &Map::blocked, [&](auto k) { return calm.blocked(k); });
  EXPECT_GT(kept.of, 150);
  expect_at_least("blocked_as_without_snow", kept.value(), 0.98);
  for (std::size_t i = end; i < end + 2; ++i) map.add(stage.frames[i]), calm.add(stage.frames[i]);
  // What is hit beside what left waits for it, so that a flake may outlast the others.
  expect_at_most("free_blocked_two_frames_later", free_blocked_now(), 0.012);
}

/** Mirrors a share of the hits on a level floor: the ray goes on by the floor's reflection, so that
 * the point is measured below the floor, at the mirrored place of what stands farther away. */
void mirror_floor(ScanFrame& frame, const sim::Scene& scene, double share, std::mt19937& random)
{
  constexpr double kFloor_m = 0.03, kReach_m = 40;
  const sim::Vec3 from{frame.T_true.x(), frame.T_true.y(), frame.T_true.z()};
  for (std::size_t k = 0; k < frame.x_m.size(); ++k)
  {
    const sim::Vec3 at = sim::transform(frame.T_true, {frame.x_m[k], frame.y_m[k], frame.z_m[k]});
    if (std::abs(at.z) > kFloor_m || static_cast<double>(random() % 1024) / 1024 >= share) continue;
    const sim::Vec3 toward = sim::normalized({at.x - from.x, at.y - from.y, from.z - at.z});
    const auto hit = scene.cast({{at.x, at.y, 1e-3}, toward}, kReach_m);
    if (!hit) continue;
    const double range_m = std::hypot(frame.x_m[k], frame.y_m[k], frame.z_m[k]);
    const auto longer = static_cast<float>((range_m + hit->range_m) / range_m);
    for (auto* v : {&frame.x_m, &frame.y_m, &frame.z_m}) (*v)[k] *= longer;
  }
}

/** Of the level floor that is free, the share that is blocked where so much of it is mirrored. */
double glossy_floor_blocked(double share)
{
  const Stage stage(
      "ground: [plane: {}]\n"
      "objects:\n"
      "- wall: {from_m: [-6, 3], to_m: [14, 3], height_m: 3}\n"
      "- wall: {from_m: [-6, -3], to_m: [14, -3], height_m: 3}\n"
      "- wall: {from_m: [12, -3], to_m: [12, 3], height_m: 3}\n"
      "- box: {at_m: [4, 1.8], size_m: [0.8, 0.6, 0.9]}\n"
      "- box: {at_m: [8, -1.6], size_m: [0.6, 1, 1.2]}\n"
      "- posts: {from_m: [3, -2], to_m: [6, -2], count: 3, height_m: 2, radius_m: 0.1}\n"
      "robot: {path_m: [[0, 0], [6, 0]]}\n");
  const sim::Scene scene(stage.world, 0);
  std::mt19937 random(1);
  Map map;
  for (ScanFrame frame : stage.frames)
  {
    mirror_floor(frame, scene, share, random);
    map.add(frame);
  }
  return free_blocked(map, TruthOf(map, stage.world, stage.frames.back().time_s));
}

TEST(Reflections, OfAGlossyFloorBlockLittleOfIt)
{
  record("matt", glossy_floor_blocked(0));
  expect_at_most("two_of_100", glossy_floor_blocked(0.02), 0.015);
  expect_at_most("five_of_100", glossy_floor_blocked(0.05), 0.02);
  expect_at_most("twenty_of_100", glossy_floor_blocked(0.2), 0.1);
}

}  // namespace
