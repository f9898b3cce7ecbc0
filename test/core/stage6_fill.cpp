#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include "cuda/fill_search.h"
#include "scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
kernels::SideEstimate side(float height, int gap, float distance)
{
  kernels::SideEstimate s;
  s.height_m = s.nearest_m = height;
  s.cells = gap + 1;
  s.distance_m = s.mean_distance_m = distance;
  return s;
}

/** A shelf that ends at x = 1.5 m; rays over its edge end at x = 4.5 m, outside the window. */
Scan over_the_edge_of_a_shelf(double far_z_m)
{
  Scan s(0, 0, 0.3);
  s.add_surface(0.5, -0.5, 1.5, 0.5, flat);
  for (double y = -0.475; y < 0.5; y += 0.01) s.add(4.5, y, far_z_m);
  return s;
}
}  // namespace

TEST(Stage6Fill, EveryCellLiesOnTheLineThatIsSaidToPassThroughItAndOnTheGrid)
{
  for (const int rings : {2, 3, 7, 80, 500})
  {
    kernels::Config k{};
    k.cells = 2 * rings;
    k.resolution_m = 0.1f;
    const kernels::LineGrid grid = kernels::line_grid(k);
    for (int dx = -rings; dx <= rings; dx++)
      for (int dy = -rings; dy <= rings; dy += rings > 100 ? 7 : 1)
      {
        if (dx == 0 && dy == 0) continue;
        const int ring = std::max(std::abs(dx), std::abs(dy));
        const auto line = kernels::line_through(dx, dy, ring, rings);
        const auto track = kernels::radial_track(line, grid, k);
        const auto cell = track.offset(ring);
        ASSERT_TRUE(cell.dx == dx && cell.dy == dy) << rings << ": " << dx << "," << dy;
        ASSERT_EQ(track(ring), grid.at(rings + dx, rings + dy)) << rings << ": " << dx << "," << dy;
        const int index = kernels::line_index(line, rings);
        ASSERT_TRUE(index >= 0 && index < 8 * rings) << rings << ": " << dx << "," << dy;
        const auto again = kernels::line_from_index(index, rings);
        ASSERT_TRUE(again.side == line.side && again.minor == line.minor);
      }
  }
}

TEST(Stage6Fill, MarksAreFoundAcrossWordsAndWithinReachNearestFirst)
{
  const std::uint32_t words[7] = {0, 0, 1u << 5 | 1u << 31, 0, 1u << 10, 0, 0};
  const kernels::LineMarks marks{words + kernels::LineMarks::kGuardWords, 1};
  const auto found = [&marks](int place, bool outwards, int reach)
  {
    std::vector<int> distances;
    for (int from = 0; from < reach; from += kernels::LineMarks::kView)
      for (auto bits = marks.view(place, outwards, from); bits; bits &= bits - 1)
        if (const int distance = from + 1 + kernels::lowest_bit(bits); distance <= reach)
          distances.push_back(distance);
    EXPECT_EQ(marks.nearest(place, outwards, reach), distances.empty() ? 0 : distances.front());
    return distances;
  };
  using Distances = std::vector<int>;
  EXPECT_EQ(found(80, false, 80), (Distances{6, 49, 75}));
  EXPECT_EQ(found(74, false, 74), (Distances{43, 69}));
  EXPECT_EQ(found(32, false, 32), (Distances{1, 27}));
  EXPECT_EQ(found(31, false, 31), Distances{26});
  EXPECT_EQ(found(31, false, 25), Distances{});
  EXPECT_EQ(found(5, false, 5), Distances{});
  EXPECT_EQ(found(0, false, 0), Distances{});
  EXPECT_EQ(found(0, true, 80), (Distances{5, 31, 74}));
  EXPECT_EQ(found(5, true, 75), (Distances{26, 69}));
  EXPECT_EQ(found(31, true, 49), Distances{43});
  EXPECT_EQ(found(31, true, 42), Distances{});
  EXPECT_EQ(found(74, true, 6), Distances{});
  EXPECT_EQ(found(80, true, 0), Distances{});
}

TEST(Stage6Fill, Equation8WeighsSamplesBySparseKernel)
{
  TestMap m(
      Scan().add(1.025, 0.025, 0.10).add(0.975, 0.025, 0.04),
      with({{"fill_samples", 2}, {"fill_search_m", 1.0}, {"fill_kernel_m", 1.0}}));
  const auto k = [](double d)
  { return (2 + std::cos(2 * M_PI * d)) / 3 * (1 - d) + std::sin(2 * M_PI * d) / (2 * M_PI); };
  const double k1 = k(0.20), k2 = k(0.25);
  const double expected = (k1 * 0.10 + k2 * 0.04) / (k1 + k2);
  EXPECT_EQ(m.state(1.225, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.ground(1.225, 0.025), expected, 1e-4);  // the kernel is tabulated in 1024 steps
}

TEST(Stage6Fill, WhatIsFilledHasAHeightAlsoWhereTheKernelEndsAndNothingIsBeyondTheSearchLength)
{
  TestMap m(
      Scan().add_surface(1.0, -0.5, 1.5, 0.5, flat),
      with({{"fill_search_m", 2.0}, {"fill_kernel_m", 0.5}}));
  EXPECT_EQ(m.state(2.775, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.ground(2.775, 0.025), 0.0, 1e-5);
  TestMap near(Scan().add_surface(1.0, -0.5, 1.5, 0.5, flat), with({{"fill_search_m", 0.3}}));
  EXPECT_EQ(near.state(1.775, 0.025), CellState::FilledOneSided);  // 0.3 m behind the last sample
  EXPECT_EQ(near.state(1.825, 0.025), CellState::Unknown);
}

TEST(Stage6Fill, AGapWithGroundOnBothSidesIsReliableAndOneWithOneSideIsNot)
{
  TestMap m(Scan().add_surface(1.0, -0.5, 1.5, 0.5, flat).add_surface(2.0, -0.5, 2.5, 0.5, flat));
  EXPECT_EQ(m.state(1.775, 0.025), CellState::FilledTwoSided);
  EXPECT_EQ(m.state(2.775, 0.025), CellState::FilledOneSided);
  EXPECT_EQ(m.state(0.775, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.ground(1.775, 0.025), 0.0, 1e-5);
  EXPECT_TRUE(std::isnan(m.elevation(1.775, 0.025)));
  double last = 0;
  for (double x = 2.525; x < 3.5; x += 0.05)
  {
    EXPECT_GT(m.at(Layer::Variance, x, 0.025), last) << "the farther its sample";
    last = m.at(Layer::Variance, x, 0.025);
  }
}

TEST(Stage6Fill, ASlopeIsFilledAlongRayRowAndColumnWithoutBias)
{
  // Stripes of ground on a plane that tilts both ways, 0.2 m of 0.25 m unseen.
  const auto plane = [](double x, double y) { return 0.2 * (x - 2) + 0.1 * y; };
  Scan s;
  for (int stripe = 0; stripe < 8; stripe++)
    s.add_surface(1 + 0.25 * stripe, -1, 1.05 + 0.25 * stripe, 1, plane);
  TestMap m(s);
  for (double x = 1.075; x < 2.7; x += 0.05)
    EXPECT_NEAR(m.ground(x, 0.025), plane(x, 0.025), 0.004) << x;
}

TEST(Stage6Fill, ABankBesideAFloorSaysNothingOfHowTheFloorGoesOn)
{
  const auto bank = [](double x, double) { return std::max(0.0, -0.7 * (x + 1)); };
  TestMap m(Scan().add_surface(-2.5, -2.5, 2.0, 2.5, bank));
  for (double x = 2.025; x < 2.8; x += 0.1) EXPECT_NEAR(m.ground(x, 0.025), 0.0, 0.02) << x;
}

TEST(Stage6Fill, LinesWhoseSidesDisagreeCountForLess)
{
  const auto counts = [](float rise_m)
  {
    kernels::LineFusion lines;
    lines.add(kernels::fuse_sides(side(0, 9, 0.5f), side(rise_m, 9, 0.5f)));
    return lines.information;
  };
  const auto counts_if_off = [](float by_m) { return 1 / (by_m * by_m); };
  EXPECT_FLOAT_EQ(counts(0), counts_if_off(0.08f + 0.05f * 0.5f * 0.5f));
  EXPECT_NEAR(counts(0.15f), counts_if_off(0.0925f + 0.15f / std::sqrt(12.0f)), 0.1f);
  EXPECT_FLOAT_EQ(counts(-0.15f), counts(0.15f));
}

TEST(Stage6Fill, BelowAnObjectTheGroundIsLittleHigherThanTheLowestLine)
{
  kernels::Config k{};
  k.step_threshold_m = 0.2f;
  kernels::LineFusion lines;
  lines.add(kernels::fuse_sides(side(0, 9, 0.5f), side(0, 9, 0.5f)));
  lines.add(kernels::fuse_sides(side(0.6f, 9, 0.5f), side(0.6f, 9, 0.5f)));
  const float low_m = kernels::low_line_m(lines, k);
  EXPECT_FLOAT_EQ(kernels::fill_of_lines(lines, low_m, false), 0.3f);
  EXPECT_FLOAT_EQ(kernels::fill_of_lines(lines, low_m, true), 0.05f);
}

TEST(Stage6Fill, ADitchIsImpassableUpToItsFarWall)
{
  TestMap m(Scan()
                .add_surface(0.5, -1, 1.4, 1, flat)
                .add_surface(2.3, -1, 2.35, 1, level(-0.28))
                .add_surface(2.35, -1, 3.0, 1, flat));
  for (double x = 1.425; x < 2.3; x += 0.05) EXPECT_EQ(m.traversability(x, 0.025), 0.0f) << x;
  EXPECT_GT(m.traversability(1.275, 0.025), 0.9f);
}

TEST(Stage6Fill, WhatNoRayPassedLowOverItsGroundIsNotJudged)
{
  // Behind the wall the ground is a guess that no ray ever passed; before it rays came by.
  Scan s = Scan().add_surface(1.0, -0.5, 1.4, 0.5, flat).add_surface(1.6, -0.5, 1.8, 0.5, flat);
  TestMap m(s.cast({{{2.0, -2, 0}, {2.05, 2, 1.0}}}, 720, -0.335, 0.1));
  EXPECT_EQ(m.state(1.525, 0.025), CellState::FilledTwoSided);
  EXPECT_GT(m.traversability(1.525, 0.025), 0.9f);
  EXPECT_EQ(m.state(2.225, 0.025), CellState::FilledOneSided);
  EXPECT_TRUE(std::isnan(m.traversability(2.225, 0.025)));
}

TEST(Stage6Fill, AGapBetweenGroundIsJudgedWhereRaysPassedWithinHalfAMetre)
{
  // Two rings on the floor, 1 and 1.6 m away: rays of the second pass 0.25 m above the floor behind
  // the first, and lower the nearer they come to their own end.
  TestMap m(Scan(0, 0, 0.8).cast({}, 720, -0.675, -0.4636, 2), {}, 2);
  for (const double x : {1.125, 1.475}) EXPECT_EQ(m.state(x, 0.025), CellState::FilledTwoSided);
  for (const double x : {1.125, 1.475}) EXPECT_GT(m.traversability(x, 0.025), 0.9f);
}

TEST(Stage6Fill, WhereRaysPassFarBelowAFillTheGroundMayDropUntilItIsMeasured)
{
  // First a ray passes over what may be its surface; then rays go down as a ramp might.
  const auto scan = over_the_edge_of_a_shelf;
  TestMap m(scan(0.0));
  EXPECT_GT(m.traversability(2.025, 0.025), 0.9f);
  m.update(scan(-0.85));
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  EXPECT_GT(m.traversability(1.375, 0.025), 0.5f);  // the shelf itself is as before
  m.update(scan(0.0));
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  m.update(Scan(0, 0, 0.3).add_surface(1.5, -0.5, 2.5, 0.5, flat));
  EXPECT_GT(m.traversability(2.025, 0.025), 0.9f);
}

TEST(Stage6Fill, ABlindBowlLiesOnTheLineFromWhereTheRobotStoodToItsFarSide)
{
  const auto far_side = [](double x, double) { return -0.1 * x; };
  const auto ground_of = [&](double start_radius_m)
  {
    TestMap m(with({{"start_radius_m", start_radius_m}}));
    Scan s = Scan().add_surface(3, -3, 3.9, 3, far_side);
    for (int frame = 0; frame < 2; frame++) m.update(s, translation(0, 0, 0.7));
    EXPECT_GT(m.traversability(1.525, 0.025), 0.5f);
    return m.ground(1.525, 0.025);
  };
  EXPECT_NEAR(ground_of(0.3), -0.14, 0.03);
  EXPECT_NEAR(ground_of(0), -0.3, 0.03);  // where the robot stands tells nothing of what is around
}

TEST(Stage6Fill, AGuessLeadsToAFarSideThatIsFartherThanFillsSearch)
{
  TestMap m(
      Scan(0, 0, 0.7)
          .add_surface(0.5, -0.5, 1.0, 0.5, flat)
          .add_surface(3.0, -0.5, 3.5, 0.5, [](double, double) { return -0.2; }),
      with({{"fill_search_m", 0.5}}));
  EXPECT_EQ(m.state(1.375, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.ground(1.375, 0.025), -0.04, 0.01);
  EXPECT_EQ(m.state(2.025, 0.025), CellState::Unknown);
}

TEST(Stage6Fill, GroundThatWouldGoOnAboveWhereRaysEndedMayDrop)
{
  const auto scan = over_the_edge_of_a_shelf;
  TestMap level_on, slopes, drops;
  level_on.update(scan(0.0));
  drops.update(scan(-0.85));
  slopes.update(scan(-0.4));
  for (double x = 1.625; x < 1.9; x += 0.05)
  {
    EXPECT_EQ(drops.state(x, 0.025), CellState::FilledOneSided) << x;
    EXPECT_NEAR(drops.ground(x, 0.025), 0.0, 1e-5) << x;
    EXPECT_EQ(drops.traversability(x, 0.025), 0.0f) << x;
    EXPECT_NEAR(drops.at(Layer::Variance, x, 0.025), 1.0, 1e-3) << x;
    EXPECT_GT(level_on.traversability(x, 0.025), 0.9f) << x;
    EXPECT_GT(slopes.traversability(x, 0.025), 0.9f) << x;
  }
  EXPECT_GT(drops.traversability(1.375, 0.025), 0.9f);  // the shelf itself
}

TEST(Stage6Fill, ARailAcrossAHillsideAboveTheSensorIsAnObstacle)
{
  // The hill on both sides of it tells the ground below it.
  const auto hill = [](double x, double) { return 0.35 * x; };
  Scan s = Scan().add_surface(2.2, -1.0, 2.9, 1.0, hill).add_surface(3.1, -1.0, 3.8, 1.0, hill);
  for (double y = -0.975; y < 1.0; y += 0.02) s.add(3.025, y, hill(3.025, 0) + 0.3);
  TestMap m(s, {}, 3);
  EXPECT_NEAR(m.ground(3.025, 0.025), hill(3.025, 0), 0.05);
  EXPECT_EQ(m.traversability(3.025, 0.025), 0.0f);
}

TEST(Stage6Fill, WhatWasHitHighAboveAGuessStandsUntilARayPassesBelowIt)
{
  const auto column = [](Scan s)
  {
    for (double y = -0.475; y < 0.5; y += 0.05) s.add(2.525, y, 0.9);
    return s;
  };
  TestMap m(Scan().add_surface(1.0, -0.5, 2.0, 0.5, flat));
  EXPECT_EQ(m.state(2.525, 0.025), CellState::FilledOneSided);
  m.update(column(Scan()));
  EXPECT_EQ(m.state(2.525, 0.025), CellState::FilledOneSided);
  EXPECT_NEAR(m.at(Layer::Elevation, 2.525, 0.025), 0.9, 1e-3);
  EXPECT_EQ(m.traversability(2.525, 0.025), 0.0f);
  m.update(column(Scan().add_surface(2.8, -0.5, 3.2, 0.5, flat)));
  m.update(column(Scan()));  // from below: now it is known to hang
  EXPECT_TRUE(std::isnan(m.at(Layer::Elevation, 2.525, 0.025)));
  EXPECT_GT(m.traversability(2.525, 0.025), 0.9f);
}

TEST(Stage6Fill, AReflectionFromBelowTheGroundPullsNoFillDown)
{
  // Its ray seems to pass below the ground; the hits beside it are of other directions.
  Scan s;
  for (double x = 1.025; x < 5; x += 0.05)
    if (x < 2.4 || x > 3.25) s.add(x, 0.046, 0.0);
  TestMap m(s.add(6.025, 0.025, -1.0));
  for (const double x : {2.625, 3.125}) EXPECT_NEAR(m.ground(x, 0.025), 0.0, 0.02) << x;
}

TEST(Stage6Fill, BeyondAnEdgeAGuessIsNotFreeWhereTheRayOverItEndedFarBelow)
{
  // Within the window the ray passes over the level of the quay; it ends 13 m behind its border.
  for (const double far_z_m : {0.0, -2.0})
  {
    constexpr double kSlope = -0.16;
    const double end_m = (far_z_m - 0.7) / kSlope;
    Scan s = Scan().add_surface(-1, -1, 3.3, 1, flat);
    for (double y = -0.3; y < 0.3; y += 0.002) s.add(end_m, y * end_m, far_z_m);
    TestMap m(s);
    for (const double x : {3.425, 3.775})
    {
      EXPECT_EQ(m.state(x, 0.025), CellState::FilledOneSided) << x;
      EXPECT_EQ(std::isnan(m.traversability(x, 0.025)), far_z_m < 0) << x;
    }
    EXPECT_GT(m.traversability(2.525, 0.025), 0.9f);
  }
}

TEST(Stage6Fill, TheHiddenSideOfWhatIsLowIsNotFreeByRaysOverIt)
{
  TestMap m;
  // Rays pass 0.27 m high behind the box, and 0.15 m high half a metre farther on.
  m.update(Scan().cast({{{1.5, -0.5, 0}, {1.7, 0.5, 0.3}}}));
  for (const double x : {1.825, 1.925})
  {
    EXPECT_EQ(m.state(x, 0.025), CellState::FilledTwoSided) << x;
    EXPECT_TRUE(std::isnan(m.traversability(x, 0.025))) << x;
  }
  EXPECT_GT(m.traversability(2.425, 0.025), 0.9f) << "behind it";
  EXPECT_GT(m.traversability(1.825, 1.225), 0.9f) << "beside it";
}
