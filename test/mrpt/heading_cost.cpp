// What the ground does with a robot at one place and heading, on maps of known heights.
#include <gtest/gtest.h>
#include <talus/elevation_mapper.h>
#include <talus/mrpt/heading_cost.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

using namespace talus;
using mrpt::math::TPose2D;

namespace
{
constexpr double kRight = M_PI / 2;
using Surface = std::function<double(double, double)>;

/** 4 x 4 m around the origin: the ground, and what stands on it. */
MapSnapshot map_of(const Surface& ground, const Surface& elevation)
{
  MapSnapshot map;
  map.window = {80, 0.05, -40, -40};
  for (const Layer l : {Layer::GroundElevation, Layer::Elevation})
  {
    auto& heights = map.layers[static_cast<std::size_t>(l)];
    for (int iy = 0; iy < 80; ++iy)
      for (int ix = 0; ix < 80; ++ix)
        heights.push_back(static_cast<float>((l == Layer::Elevation ? elevation : ground)(
            -2 + (ix + 0.5) * 0.05, -2 + (iy + 0.5) * 0.05)));
  }
  return map;
}
MapSnapshot map_of(const Surface& ground) { return map_of(ground, ground); }

double level(double, double) { return 0; }
/** Rises by 0.3 m a metre along x: 16.7 degrees. */
double ramp(double x, double) { return 0.3 * x; }
}  // namespace

TEST(HeadingCost, LevelGroundCostsNothing)
{
  const auto map = map_of(level);
  const HeadingCost c = heading_cost(map, Footprint(), TPose2D(0.3, -0.2, 0.7));
  EXPECT_EQ(c.along_rad, 0);
  EXPECT_EQ(c.across_rad, 0);
  EXPECT_EQ(c.step_m, 0);
  EXPECT_DOUBLE_EQ(c.clearance_m, 0.1);
  EXPECT_EQ(c.cost, 0);
}

TEST(HeadingCost, ARampTiltsAlongOrAcrossByTheHeading)
{
  const auto map = map_of(ramp);
  const HeadingCost up = heading_cost(map, Footprint(), TPose2D(0, 0, 0));
  EXPECT_NEAR(up.along_rad, std::atan(0.3), 1e-3);
  EXPECT_NEAR(up.across_rad, 0, 1e-3);
  const HeadingCost beside = heading_cost(map, Footprint(), TPose2D(0, 0, kRight));
  EXPECT_NEAR(beside.along_rad, 0, 1e-3);
  EXPECT_NEAR(beside.across_rad, -std::atan(0.3), 1e-3) << "the left side is the lower one";
  EXPECT_NEAR(up.cost, std::atan(0.3) / 0.6, 0.01);
  EXPECT_NEAR(beside.cost, std::atan(0.3) / 0.4, 0.01) << "dearer than straight up";
  const HeadingCost down = heading_cost(map, Footprint(), TPose2D(0, 0, M_PI));
  EXPECT_NEAR(down.along_rad, -std::atan(0.3), 1e-3);
  EXPECT_LT(up.step_m, 0.01) << "a slope is no step";
  EXPECT_NEAR(up.clearance_m, 0.1, 0.02);
}

TEST(HeadingCost, AStoneBetweenTheWheelsIsClearedAndUnderAWheelIsAStep)
{
  const auto stone = [](double x, double y) { return std::hypot(x, y) < 0.1 ? 0.07 : 0.0; };
  const auto map = map_of(level, stone);
  const HeadingCost between = heading_cost(map, Footprint(), TPose2D(0, 0, 0.4));
  EXPECT_EQ(between.step_m, 0);
  EXPECT_NEAR(between.clearance_m, 0.03, 1e-6);
  EXPECT_NEAR(between.cost, 0.7, 1e-5);
  const HeadingCost under = heading_cost(map, Footprint(), TPose2D(-0.23, -0.24, 0));
  EXPECT_GT(under.step_m, 0.03);
  EXPECT_GT(under.along_rad, 0.03);
  EXPECT_GT(under.across_rad, 0.03);
}

TEST(HeadingCost, AWheelOverAnEdgeIsImpassableAndTheBodyOverItIsNot)
{
  const auto edge = [](double x, double) { return x < 0.5 ? 0.0 : -0.5; };
  const auto map = map_of(edge);
  EXPECT_EQ(heading_cost(map, Footprint(), TPose2D(0.27, 0, 0)).cost, 1) << "on the edge";
  const HeadingCost before = heading_cost(map, Footprint(), TPose2D(0.15, 0, 0));
  EXPECT_EQ(before.cost, 0) << "the wheels end at 0.46 m";
  EXPECT_EQ(heading_cost(map, Footprint(), TPose2D(0.5, 0, 0)).cost, 1) << "half of it";
}

TEST(HeadingCost, WhatStandsInTheBodyIsImpassable)
{
  const auto post = [](double x, double y) { return std::hypot(x - 0.2, y) < 0.05 ? 0.8 : 0.0; };
  const HeadingCost c = heading_cost(map_of(level, post), Footprint(), TPose2D(0, 0, 0));
  EXPECT_NEAR(c.clearance_m, -0.7, 1e-6);
  EXPECT_EQ(c.cost, 1);
}

TEST(HeadingCost, UnknownGroundUnderAWheelIsUnknown)
{
  const auto half = [](double x, double)
  { return x < 0.2 ? 0.0 : std::numeric_limits<double>::quiet_NaN(); };
  const auto map = map_of(half);
  EXPECT_FALSE(std::isnan(heading_cost(map, Footprint(), TPose2D(0, 0, 0)).cost))
      << "cells of the wheels are known in part";
  EXPECT_TRUE(std::isnan(heading_cost(map, Footprint(), TPose2D(0.2, 0, 0)).cost));
  EXPECT_TRUE(std::isnan(heading_cost(map, Footprint(), TPose2D(7, 0, 0)).cost)) << "outside";
  EXPECT_TRUE(std::isnan(heading_cost(map, Footprint(), TPose2D(1e300, 0, 0)).cost));
  const ElevationMapper empty{Parameters()};
  EXPECT_TRUE(std::isnan(heading_cost(empty, Footprint(), TPose2D(0, 0, 0)).along_rad));
}

TEST(HeadingCost, WhatMakesNoRobotIsRefused)
{
  const auto map = map_of(level);
  Footprint line;
  line.wheels = {{0.2, 0}, {0, 0}, {-0.2, 0}};
  EXPECT_THROW(heading_cost(map, line, TPose2D(0, 0, 0)), std::invalid_argument);
  Footprint none;
  none.wheels.clear();
  EXPECT_THROW(heading_cost(map, none, TPose2D(0, 0, 0)), std::invalid_argument);
  Footprint limits;
  limits.max_across_rad = std::nan("");
  EXPECT_THROW(heading_cost(map, limits, TPose2D(0, 0, 0)), std::invalid_argument);
  EXPECT_THROW(heading_cost(map, Footprint(), TPose2D(NAN, 0, 0)), std::invalid_argument);
}
