// Routes on a map: one at once, and on a drive.
#include <gtest/gtest.h>
#include <talus/nav/route.h>

#include <cmath>
#include <stdexcept>

using namespace talus::nav;
using talus::CellState;
using talus::Layer;
using talus::MapSnapshot;
using talus::Pose;

namespace
{
/** 8 x 8 m of level ground around the origin, with a wall at x = 1 but for a door around y = 2. */
MapSnapshot room()
{
  MapSnapshot map;
  map.window = {160, 0.05, -80, -80};
  for (int iy = 0; iy < 160; iy++)
    for (int ix = 0; ix < 160; ix++)
    {
      const bool wall = (ix == 100 || ix == 101) && std::abs(iy - 120) > 10;
      for (const auto& [layer, value] :
           {std::pair{Layer::GroundElevation, 0.0F},
            {Layer::Elevation, wall ? 1.0F : 0.0F},
            {Layer::Variance, 1e-4F},
            {Layer::State, static_cast<float>(CellState::Measured)},
            {Layer::Traversability, wall ? 0.0F : 1.0F}})
        map.layers[static_cast<std::size_t>(layer)].push_back(value);
    }
  return map;
}
const Footprint kRobot;
}  // namespace

TEST(Planner, leads_through_a_door_to_the_goal)
{
  const auto route = plan(room(), Pose(), {3, 0}, kRobot);
  ASSERT_FALSE(route.empty());
  EXPECT_NEAR(route.front().x_m, 0, 1e-9);
  EXPECT_NEAR(route.back().x_m, 3, 0.1);
  for (const auto& p : route)
    EXPECT_TRUE(std::abs(p.x_m - 1.05) > 0.05 || std::abs(p.y_m - 2.02) < 0.25) << p.y_m;
  EXPECT_NEAR(point_ahead(route, {0, 0, 0}, 1e9).x_m, route.back().x_m, 1e-9);
}

TEST(Planner, hopes_for_a_route_beyond_the_map)
{
  const auto route = plan(room(), Pose(), {6, 0}, kRobot);
  ASSERT_FALSE(route.empty());
  EXPECT_NEAR(route.back().x_m, 6, 0.1);
}

TEST(Planner, remembers_on_a_drive_what_left_the_window)
{
  Planner planner(kRobot, {0.05, 0, 0, 0, 0, {}});
  ASSERT_TRUE(planner.plan(room(), Pose(), {3, 0}));
  MapSnapshot later = room();  // all free, 5 m to the west: the wall is outside
  later.window.min_cell_x -= 100;
  for (float& t : later.layers[static_cast<std::size_t>(Layer::Traversability)]) t = 1;
  for (float& e : later.layers[static_cast<std::size_t>(Layer::Elevation)]) e = 0;
  Pose at;
  at.m[3] = -4;
  ASSERT_TRUE(planner.plan(later, at, {3, 0}));
  for (const auto& p : planner.route())
    EXPECT_TRUE(std::abs(p.x_m - 1.05) > 0.05 || std::abs(p.y_m - 2.02) < 0.25) << p.y_m;
}

TEST(Planner, refuses_what_is_no_pose_and_goals_farther_than_a_costmap_reaches)
{
  Pose nowhere;
  nowhere.m[3] = NAN;
  EXPECT_THROW(plan(room(), nowhere, {3, 0}, kRobot), std::invalid_argument);
  EXPECT_THROW(plan(room(), Pose(), {NAN, 0}, kRobot), std::invalid_argument);
  EXPECT_THROW(plan(room(), Pose(), {1e7, 1e7}, kRobot), std::invalid_argument);
}
