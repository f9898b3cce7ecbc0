// The paper's method as printed, and the maps that it was compared with: against cases worked out
// by hand.
#include <gtest/gtest.h>
#include <talus/baselines/fills.h>
#include <talus/baselines/method.h>

#include <cmath>

#include "small_window.h"

using namespace talus;
using namespace talus::baselines;

namespace
{
using Points = std::vector<std::array<float, 3>>;

const std::vector<std::string> kRivals{"paper", "highest", "cucpp", "cupy"};

/** Middle of the cell with an index from the window's first. */
float middle(int i) { return 0.1f * static_cast<float>(i - 10) + 0.05f; }

/** The floor of the whole window at a height. */
Points floor_at(float z_m)
{
  Points points;
  for (int k = 0; k < 400; ++k) points.push_back({middle(k % 20), middle(k / 20), z_m});
  return points;
}

bool is_box(int ix, int iy) { return ix >= 14 && ix <= 15 && iy >= 9 && iy <= 11; }

/** With a box 0.4 m high of 2 x 3 cells ahead. */
Points floor_with_box()
{
  Points points = floor_at(0);
  for (int k = 0; k < 400; ++k)
    if (is_box(k % 20, k / 20)) points[k][2] = 0.4f;
  for (int iy = 9; iy <= 11; ++iy)
    for (const float z_m : {0.02f, 0.2f}) points.push_back({middle(14), middle(iy), z_m});
  return points;
}

Surfaces after(const std::string& method, const std::vector<Points>& frames)
{
  const auto map = make_method(method, small_window());
  double stamp_s = 100;
  for (const Points& points : frames) map->update(Scan(points, stamp_s += 0.1).view());
  return map->read();
}

TEST(Rivals, AllSeeABoxOnAFlatFloorAndThatTheFloorAwayFromItIsFree)
{
  for (const std::string& method : kRivals)
  {
    const Surfaces s = after(method, {floor_with_box(), floor_with_box()});
    const float most = method == "cucpp" ? 0.5f : 0.0f;  // it knows no steps
    EXPECT_LE(at(s, s.traversability, middle(14), middle(10)), most) << method;
    EXPECT_LE(at(s, s.traversability, middle(15), middle(10)), most) << method;
    EXPECT_GT(at(s, s.traversability, middle(2), middle(10)), 0.9f) << method;
    EXPECT_GT(at(s, s.traversability, middle(14), middle(3)), 0.9f) << method;
    EXPECT_NEAR(at(s, s.ground_m, middle(2), middle(10)), 0.0f, kFloat_m) << method;
  }
}

TEST(CuCppMap, JudgesHalfBySlopeAndHalfByRoughness)
{
  Points ramp = floor_at(0);
  for (auto& p : ramp) p[2] = 0.2f * p[0];
  const Surfaces s = after("cucpp", {ramp});
  const double slope = 1 - std::atan(0.2) / 0.6;
  EXPECT_NEAR(at(s, s.traversability, 0.05, 0.05), 0.5 * slope + 0.5, 1e-4);
}

TEST(CuCppMap, ErasesWhatRaysWentThroughInTheNextFrame)
{
  const auto map = make_method("cucpp", small_window());
  map->update(Scan({{0.45f, 0.05f, 0.45f}}, 10.0).view());
  map->update(Scan({{0.85f, 0.05f, 0.0f}}, 10.1).view());
  const Surfaces s = map->read();
  EXPECT_TRUE(std::isnan(at(s, s.elevation_m, 0.45, 0.05)));
}

TEST(CuPyMap, FollowsATenthOfTheMeanErrorOnFlatCells)
{
  Parameters p = small_window();
  const auto map = make_method("cupy", p);
  map->update(Scan(floor_at(0), 10.0).view());
  Points half;  // the other half is not hit in the second frame: drift alone moves it
  for (const auto& point : floor_at(0.02f))
    if (point[0] > 0) half.push_back(point);
  map->update(Scan(half, 10.1).view());
  const Surfaces s = map->read();
  EXPECT_NEAR(at(s, s.ground_m, middle(2), middle(10)), 0.002f, 1e-5f);
  EXPECT_GT(at(s, s.ground_m, middle(17), middle(10)), 0.01f);
}

TEST(CuPyMap, TakesAHeightOutsideItsGateOnlyWhenItComesAgainAndAgain)
{
  const auto map = make_method("cupy", small_window());
  map->update(Scan({{0.55f, 0.05f, 0.0f}}, 10.0).view());
  map->update(Scan({{0.55f, 0.05f, 0.3f}}, 10.1).view());
  EXPECT_NEAR(at(map->read(), map->read().ground_m, 0.55, 0.05), 0.0f, kFloat_m);
  for (int i = 2; i < 20; ++i) map->update(Scan({{0.55f, 0.05f, 0.3f}}, 10 + 0.1 * i).view());
  EXPECT_NEAR(at(map->read(), map->read().ground_m, 0.55, 0.05), 0.3f, 0.02f);
}

TEST(CuPyMap, LeavesOutWhatHangsAboveTheSensorAndFillsEveryGap)
{
  Points points{{0.55f, 0.05f, 0.75f}};  // 0.25 m above the sensor
  for (const auto& point : floor_at(-0.25f))
    if (std::abs(point[0]) > 0.3f) points.push_back(point);
  const Surfaces s = after("cupy", {points});
  for (std::size_t i = 0; i < s.size(); ++i)
  {
    EXPECT_NEAR(s.ground_m[i], -0.25f, 1e-3f);
    EXPECT_GT(s.traversability[i], 0.9f);
  }
  EXPECT_EQ(
      s.state[cell_index(s.window, 0.05, 0.05)],
      static_cast<std::uint8_t>(CellState::FilledOneSided));
}

/** Sees some points a frame. */
class PrintedMap
{
 public:
  explicit PrintedMap(const Parameters& p = small_window()) : map_(make_method("paper", p)) {}
  void see(const Points& points) { map_->update(Scan(points, stamp_s_ += 0.1).view()); }
  float ground_m(double x_m, double y_m = 0.05) { return value(&Surfaces::ground_m, x_m, y_m); }
  float elevation_m(double x_m, double y_m = 0.05)
  {
    return value(&Surfaces::elevation_m, x_m, y_m);
  }
  CellState state(double x_m, double y_m = 0.05)
  {
    const Surfaces s = map_->read();
    return static_cast<CellState>(s.state[cell_index(s.window, x_m, y_m)]);
  }
  Surfaces read() { return map_->read(); }

 private:
  float value(std::vector<float> Surfaces::*layer, double x_m, double y_m)
  {
    const Surfaces s = map_->read();
    return at(s, s.*layer, x_m, y_m);
  }

  std::unique_ptr<Method> map_;
  double stamp_s_ = 0;
};

TEST(PaperMap, Equations5To7FuseInsideTheGateAndKeepTheHighestAndTheLowestOutside)
{
  Parameters p = small_window();
  p.a_beam = 0;  // all points have the same variance
  PrintedMap map(p);
  map.see({{0.55f, 0.05f, 0.1f}, {0.55f, 0.05f, 0.12f}});  // two deviations apart
  EXPECT_NEAR(map.ground_m(0.55), 0.11f, kFloat_m);
  map.see({{0.55f, 0.05f, 0.0f}, {0.55f, 0.05f, 0.4f}});
  EXPECT_NEAR(map.ground_m(0.55), 0.0f, kFloat_m);
  EXPECT_NEAR(map.elevation_m(0.55), 0.4f, kFloat_m);
  map.see({{0.55f, 0.05f, 0.2f}});  // higher than the one and lower than the other
  EXPECT_NEAR(map.ground_m(0.55), 0.0f, kFloat_m);
  EXPECT_NEAR(map.elevation_m(0.55), 0.4f, kFloat_m);
}

TEST(PaperMap, Equation4MakesPointsLessSureAfterTheSensorHasTilted)
{
  Parameters p = small_window();
  p.a_beam = 0;
  const auto map = make_method("paper", p);
  Scan first({{0.55f, 0.05f, 0.0f}}, 10.0);
  map->update(first.view());
  const float angle = 0.05f, range_m = std::sqrt(0.55f * 0.55f + 0.05f * 0.05f + 0.5f * 0.5f);
  Scan second({{0.55f, 0.05f, 0.02f}}, 10.1);
  Frame frame = second.view();
  frame.T_map_sensor.m = {std::cos(angle),  0, std::sin(angle), 0,  0, 1, 0, 0,
                          -std::sin(angle), 0, std::cos(angle), 0.5};
  // The point of the map frame, seen by the tilted sensor.
  const float x = 0.55f * std::cos(angle) + 0.48f * std::sin(angle);
  const float z = 0.55f * std::sin(angle) - 0.48f * std::cos(angle), y = 0.05f;
  frame.x_m = &x, frame.y_m = &y, frame.z_m = &z;
  map->update(frame);
  const float before = 0.01f * 0.01f, turn_m = range_m * std::sin(angle / 2);
  const float now = before + turn_m * turn_m;
  const Surfaces s = map->read();
  // The range of the second point is a little shorter.
  EXPECT_NEAR(at(s, s.ground_m, 0.55, 0.05), 0.02f * before / (before + now), 2e-4f);
}

TEST(PaperMap, Figure3WhatIsSeenHighAboveKnownGroundHangs)
{
  PrintedMap map;
  map.see({{0.55f, 0.05f, 0.0f}});
  map.see({{0.55f, 0.05f, 0.7f}, {0.55f, 0.05f, 0.9f}});
  EXPECT_NEAR(map.elevation_m(0.55), 0.0f, kFloat_m);
  map.see({{0.55f, 0.05f, 0.4f}, {0.55f, 0.05f, 0.9f}});  // stands: as high as the highest
  EXPECT_NEAR(map.elevation_m(0.55), 0.9f, kFloat_m);
}

TEST(PaperMap, Figure3NewGroundDropsWhatHangsOverIt)
{
  PrintedMap map;
  map.see({{0.55f, 0.05f, 0.8f}});
  EXPECT_NEAR(map.ground_m(0.55), 0.8f, kFloat_m);
  map.see({{0.55f, 0.05f, 0.0f}, {0.55f, 0.05f, 0.1f}, {0.55f, 0.05f, 0.85f}});
  EXPECT_NEAR(map.ground_m(0.55), 0.0f, kFloat_m);
  EXPECT_NEAR(map.elevation_m(0.55), 0.1f, kFloat_m);
}

TEST(PaperMap, Figure4AMoverThatHasLeftFallsToItsGroundAndLeavesNoHole)
{
  PrintedMap map;
  map.see({{0.45f, 0.05f, 0.0f}, {0.45f, 0.05f, 0.45f}, {0.85f, 0.05f, 0.0f}});
  EXPECT_NEAR(map.elevation_m(0.45), 0.45f, kFloat_m);
  // The ray to the next hit behind it passes at 0.5 * (1 - 4 / 8) = 0.25 m.
  map.see({{0.85f, 0.05f, 0.0f}});
  EXPECT_NEAR(map.elevation_m(0.45), 0.0f, kFloat_m);
  EXPECT_NEAR(map.ground_m(0.45), 0.0f, kFloat_m);
}

TEST(PaperMap, Figure4WhatIsLowerThanTheRayBehindItStays)
{
  PrintedMap map;
  map.see({{0.45f, 0.05f, 0.0f}, {0.45f, 0.05f, 0.2f}});
  map.see({{0.85f, 0.05f, 0.0f}});
  EXPECT_NEAR(map.elevation_m(0.45), 0.2f, kFloat_m);
}

TEST(PaperMap, Equation8TakesTheLowestSampleAsThePriorAndLooksAlongTheLineAlone)
{
  PrintedMap map;
  map.see({{0.25f, 0.05f, 0.1f}, {0.35f, 0.05f, 0.3f}, {0.55f, 0.25f, 0.9f}});
  const double k1 = sparse_kernel(0.2, 2.0), k2 = sparse_kernel(0.3, 2.0);
  EXPECT_NEAR(map.ground_m(0.55), (0.1 + k1 * 0.3 + k2 * 0.1) / (1 + k1 + k2), 1e-5);
  EXPECT_EQ(map.state(0.55), CellState::FilledOneSided);
}

TEST(PaperMap, Equation9IsAsPrintedTheAverageBesideTheLowerSide)
{
  PrintedMap map;
  map.see({{0.25f, 0.05f, 0.0f}, {0.85f, 0.05f, 0.3f}});
  // Gaps of 0 and 4 cells: n1 + n2 = 4 shares of the lower, n2 = 4 of the higher.
  EXPECT_NEAR(map.ground_m(0.35), 0.15f, kFloat_m);
  // Of 4 and 0: the lower alone.
  EXPECT_NEAR(map.ground_m(0.75), 0.0f, kFloat_m);
  EXPECT_EQ(map.state(0.75), CellState::FilledTwoSided);
}

TEST(PaperMap, KeepsReliableFillsAndInfersTheOthersAnew)
{
  PrintedMap map;
  map.see({{0.25f, 0.05f, 0.0f}, {0.55f, 0.05f, 0.0f}});
  map.see({{0.25f, 0.05f, -0.2f}, {0.55f, 0.05f, -0.2f}});
  EXPECT_NEAR(map.ground_m(0.35), 0.0f, kFloat_m);  // two sides
  EXPECT_NEAR(map.ground_m(0.75), -0.2f, kFloat_m);  // one side
}

TEST(PaperMap, Equations10To13OnAFloorBesideAStep)
{
  Points points = floor_at(0);
  for (auto& p : points)
    if (p[0] > 0.5f) p[2] = 0.1f;
  PrintedMap map;
  map.see(points);
  const Surfaces s = map.read();
  // 5 x 5 cells, two columns of them higher: mean 0.04; the plane rises by 0.3 over a metre.
  const double slope = 1 - std::atan(0.3) / 0.6;
  const double below = 0.4 * slope + 0.3 * (1 + 0.04 / 0.4) + 0.3 * (1 + 0.04 / 0.2);
  EXPECT_NEAR(at(s, s.traversability, 0.45, 0.05), std::min(below, 1.0), 0.02);
  // On the step, three columns: mean 0.06, and 0.1 above the lowest.
  const double above = 0.4 * slope + 0.3 * (1 - 0.14 / 0.4) + 0.3 * (1 - 0.04 / 0.2);
  EXPECT_NEAR(at(s, s.traversability, 0.55, 0.05), above, 0.02);
}

TEST(PaperMap, Equation14CallsAOneSidedFillAmidDataADitchIfTheFarSideIsLow)
{
  Parameters p = small_window();
  p.fill_search_m = 0.2;
  Points points;  // floor up to 0.5 m, a gap, and a far side that is 0.3 m lower
  for (const auto& point : floor_at(0))
    if (point[0] < 0.5f) points.push_back(point);
  for (int iy = 0; iy < 20; ++iy) points.push_back({0.95f, middle(iy), -0.3f});
  PrintedMap map(p);
  map.see(points);
  EXPECT_EQ(map.state(0.55), CellState::FilledOneSided);
  const Surfaces s = map.read();
  EXPECT_EQ(at(s, s.sparsity, 0.55, 0.05), 0.0f);
  EXPECT_EQ(at(s, s.traversability, 0.55, 0.05), 0.0f);
}

}  // namespace
