// How maps are scored against the truth: maps that are right, and maps that are wrong in one way.
#include <gtest/gtest.h>
#include <talus/baselines/budgets.h>
#include <talus/sim/world.h>

#include <cmath>

using namespace talus;
using namespace talus::baselines;

namespace
{
/** A robot at rest in a world, and the truth about it. */
class Stage
{
 public:
  explicit Stage(
      const std::string& rest, double duration_s = 0.05,
      const std::string& ground = "plane: {z_m: 0}")
      : world_(sim::parse_world(
            "ground: [" + ground + "]\n" + rest + "robot: {path_m: [[0, 0]], duration_s: " +
                std::to_string(duration_s) + "}\nsensor: {scanner: OS1-64}\n",
            "test.yaml")),
        truth(truth_of(world_, options_)),
        sequence(simulate(world_, sim::Drive(world_))),
        observed(truth, options_.parameters)
  {
    for (const ScanFrame& f : sequence.frames) observed.add(f);
    here = window_truth(
        truth, observed, nullptr, sequence.frames, sequence.frames.size() - 1, options_.parameters,
        nullptr, nullptr);
  }

  /** A map without any error. */
  Surfaces perfect() const
  {
    Surfaces s(here.window);
    for (std::size_t k = 0; k < s.size(); ++k)
    {
      const auto i = static_cast<std::size_t>(here.at[k]);
      s.ground_m[k] = truth.truth.ground[i];
      s.elevation_m[k] = truth.truth.ground[i] + truth.standing_m(i);
      s.traversability[k] = truth.blocked(i) ? 0.0f : 1.0f;
      s.state[k] = static_cast<std::uint8_t>(CellState::Measured);
    }
    return s;
  }

  Score score(const Surfaces& map) const
  {
    Score s;
    score_frame(map, truth, here, observed, s);
    return s;
  }

  std::size_t cell(double x_m, double y_m) const
  {
    return static_cast<std::size_t>(cell_index(here.window, x_m, y_m));
  }

 private:
  EvaluationOptions options_;
  sim::World world_;

 public:
  TruthMap truth;
  Sequence sequence;
  Observed observed;
  WindowTruth here;
};

const char* kBox = "objects: [box: {at_m: [2.5, 0], size_m: [0.5, 1.5, 0.6]}]\n";

TEST(Score, FindsNothingWrongWithAPerfectMap)
{
  const Stage stage(kBox);
  const Score s = stage.score(stage.perfect());
  EXPECT_EQ(s.all_measured_ground().rmse_m(), 0.0);
  EXPECT_EQ(s.obstacle_blocked.value(), 1.0);
  EXPECT_GT(s.obstacle_blocked.of, 5);
  EXPECT_EQ(s.free_passable_all.value(), 1.0);
  EXPECT_EQ(s.leak.value(), 0.0);
  EXPECT_EQ(s.reach.value(), 1.0);
  EXPECT_EQ(s.inflation_cells(), 0.0);
}

TEST(Score, CountsAnErrorOfAllGroundAsItsRmse)
{
  const Stage stage(kBox);
  Surfaces map = stage.perfect();
  for (float& h : map.ground_m) h += 0.02f;
  EXPECT_NEAR(stage.score(map).all_measured_ground().rmse_m(), 0.02, 1e-6);
}

TEST(Score, SeesPathsIntoAnObstacleThatTheMapDoesNotShow)
{
  const Stage stage(kBox);
  Surfaces map = stage.perfect();
  for (float& t : map.traversability) t = 1.0f;
  const Score s = stage.score(map);
  EXPECT_EQ(s.leak.value(), 1.0);
  EXPECT_EQ(s.leak.of, 8 * 28);  // 10 x 30 cells without their border
  EXPECT_EQ(s.obstacle_blocked.value(), 0.0);
}

TEST(Score, SeesAWallThatIsNotThereAsLostReach)
{
  const Stage stage("");
  Surfaces map = stage.perfect();
  const int n = map.window.cells;
  for (int iy = 0; iy < n; ++iy) map.traversability[iy * n + n / 2 + 20] = 0.0f;
  EXPECT_NEAR(stage.score(map).reach.value(), (n / 2 + 20.0) / n, 0.01);
}

TEST(Score, MeasuresInflationInCells)
{
  const Stage stage(kBox);
  Surfaces map = stage.perfect();
  for (std::size_t k = 0; k < map.size(); ++k)
    if (stage.truth.to_obstacle[stage.here.at[k]] <= 3) map.traversability[k] = 0.0f;
  EXPECT_EQ(stage.score(map).inflation_cells(), 3.0);
}

TEST(Score, JudgesCellsUnderATableByHeightAndByPassability)
{
  const Stage stage("objects: [table: {at_m: [2, 0], size_m: [1, 1, 0.8]}]\n");
  Surfaces map = stage.perfect();
  EXPECT_EQ(stage.score(map).hanging_wrong.value(), 0.0);
  EXPECT_EQ(stage.score(map).hanging_passable.value(), 1.0);
  map.elevation_m[stage.cell(2, 0)] = 0.8f;
  map.traversability[stage.cell(2, 0)] = 0.0f;
  const Score s = stage.score(map);
  EXPECT_EQ(s.hanging_wrong.part, 1);
  EXPECT_EQ(s.hanging_passable.of - s.hanging_passable.part, 1);
}

TEST(Score, JudgesFloorUnderATableThatNoRayMetApart)
{
  // Behind the wall only the upper part of the table is seen.
  const Stage stage(
      "objects: [box: {at_m: [1.2, 0], size_m: [0.2, 3, 0.6]}, table: {at_m: [2.2, 0], size_m: [1, "
      "1, 0.8]}]\n");
  Surfaces map = stage.perfect();
  for (double x = 2.0; x < 2.4; x += 0.05)
    map.ground_m[stage.cell(x, 0)] = map.elevation_m[stage.cell(x, 0)] = 0.8f;
  const Score s = stage.score(map);
  EXPECT_GT(s.hanging_wrong.part, 5);
  EXPECT_EQ(s.hanging_wrong_seen.part, 0);
  EXPECT_GT(s.all_measured_ground().rmse_m(), 0.01);
  for (const Errors& hit : s.measured_ground_hit)
    EXPECT_TRUE(hit.count() == 0 || hit.rmse_m() == 0);
}

TEST(Score, DoesNotJudgeWhatHangsJustAboveTheClearanceOrSoHighThatNoPointOfItCounts)
{
  const auto score_below = [](const std::string& height_m)
  {
    const Stage stage("objects: [table: {at_m: [2, 0], size_m: [1, 1, " + height_m + "]}]\n");
    return stage.score(stage.perfect());
  };
  EXPECT_EQ(score_below("0.67").hanging_passable.of, 0);  // its underside: 0.64; the clearance: 0.6
  EXPECT_GT(score_below("0.69").hanging_passable.of, 0);
  EXPECT_GT(score_below("2.0").hanging_wrong.of, 0);
  EXPECT_EQ(score_below("2.4").hanging_wrong.of, 0);  // points count up to 1.5 m above the sensor
}

TEST(Score, LeavesOutWhatStandsWithinFiveCentimetresOfAStep)
{
  // Whether a box of 0.19 m and the cells beside it are blocked is the map's choice.
  const Stage stage("objects: [box: {at_m: [2.5, 0], size_m: [0.5, 1.5, 0.19]}]\n");
  const auto blocked_up_to = [&stage](int cells)
  {
    Surfaces map = stage.perfect();
    for (std::size_t k = 0; k < map.size(); ++k)
      if (stage.truth.to_obstacle[stage.here.at[k]] <= cells) map.traversability[k] = 0.0f;
    return map;
  };
  EXPECT_EQ(stage.score(blocked_up_to(0)).reach.value(), 1.0);
  EXPECT_GT(stage.score(blocked_up_to(1)).free_passable.of, 0);
  EXPECT_EQ(stage.score(blocked_up_to(1)).free_passable.value(), 1.0);
  EXPECT_LT(stage.score(blocked_up_to(2)).free_passable.value(), 1.0);
}

TEST(Score, DoesNotJudgeGroundThatMayAsWellBeAThing)
{
  // Ground between steep sides: on top it is free, and nothing leads there.
  const auto judged = [](const std::string& top_m)
  {
    const Stage stage(
        "", 0.05,
        "ramp: {at_m: [1.5, 0], length_m: 0.5, height_m: 0.5, top_m: " + top_m +
            ", down_m: 0.5, width_m: 1.4}");
    const auto i = static_cast<std::size_t>(stage.here.at[stage.cell(2.4, 0)]);
    EXPECT_TRUE(stage.truth.free(i));
    return stage.truth.surely_free(i);
  };
  EXPECT_FALSE(judged("0.8"));
  EXPECT_TRUE(judged("1.4"));
}

TEST(Score, AHitWithinFiveCentimetresOfAStepShowsNoObstacle)
{
  const auto shown = [](float height_m)
  {
    const Stage stage(kBox);
    const Parameters p;
    Observed observed(stage.truth, p);
    ScanFrame f = stage.sequence.frames.front();
    f.x_m = {2.3f}, f.y_m = {0.0f};
    f.z_m = {height_m - static_cast<float>(f.T_true.z())};
    observed.add(f);
    return observed.shows_obstacle(stage.here.at[stage.cell(2.3, 0)]);
  };
  EXPECT_FALSE(shown(0.24f));
  EXPECT_TRUE(shown(0.26f));
}

TEST(Score, AsksForWhatAWayOverSeenGroundLeadsTo)
{
  // No beam meets the ground around a robot at rest; one that drove saw it before.
  const auto asked = [](const std::string& path)
  {
    const sim::World world = sim::parse_world(
        "ground: [plane: {z_m: 0}]\nrobot: {" + path + "}\nsensor: {scanner: OS1-64}\n",
        "test.yaml");
    EvaluationOptions options;
    options.methods = {"talus"};
    options.evaluated_frames = 1;
    return evaluate_world(world, options).maps[0];
  };
  const Score rest = asked("path_m: [[0, 0]], duration_s: 0.3");
  EXPECT_GT(rest.reach.of, 1000);
  EXPECT_EQ(rest.reach_seen.of, 0);
  const Score drive = asked("path_m: [[0, 0], [3, 0]]");
  EXPECT_GT(drive.reach_seen.of, 0.9 * drive.reach.of);
  EXPECT_GT(drive.reach_seen.value(), 0.98);
}

TEST(Score, AThingAboveAnEdgeDoesNotShowTheDropBelow)
{
  // All ground beside the edge that the scanner hits is the upper one.
  const auto shown = [](const std::string& objects)
  {
    const Stage stage(objects, 0.05, "step: {at_m: [2.0, 0], height_m: -0.5}");
    int cells = 0;
    for (double y = -1; y < 1; y += 0.05)
      for (const double x : {1.975, 2.025})
      {
        const int at = stage.here.at[stage.cell(x, y)];
        EXPECT_TRUE(stage.truth.blocked(at));
        cells += stage.observed.shows_obstacle(at);
      }
    return cells;
  };
  EXPECT_EQ(shown(""), 0);
  EXPECT_EQ(
      shown("objects: [beam: {from_m: [2.1, -1], to_m: [2.1, 1], underside_m: 1.1, "
            "width_m: 0.1, thickness_m: 0.1}]\n"),
      0);
}

/** What a map scores that shows the top of a thing as ground, its outermost cells as blocked. */
Score score_of_a_free_top(const Stage& stage)
{
  Surfaces map = stage.perfect();
  for (std::size_t k = 0; k < map.size(); ++k)
  {
    const auto i = static_cast<std::size_t>(stage.here.at[k]);
    map.ground_m[k] = stage.truth.surface_m(i);
    if (stage.truth.depth[i] > 1) map.traversability[k] = 1.0f;
  }
  return stage.score(map);
}

TEST(Score, DoesNotJudgeATopAsWideAsAPlatformButForItsEdge)
{
  const Score wide =
      score_of_a_free_top(Stage("objects: [box: {at_m: [2.5, 0], size_m: [1.4, 1.4, 0.4]}]\n"));
  EXPECT_EQ(wide.obstacle_blocked.value(), 1.0);
  EXPECT_GT(wide.obstacle_blocked.of, 10);
  const Score narrow =
      score_of_a_free_top(Stage("objects: [box: {at_m: [2.5, 0], size_m: [0.8, 1.4, 0.4]}]\n"));
  EXPECT_LT(narrow.obstacle_blocked.value(), 0.8);
  const Score hedge = score_of_a_free_top(
      Stage("objects: [foliage: {at_m: [2.5, 0], size_m: [1.4, 1.4, 0.4], form: box}]\n"));
  EXPECT_LT(hedge.obstacle_blocked.value(), 0.8);
}

TEST(Score, LeaksOntoAPlatformUnlessThereIsAWayUp)
{
  const auto leak = [](const std::string& more)
  {
    const Stage stage("objects:\n  - box: {at_m: [2.5, 0], size_m: [1.4, 1.4, 0.4]}\n" + more);
    Surfaces map = stage.perfect();
    for (float& t : map.traversability) t = 1.0f;
    return stage.score(map).leak;
  };
  EXPECT_EQ(leak("").value(), 1.0);
  EXPECT_GT(leak("").of, 26 * 26 - 1);
  EXPECT_EQ(leak("  - box: {at_m: [1.55, 0], size_m: [0.5, 0.8, 0.2]}\n").of, 0);
}

TEST(Score, MissesAPostThatTheMapLost)
{
  const Stage stage("objects: [post: {at_m: [2, 0.5], height_m: 0.9, radius_m: 0.06}]\n");
  Surfaces map = stage.perfect();
  EXPECT_EQ(stage.score(map).posts.value(), 1.0);
  for (float& t : map.traversability) t = 1.0f;
  EXPECT_EQ(stage.score(map).posts.value(), 0.0);
}

TEST(WindowTruth, IsOfTheCellsThatTheMapShowsWhereItsPoseErrs)
{
  // The map's window follows the pose that it was told, 0.4 m beside the true one. Each of its
  // cells is compared with what is there, and the robot stands where it really is.
  const Stage stage(kBox);
  std::vector<ScanFrame> frames = stage.sequence.frames;
  frames.back().T_map_sensor.m[3] += 0.4;
  const Parameters p;
  const WindowTruth here = window_truth(
      stage.truth, stage.observed, nullptr, frames, frames.size() - 1, p, nullptr, nullptr);
  EXPECT_EQ(here.window.min_cell_x, stage.here.window.min_cell_x + 8);
  const auto at = [&](double x_m, double y_m)
  { return static_cast<std::size_t>(cell_index(here.window, x_m, y_m)); };
  EXPECT_EQ(here.blocked_now[at(2.275, 0.025)], 1);
  EXPECT_EQ(here.blocked_now[at(2.225, 0.025)], 0);
  EXPECT_EQ(here.blocked_now[at(2.725, 0.025)], 1);
  EXPECT_EQ(here.blocked_now[at(2.775, 0.025)], 0);
  EXPECT_EQ(here.start[at(-0.325, 0.025)], 1);
  EXPECT_EQ(here.start[at(0.375, 0.025)], 0);
}

TEST(TruthMap, TellsFlatFromSlopeRoughAndSteps)
{
  const sim::World world = sim::parse_world(
      "ground:\n"
      "  - ramp: {at_m: [2, 0], length_m: 2, height_m: 0.3}\n"
      "  - step: {at_m: [0, 3], yaw_deg: 90, height_m: 0.15}\n"
      "robot: {path_m: [[0, 0]], duration_s: 0.05}\n",
      "test.yaml");
  const TruthMap truth = truth_of(world, EvaluationOptions());
  const auto kind = [&](double x, double y)
  {
    return truth.terrain[truth.index(
        static_cast<std::int64_t>(std::floor(x / 0.05)),
        static_cast<std::int64_t>(std::floor(y / 0.05)))];
  };
  EXPECT_EQ(kind(0, 0), Terrain::Flat);
  EXPECT_EQ(kind(3, 0), Terrain::Slope);
  EXPECT_EQ(kind(2, 0), Terrain::Rough);  // the kink at the foot of the ramp
  EXPECT_EQ(kind(0, 2.9), Terrain::NearStep);
  EXPECT_EQ(kind(0, 2.7), Terrain::Flat);
}

TEST(MoverWatch, CountsAPassableCellAsFreedAndATrailAsNot)
{
  const sim::World world = sim::parse_world(
      "ground: [plane: {z_m: 0}]\n"
      "movers: [person: {path: [[0, 2.5, -1], [2, 2.5, 1]]}]\n"
      "robot: {path_m: [[0, 0]], duration_s: 2}\n",
      "test.yaml");
  EvaluationOptions options;
  options.methods = {"talus", "heightgrid"};
  options.evaluated_frames = 1;
  const Evaluation e = evaluate_world(world, options);
  ASSERT_GT(e.maps[0].mover_freed.of, 50);
  EXPECT_EQ(e.maps[0].mover_freed.of, e.maps[1].mover_freed.of);
  EXPECT_GE(e.maps[0].mover_freed.value(), 0.95);
  EXPECT_LE(e.maps[1].mover_freed.value(), 0.5);  // it averages, and forgets nothing
}

/** Whether a trolley, 0.35 m above the floor, counts as seen through where it stood until it left
 * after a second; `others` are movers, too. */
bool trolley_is_seen_through(const std::string& others)
{
  const sim::World world = sim::parse_world(
      "ground: [plane: {z_m: 0}]\n"
      "movers:\n"
      "  - box: {path: [[0, 3, 0], [1, 3, 0], [1.5, 3, 4]], size_m: [0.6, 0.6, 0.4], lift_m: "
      "0.35}\n" +
          others + "robot: {path_m: [[0, 0]], duration_s: 2}\n",
      "test.yaml");
  const EvaluationOptions options;
  const TruthMap truth = truth_of(world, options);
  MoverTruth movers(truth, world, options.parameters);
  for (const ScanFrame& f : simulate(world, sim::Drive(world)).frames) movers.advance(f);
  const auto face = static_cast<std::size_t>(truth.index(54, 0));
  EXPECT_GT(movers.hit_top_m[face], 0.35f);
  EXPECT_LT(movers.lowest_ray_m[face], 0.2f);
  return movers.seen_through_frame[face] >= 0;
}

TEST(MoverTruth, IsSeenThroughByRaysWhereItWasAndNotByThoseBelowIt)
{
  EXPECT_TRUE(trolley_is_seen_through(""));
  // One that stops before it hides all but the floor below both.
  EXPECT_FALSE(trolley_is_seen_through(
      "  - box: {path: [[0, 1.8, -4], [0.9, 1.8, 0], [9, 1.8, 0]], size_m: [0.4, 1.6, 1.5], "
      "lift_m: 0.35}\n"));
}

TEST(Budgets, CallFillsAlikeThatErrByLessThanAMillimetre)
{
  const auto verdict = [](float own_m, float other_m)
  {
    Evaluation e;
    e.maps.resize(1);
    e.maps[0].method = "talus";
    e.fills.resize(2);
    e.fills[0].fill = "talus", e.fills[1].fill = "bgk";
    e.fills[0].seen.abs_m.assign(20, own_m), e.fills[1].seen.abs_m.assign(20, other_m);
    return check_budgets(e).back().verdict;
  };
  EXPECT_EQ(verdict(0.0009f, 0.0003f), BudgetResult::Verdict::Pass);
  EXPECT_EQ(verdict(0.0011f, 0.0003f), BudgetResult::Verdict::Fail);
  EXPECT_EQ(verdict(0.0021f, 0.0020f), BudgetResult::Verdict::Fail);
}

TEST(Budgets, DoNotApplyWhereThereIsNothingToJudge)
{
  Evaluation e;
  e.maps.resize(1);
  e.maps[0].method = "talus";
  for (const BudgetResult& r : check_budgets(e))
    EXPECT_EQ(r.verdict, BudgetResult::Verdict::NotApplicable) << r.name;
}

}  // namespace
