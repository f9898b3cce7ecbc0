// Heights around a robot, on surfaces of known heights and on stairs that a scanner saw.
#include <gtest/gtest.h>
#include <talus/elevation_mapper.h>
#include <talus/nav/height_scan.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "exact_scene.h"

using namespace talus;
using namespace talus::nav;

namespace
{
/** 17 x 11 points in a grid of 10 cm, as learned walkers ask for. */
std::vector<Point2> grid()
{
  std::vector<Point2> points;
  for (int y = -5; y <= 5; y++)
    for (int x = -8; x <= 8; x++) points.push_back({0.1 * x, 0.1 * y});
  return points;
}

constexpr double kTread_m = 0.28, kRiser_m = 0.17;
constexpr int kSteps = 5;

/** Stairs that begin at x = 0. */
double stairs_m(double x_m)
{
  return kRiser_m * std::min<double>(std::max(0.0, std::floor(x_m / kTread_m) + 1), kSteps);
}

const ElevationMapper& map_of_stairs()
{
  static const auto made = []
  {
    test::ExactScene scene;
    scene.profile = {{-1e-3, 0}};
    for (int i = 0; i < kSteps; i++)
    {
      scene.profile.push_back({i * kTread_m, kRiser_m * (i + 1)});
      scene.profile.push_back({(i + 1) * kTread_m - 1e-3, kRiser_m * (i + 1)});
    }
    test::Random random(3);
    ElevationMapper map({}, Backend::Cpu, 1);
    for (int i = 0; i < 6; i++)
    {
      const auto T = test::ExactScene::pose(-1.2 + 0.1 * i, 0.03 * i, 1.2);
      const auto scan = scene.scan(T, 540, 64, -1.5, 0.2, random, 0.02);
      Frame frame = scan.frame(0.1 * i);
      frame.T_base_sensor = test::ExactScene::pose(0, 0, 1.2);
      map.update(frame);
    }
    return map;
  }();
  return made;
}

/** 4 x 4 m around the origin with these heights of the ground, the elevation so far above it. */
MapSnapshot map_of(
    const std::function<double(double, double)>& height, double gap_m = 0,
    CellState state = CellState::Measured)
{
  MapSnapshot map;
  map.window = {80, 0.05, -40, -40};
  for (int i = 0; i < 80 * 80; i++)
  {
    const double z_m = height(-2 + (i % 80 + 0.5) * 0.05, -2 + (i / 80 + 0.5) * 0.05);
    for (const auto& [layer, value] :
         {std::pair{Layer::GroundElevation, z_m},
          {Layer::Elevation, z_m + gap_m},
          {Layer::Variance, 4e-4},
          {Layer::State, std::isnan(z_m) ? 0 : static_cast<double>(state)},
          {Layer::Traversability, 1}})
      map.layers[static_cast<std::size_t>(layer)].push_back(static_cast<float>(value));
  }
  return map;
}
}  // namespace

TEST(HeightScan, on_stairs_treads_are_flat_and_risers_stand_within_a_cell)
{
  constexpr double kCell_m = 0.05;
  int treads = 0, flat = 0, inner = 0, narrow = 0, risers = 0, sharp = 0, within[2] = {};
  for (double y_m = -0.5; y_m <= 0.5; y_m += 0.025)
  {
    std::vector<Point2> line;
    for (int x = -30; x <= 50; x++) line.push_back({0.01 * x + 0.005, y_m});
    const auto heights = height_scan(map_of_stairs(), Pose(), line);
    for (std::size_t i = 0; i < line.size(); i++)
    {
      const double truth_m = stairs_m(line[i].x_m);
      const bool riser = stairs_m(line[i].x_m - kCell_m) != stairs_m(line[i].x_m + kCell_m);
      if (riser || heights[i].origin != HeightOrigin::Measured) continue;
      const double error_m = std::abs(heights[i].z_m - truth_m);
      treads++;
      flat += error_m <= 0.005;
      for (const int sigmas : {1, 2}) within[sigmas - 1] += error_m <= sigmas * heights[i].sigma_m;
      if (stairs_m(line[i].x_m - 2.5 * kCell_m) != truth_m) continue;
      inner++;
      narrow += heights[i].sigma_m < 0.02F;
    }
    for (const std::size_t foot : {30U, 58U})  // x = 0 and 0.28
    {
      risers++;
      const double middle_m = stairs_m(line[foot].x_m) - kRiser_m / 2;
      sharp += heights[foot - 6].z_m < middle_m && heights[foot + 5].z_m > middle_m;
    }
  }
  EXPECT_GT(treads, 1000);
  EXPECT_GT(flat, 0.95 * treads);
  EXPECT_GT(within[0], 0.63 * treads);
  EXPECT_GT(within[1], 0.90 * treads);
  EXPECT_GT(narrow, 0.8 * inner) << "away from a step down";
  EXPECT_GT(sharp, 0.95 * risers) << "of " << risers;
}

TEST(HeightScan, lies_on_a_ramp_wherever_the_robot_looks)
{
  const auto map = map_of([](double x, double y) { return 0.3 * x - 0.1 * y; });
  const Pose T = test::ExactScene::pose(0.2, -0.1, 5, 0.3, 0.2);  // only seen from above
  const Pose2 base = from_above(T);
  const auto points = grid();
  const auto heights = height_scan(map, T, points);
  for (std::size_t i = 0; i < points.size(); i++)
  {
    const double c = std::cos(base.yaw_rad), s = std::sin(base.yaw_rad);
    const double x = 0.2 + c * points[i].x_m - s * points[i].y_m;
    const double y = -0.1 + s * points[i].x_m + c * points[i].y_m;
    EXPECT_NEAR(heights[i].z_m, 0.3 * x - 0.1 * y, 0.003);
    EXPECT_LT(heights[i].sigma_m, 0.01);
  }
}

TEST(HeightScan, takes_the_nearest_height_where_nothing_is_known)
{
  const auto map = map_of([](double x, double) { return x < 0 ? 0.5 : NAN; });
  const auto heights =
      height_scan(map, Pose(), {{-0.1, 0}, {0.275, 0}, {0.775, 0}, {1.5, 0}, {9, 0}});
  EXPECT_EQ(heights[0].origin, HeightOrigin::Measured);
  EXPECT_EQ(heights[1].origin, HeightOrigin::Unknown);
  EXPECT_FLOAT_EQ(heights[1].z_m, 0.5F);
  EXPECT_NEAR(heights[1].sigma_m, std::hypot(0.02, 0.3 * 0.3), 1e-3);
  EXPECT_GT(heights[2].sigma_m, heights[1].sigma_m);
  EXPECT_TRUE(std::isnan(heights[3].z_m) && std::isnan(heights[3].sigma_m));
  EXPECT_TRUE(std::isnan(heights[4].z_m));
  EXPECT_TRUE(std::isnan(height_scan(ElevationMapper({}, Backend::Cpu), Pose(), {{0, 0}})[0].z_m));
  Pose nowhere;
  nowhere.m[3] = NAN;
  EXPECT_THROW(height_scan(map, nowhere, {{0, 0}}), std::invalid_argument);
}

TEST(HeightScan, is_less_sure_between_two_surfaces_and_on_steep_fills)
{
  const auto sigma_m = [](double slope, double gap_m, CellState state)
  {
    const auto map = map_of([=](double x, double) { return slope * x; }, gap_m, state);
    return height_scan(map, Pose(), {{0.4, 0}})[0].sigma_m;
  };
  const float flat_m = sigma_m(0, 0, CellState::Measured);
  EXPECT_LT(flat_m, 0.01F);
  EXPECT_NEAR(sigma_m(0, 0.03, CellState::Measured), std::hypot(flat_m, 0.03 / std::sqrt(3)), 1e-4);
  EXPECT_NEAR(sigma_m(0, 0, CellState::FilledTwoSided), std::hypot(flat_m, 0.02), 1e-4);
  EXPECT_NEAR(sigma_m(0.5, 0, CellState::FilledTwoSided), std::hypot(flat_m, 0.03), 1e-4);
}

TEST(HeightScan, of_187_points_takes_microseconds)
{
#ifdef TALUS_SANITIZER
  GTEST_SKIP() << "a sanitizer takes its time";
#endif
  const auto points = grid();
  double best_us = 1e9;
  for (int i = 0; i < 200; i++)
  {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(height_scan(map_of_stairs(), Pose(), points).size(), 187U);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
    best_us = std::min(best_us, took.count());
  }
  RecordProperty("us", std::to_string(best_us));
  EXPECT_LT(best_us, 30) << "13 us on a core that does nothing else";
}
