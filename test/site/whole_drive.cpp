// The map of a whole drive against what is really there, judged as that of the window is.
#include <gtest/gtest.h>
#include <talus/baselines/budgets.h>
#include <talus/site/changes.h>
#include <talus/site/site_mapper.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "sites.h"

using namespace talus;
using namespace talus::site;

namespace
{
using baselines::ScanFrame;
using baselines::TruthMap;
using Names = std::set<std::string>;

const Names kBudgets{
    "measured_ground_flat_rmse_m",
    "measured_ground_slope_rmse_m",
    "measured_ground_rough_rmse_m",
    "measured_ground_near_step_rmse_m",
    "obstacle_blocked_whole",
    "free_passable",
    "posts_kept"};

constexpr double kNotYet = 0.82;

/** A world, a drive through it, and all that it saw as one map. */
struct WholeDrive
{
  explicit WholeDrive(
      const sim::World& w, double until_s = 1e9, const sim::DriveOptions& options = {})
      : world(w), site(p.resolution_m, std::size_t{64} << 20, testing::TempDir())
  {
    const sim::Drive drive(world, options);
    way = drive.path().bounds();
    frames = baselines::simulate(world, drive).frames;
    frames.erase(
        std::find_if(
            frames.begin(), frames.end(), [&](const ScanFrame& f) { return f.time_s > until_s; }),
        frames.end());
    ElevationMapper map(p, Backend::Cpu);
    SiteMapper mapper(site);
    for (const ScanFrame& f : frames) mapper.update(map, f.view());
    mapper.keep_window(map);
    mapper.look_back(map);
  }

  /** What is there at the end, without movers. */
  TruthMap truth() const
  {
    const sim::TruthWindow area = sim::window_around(way, 0.5 * p.window_m + 1, p.resolution_m);
    return TruthMap(
        sim::truth(world, area, frames.back().time_s, TruthMap::truth_options(p, false)), p);
  }

  SiteCell cell(std::int64_t x, std::int64_t y) { return test::known_at(site, x, y); }

  const Parameters p;
  const sim::World& world;
  sim::Bounds way;
  std::vector<ScanFrame> frames;
  Site site;
};

/** A frame without the points that its window did not take. */
ScanFrame within_window(ScanFrame frame, const Parameters& p)
{
  const Window w =
      baselines::window_around(p, pose_of_base(frame.T_map_sensor, frame.T_base_sensor));
  for (std::size_t i = 0; i < frame.x_m.size(); ++i)
  {
    const sim::Vec3 at =
        sim::transform(frame.T_map_sensor, {frame.x_m[i], frame.y_m[i], frame.z_m[i]});
    const bool is_inside = baselines::cell_index(w, at.x, at.y) >= 0;
    if (!is_inside) frame.x_m[i] = NAN;
  }
  return frame;
}

/** Parameters whose window holds all of the truth wherever the robot is: nothing leaves it. */
Parameters whole_window(const Parameters& p, const TruthMap& truth)
{
  const sim::TruthWindow& area = truth.truth.window;
  Parameters whole = p;
  whole.window_m = 2 * std::max(area.cells_x, area.cells_y) * p.resolution_m;
  return whole;
}

baselines::Surfaces surfaces(WholeDrive& drive, const Window& window)
{
  baselines::Surfaces s(window);
  for (int i = 0; i < window.cells * window.cells; ++i)
  {
    const SiteCell c =
        drive.cell(window.min_cell_x + i % window.cells, window.min_cell_y + i / window.cells);
    if (!c.known()) continue;
    const auto k = static_cast<std::size_t>(i);
    s.state[k] = c.cell.state;
    s.ground_m[k] = c.cell.ground_m;
    s.elevation_m[k] = std::isnan(c.cell.elevation_m) ? c.cell.ground_m : c.cell.elevation_m;
    s.traversability[k] = c.cell.traversability;
  }
  return s;
}

/** The whole map as if it were one window. */
baselines::Score score(WholeDrive& drive, const TruthMap& truth)
{
  const Parameters whole = whole_window(drive.p, truth);
  baselines::Observed observed(truth, whole);
  baselines::MoverTruth movers(truth, drive.world, whole);
  for (const ScanFrame& f : drive.frames)
  {
    const ScanFrame seen = within_window(f, drive.p);
    observed.add(seen);
    if (!drive.world.movers.empty()) movers.advance(seen);
  }
  const auto here = baselines::window_truth(
      truth, observed, drive.world.movers.empty() ? nullptr : &movers, drive.frames,
      drive.frames.size() - 1, whole, nullptr, nullptr);
  baselines::Score score;
  score.method = "talus";
  baselines::score_frame(surfaces(drive, here.window), truth, here, observed, score);
  return score;
}

/** A figure for the report of the test. */
void record(const std::string& name, double value)
{
  testing::Test::RecordProperty(name, std::to_string(value));
  std::cout << name << " " << value << "\n";
}

/** Those of kBudgets must hold, but `not_yet`, shares that are kNotYet at least; those in
 * `must_apply` must have something to judge.
 */
void expect_budgets(const baselines::Score& score, const Names& must_apply, const Names& not_yet)
{
  using Verdict = baselines::BudgetResult::Verdict;
  baselines::Evaluation e;
  e.maps.push_back(score);
  for (const baselines::BudgetResult& r : check_budgets(e))
  {
    if (!kBudgets.count(r.name)) continue;
    record(r.name, r.value);
    if (must_apply.count(r.name))
    {
      EXPECT_NE(static_cast<int>(r.verdict), static_cast<int>(Verdict::NotApplicable)) << r.name;
    }
    if (not_yet.count(r.name))
    {
      EXPECT_GE(r.value, kNotYet) << r.name;
      continue;
    }
    EXPECT_NE(static_cast<int>(r.verdict), static_cast<int>(Verdict::Fail))
        << r.name << ": " << r.value << (r.at_most ? ", at most " : ", at least ") << r.limit;
  }
}

/** Steps between neighbours, measured on flat ground in different rounds. */
baselines::Errors steps_between_rounds(WholeDrive& drive, const TruthMap& truth)
{
  constexpr double kApart_s = 8;
  baselines::Errors steps;
  const auto off_m = [&](std::int64_t x, std::int64_t y, const SiteCell& c) -> double
  {
    const auto k = static_cast<std::size_t>(truth.index(x, y));
    const bool is_judged = c.cell.state == 1 && truth.terrain[k] == baselines::Terrain::Flat &&
                           truth.surely_free(k) && truth.clear(k);
    return is_judged ? static_cast<double>(c.cell.ground_m) - truth.truth.ground[k] : NAN;
  };
  const auto compare = [&](std::int64_t ax, std::int64_t ay, std::int64_t bx, std::int64_t by)
  {
    const SiteCell a = drive.cell(ax, ay), b = drive.cell(bx, by);
    const double step_m = off_m(bx, by, b) - off_m(ax, ay, a);
    const double later_s = static_cast<double>(b.seen_s) - static_cast<double>(a.seen_s);
    if (!std::isnan(step_m) && std::abs(later_s) > kApart_s) steps.add(static_cast<float>(step_m));
  };
  const sim::TruthWindow& area = truth.truth.window;
  const auto x0 = std::llround(area.min_x_m / area.resolution_m);
  const auto y0 = std::llround(area.min_y_m / area.resolution_m);
  for (std::int64_t y = y0; y < y0 + area.cells_y - 1; ++y)
    for (std::int64_t x = x0; x < x0 + area.cells_x - 1; ++x)
      compare(x, y, x + 1, y), compare(x, y, x, y + 1);
  return steps;
}

/** Round a yard, and once more elsewhere. A box goes, another comes. */
sim::World yard()
{
  return sim::parse_world(
      "seed: 5\n"
      "ground: [plane: {}]\n"
      "objects:\n"
      "- box: {at_m: [4, 1.6], size_m: [0.6, 0.6, 0.5], until_s: 14}\n"
      "- box: {at_m: [5, 7.6], size_m: [0.6, 0.6, 0.5], from_s: 14}\n"
      "- box: {at_m: [-1.6, 3], size_m: [0.5, 0.9, 0.6], yaw_deg: 20}\n"
      "- posts: {from_m: [5, 2.6], to_m: [7, 2.6], count: 3, height_m: 0.9, radius_m: 0.06}\n"
      "- wall: {from_m: [-2, 9.2], to_m: [10, 9.2], height_m: 1.2, thickness_m: 0.2}\n"
      "robot: {path_m: [[0, 0], [8, 0], [8, 6], [0, 6], [0, 0], [2.5, -2.5], [10.5, -2.5], [10.5, "
      "4.5], [2.5, 4.5], [2.5, -1]], speed_mps: 2}\n"
      "sensor: {at_m: [0, 0, 0.7], rate_hz: 10}\n",
      "test.yaml");
}
constexpr double kFirstRound_s = 13.9;
constexpr double kSeam_m = 0.005;

}  // namespace

/** Of a shipped world. `not_yet`: budgets that are not kept there, of rocks in the woods, bushes
 * that rays go through and what waits beside a railing: the map keeps what the window said last,
 * and that is less than it once knew.
 */
struct Case
{
  const char* world;
  Names not_yet;
};
class OfWorld : public testing::TestWithParam<Case>
{
};
INSTANTIATE_TEST_SUITE_P(
    WholeDrive, OfWorld,
    testing::Values(
        Case{"demo", {"free_passable"}}, Case{"nav_woods", {"obstacle_blocked_whole"}},
        Case{"park", {"obstacle_blocked_whole"}}),
    [](const auto& of) { return std::string(of.param.world); });

TEST_P(OfWorld, keeps_the_budgets_of_the_window)
{
  const sim::World world =
      sim::load_world(std::string(TALUS_WORLDS_DIR) + "/" + GetParam().world + ".yaml");
  WholeDrive drive(world);
  expect_budgets(
      score(drive, drive.truth()), {"free_passable", "obstacle_blocked_whole"}, GetParam().not_yet);
}

TEST(WholeDrive, of_two_rounds_keeps_the_budgets_of_the_window)
{
  const sim::World world = yard();
  WholeDrive drive(world);
  expect_budgets(
      score(drive, drive.truth()),
      {"measured_ground_flat_rmse_m", "obstacle_blocked_whole", "free_passable", "posts_kept"}, {});
}

TEST(WholeDrive, without_noise_has_no_step_between_its_rounds)
{
  const sim::World world = yard();
  sim::DriveOptions exact;
  exact.noise_m = 0;
  WholeDrive drive(world, 1e9, exact);
  const baselines::Errors steps = steps_between_rounds(drive, drive.truth());
  EXPECT_GT(steps.count(), 300u);
  EXPECT_LT(steps.quantile_m(1), kSeam_m);
}

TEST(WholeDrive, tells_what_went_and_what_came_between_its_rounds)
{
  const sim::World world = yard();
  WholeDrive first(world, kFirstRound_s), both(world);
  const ChangeSums sums = write_changes(
      testing::TempDir() + "/whole_drive_changes.tif",
      testing::TempDir() + "/whole_drive_changes.png", first.site, both.site, 0, 0.2);
  const double gone_m2 = sums.area_m2(Change::Gone), came_m2 = sums.area_m2(Change::Appeared);
  record("gone_m2", gone_m2);
  record("came_m2", came_m2);
  constexpr double kBox_m2 = 0.36;  // of which the scans show the sides and some of the top
  EXPECT_GT(gone_m2, 0.5 * kBox_m2);
  EXPECT_LT(gone_m2, 1.3 * kBox_m2);
  EXPECT_GT(came_m2, 0.5 * kBox_m2);
  EXPECT_LT(came_m2, 1.3 * kBox_m2);
  EXPECT_LT(sums.area_m2(Change::Built) + sums.area_m2(Change::Dug), 0.02);
}
