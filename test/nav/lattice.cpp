// Routes of a robot of 0.6 x 0.5 m on costmaps, how it follows them, and what it keeps away from.
#include "libs/nav/src/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/lab/talus-nav/follow.h"

namespace
{
using talus::nav::Costmap;
using talus::nav::Point2;
using talus::nav::Pose2;
using talus::nav::Route;

constexpr double kCell_m = 0.05;
constexpr float kFree = 0.95F, kWall = 0.05F, kDrop = 0.15F;
constexpr double kArrives_m = 0.35;

const talus::nav::RobotBody kBody;  // 0.6 x 0.5 m

double level(const Pose2&) { return 0; }

/** A costmap of 8 x 6 m that is free, around (0, 0). */
struct Floor
{
  Floor()
  {
    grid.cover(-4, 4, -3, 3);
    for (float& p : grid.free) p = kFree;
  }

  Floor& with(float p, double x0, double x1, double y0, double y1)
  {
    each(
        [&](const Point2& at, float& cell)
        {
          if (at.x_m > x0 && at.x_m < x1 && at.y_m > y0 && at.y_m < y1) cell = p;
        });
    return *this;
  }
  Floor& wall_with_door(double width_m)
  {
    return with(kWall, 0, 0.1, -3, -width_m / 2).with(kWall, 0, 0.1, width_m / 2, 3);
  }
  Route way(
      const Pose2& from, const Point2& to,
      const talus::nav::GroundCostAt& ground_cost = level) const
  {
    const talus::nav::Lattice lattice(kBody.footprint(), kCell_m);
    return lattice.plan(grid, 0, from, to, kArrives_m, ground_cost);
  }
  /** From the outline of the robot to the nearest cell that is blocked. */
  double clearance_m(const Pose2& robot)
  {
    double least_m = 1e9;
    const auto body = kBody.footprint();
    each(
        [&](const Point2& at, float p)
        {
          if (p <= 0.5F) least_m = std::min(least_m, body.outside_m(robot.to_robot(at)));
        });
    return least_m;
  }
  double least_clearance_m(const Route& way)
  {
    double least_m = 1e9;
    for (const auto& p : way) least_m = std::min(least_m, clearance_m({p.x_m, p.y_m, p.yaw_rad}));
    return least_m;
  }
  template <class Visit>
  void each(const Visit& visit)
  {
    for (int y = 0; y < grid.rows; y++)
      for (int x = 0; x < grid.columns; x++)
        visit(
            Point2{grid.min_x_m() + (x + 0.5) * kCell_m, grid.min_y_m() + (y + 0.5) * kCell_m},
            grid.free[grid.index(x, y)]);
  }

  Costmap grid{kCell_m, 0, 0, 0, 0, {}};
};

/** A corridor along x, 0.9 m wide, that turns to the left at x = 2. */
Floor corridor()
{
  return Floor()
      .with(kWall, -4, 4, -3, -0.45)
      .with(kWall, 2.45, 4, -3, 3)
      .with(kWall, -4, 1.55, 0.45, 3);
}

/** Where a robot comes to that follows a way, and how near to what blocks. */
struct Drive
{
  Drive(Floor floor, const Route& way, Pose2 at)
  {
    talus::nav::Follower follower;
    for (int i = 0; i < 2000; i++)
    {
      const auto speeds = follower.follow(way, at);
      at.x_m += 0.05 * speeds.v_mps * std::cos(at.yaw_rad);
      at.y_m += 0.05 * speeds.v_mps * std::sin(at.yaw_rad);
      at.yaw_rad += 0.05 * speeds.w_radps;
      if (i % 10 == 0) least_m = std::min(least_m, floor.clearance_m(at));
      if (std::hypot(at.x_m - way.back().x_m, at.y_m - way.back().y_m) < 0.1) break;
    }
    end = at;
  }
  Pose2 end;
  double least_m = 1e9;
};

TEST(Lattice, passes_doors_that_are_as_wide_as_the_robot_and_a_little)
{
  for (const double width_m : {0.95, 0.85, 0.75})
  {
    Floor floor = Floor().wall_with_door(width_m);
    const auto way = floor.way({-2, 1, 0}, {2, -1});
    ASSERT_FALSE(way.empty()) << width_m;
    EXPECT_NEAR(way.back().x_m, 2, 0.1);
    EXPECT_NEAR(way.back().y_m, -1, 0.1);
    EXPECT_GT(floor.least_clearance_m(way), 0.04);
    EXPECT_GT(Drive(floor, way, {-2, 1, 0}).least_m, 0.03);
  }
  EXPECT_TRUE(Floor().wall_with_door(0.5).way({-2, 0, 0}, {2, 0}).empty());
}

TEST(Lattice, keeps_ten_centimetres_away_from_edges_whatever_the_heading)
{
  Floor bridge = Floor().with(kDrop, -1, 1, -3, -0.45).with(kDrop, -1, 1, 0.45, 3);
  const auto way = bridge.way({-2, 1.5, 1.6}, {2, -1.5});
  ASSERT_FALSE(way.empty());
  EXPECT_GT(bridge.least_clearance_m(way), 0.1 + kCell_m / 2);
  Floor narrow = Floor().with(kDrop, -1, 1, -3, -0.35).with(kDrop, -1, 1, 0.35, 3);
  EXPECT_TRUE(narrow.way({-2, 0, 0}, {2, 0}).empty()) << "a wall would let it pass";
}

TEST(Lattice, turns_in_a_corridor_with_a_right_angle)
{
  Floor floor = corridor();
  const Pose2 start{-2, 0, 0};
  const auto way = floor.way(start, {2, 2.5});
  ASSERT_FALSE(way.empty());
  EXPECT_GT(floor.least_clearance_m(way), 0.04);
  EXPECT_TRUE(std::all_of(way.begin(), way.end(), [](const auto& p) { return !p.backwards; }));
  EXPECT_FALSE(talus::nav::is_narrow(way, start, 0.6)) << "20 cm on both sides";
  EXPECT_TRUE(talus::nav::is_narrow(way, {2, 0, 0}, 0.6)) << "it turns";
  const Drive drive(floor, way, start);
  EXPECT_GT(drive.least_m, 0.02);
  EXPECT_NEAR(drive.end.y_m, 2.5, 0.2);
}

TEST(Lattice, turns_off_a_wall_that_it_faces_between_two)
{
  // The corners pass at 6 cm less half a cell.
  Floor floor = Floor().with(kWall, -4, 4, 0.41, 3).with(kWall, -4, 4, -3, -0.41);
  const auto way = floor.way({0, 0, M_PI / 2}, {3, 0});
  ASSERT_FALSE(way.empty());
  EXPECT_GT(floor.least_clearance_m(way), 0.01);
}

TEST(Lattice, goes_backwards_where_it_cannot_turn)
{
  Floor alley =
      Floor().with(kWall, -1, 4, -3, -0.35).with(kWall, -1, 4, 0.35, 3).with(kWall, 2, 4, -3, 3);
  const Pose2 start{1.5, 0, 0};
  const auto way = alley.way(start, {-3, 0});
  ASSERT_FALSE(way.empty());
  EXPECT_TRUE(way[5].backwards);
  const Drive drive(alley, way, start);
  EXPECT_GT(drive.least_m, 0.02);
  EXPECT_NEAR(drive.end.x_m, -3, 0.2);
}

TEST(Lattice, leaves_a_start_that_is_nearer_to_a_wall_or_an_edge_than_it_may_come)
{
  const auto least_m = [](float p, double from_y_m)
  {
    Floor floor = Floor().with(p, -4, 4, from_y_m, 0.5);
    const auto way = floor.way({-2, 0, 0}, {2, 0});
    return way.empty() ? 0 : floor.least_clearance_m(way);
  };
  EXPECT_GT(least_m(kWall, 0.27), 0.02) << "2 to 3 cm beside it";
  EXPECT_GT(least_m(kDrop, 0.36), 0.1) << "12 cm beside it";
}

TEST(Lattice, takes_a_ramp_straight)
{
  // As from a wide ramp of 15 degrees, uphill along x, from x = -1 to 1.
  const auto ramp = [](const Pose2& at)
  {
    if (std::abs(at.x_m) > 1) return 0.0;
    return std::hypot(0.44 * std::cos(at.yaw_rad), 0.65 * std::sin(at.yaw_rad));
  };
  double on_ramp_m = 0, aside_m = 0;
  const auto way = Floor().way({-3, -1.5, 0}, {3, 1.5}, ramp);
  ASSERT_FALSE(way.empty());
  for (std::size_t i = 1; i < way.size(); i++)
    if (way[i].tilted)
    {
      on_ramp_m += std::abs(way[i].x_m - way[i - 1].x_m);
      aside_m += std::abs(way[i].y_m - way[i - 1].y_m);
    }
  EXPECT_NEAR(on_ramp_m, 2, 0.2);
  EXPECT_LT(aside_m, 0.1);
}

TEST(Lattice, goes_around_ground_on_which_the_robot_must_not_stand)
{
  const auto pit = [](const Pose2& at) { return std::hypot(at.x_m, at.y_m) < 0.7 ? 1.0 : NAN; };
  const auto way = Floor().way({-2, 0, 0}, {2, 0}, pit);
  ASSERT_FALSE(way.empty());
  for (const auto& p : way) EXPECT_GE(std::hypot(p.x_m, p.y_m), 0.7);
  EXPECT_FALSE(Floor().way({0, 0.3, 0}, {2, 0}, pit).empty()) << "a robot in it gets away";
}

TEST(Lattice, ends_beside_a_goal_that_is_blocked_and_finds_the_same_way_again)
{
  Floor floor = Floor().with(kWall, 1.9, 2.1, -0.1, 0.1);
  const auto way = floor.way({-2, 0, 0}, {2.3, 0}), again = floor.way({-2, 0, 0}, {2.3, 0});
  ASSERT_FALSE(way.empty());
  EXPECT_LE(std::hypot(way.back().x_m - 2.3, way.back().y_m), kArrives_m + kCell_m);
  ASSERT_EQ(way.size(), again.size());
  for (std::size_t i = 0; i < way.size(); i++)
  {
    EXPECT_EQ(way[i].x_m, again[i].x_m);
    EXPECT_EQ(way[i].yaw_rad, again[i].yaw_rad);
  }
}

TEST(Lattice, refuses_a_robot_that_reaches_over_the_border_of_its_grid)
{
  talus::nav::RobotBody large;
  large.length_m = 1.2;
  large.width_m = 0.8;
  EXPECT_THROW(talus::nav::Lattice(large.footprint(), 0.05), std::invalid_argument);
  EXPECT_NO_THROW(talus::nav::Lattice(large.footprint(), 0.1));
}

TEST(ClearTime, lets_a_robot_that_is_near_an_edge_come_no_nearer_step_by_step)
{
  double ahead_m = 0.35;  // 5 cm before its front
  for (int i = 0; i < 20; i++)
    ahead_m -= 0.1 * talus::nav::clear_time_s({{ahead_m, 0, true}}, {}, 0.1, 0, 5, false);
  EXPECT_GT(ahead_m, 0.345);
  EXPECT_EQ(talus::nav::clear_time_s({{0.35, 0, true}}, {}, -0.1, 0, 5, false), 5) << "away";
}

TEST(ClearTime, is_short_before_edges_and_longer_before_walls_where_it_is_narrow)
{
  const talus::nav::RobotBody body;
  const auto clear_s = [&](bool is_edge, bool narrow) {
    return talus::nav::clear_time_s({{0.8, 0.2, is_edge}}, body, 0.5, 0, 5, narrow);
  };
  EXPECT_NEAR(clear_s(true, false), 0.8, 0.07);  // 0.3 m to the front, 0.1 m away
  EXPECT_NEAR(clear_s(true, true), 0.8, 0.07);
  EXPECT_NEAR(clear_s(false, false), 0.8, 0.07);
  EXPECT_NEAR(clear_s(false, true), 0.96, 0.07);
}

TEST(Unseen, blocks_what_was_not_seen_from_nearby_until_it_was_seen)
{
  talus::nav::UnseenCells unseen;
  Floor floor;
  EXPECT_FALSE(unseen.block(floor.grid));
  unseen.remember({-1, 0, 0}, floor.grid, Floor().with(kDrop, -0.4, 0, -0.2, 0.2).grid);
  floor.grid.cover(-6, 4, -3, 5);  // a costmap grows
  const auto place = [](const Costmap& grid)
  {
    return grid.free[grid.index(
        static_cast<int>((-0.2 - grid.min_x_m()) / kCell_m),
        static_cast<int>(-grid.min_y_m() / kCell_m))];
  };
  const auto blocked = [&](Floor now)
  {
    EXPECT_TRUE(unseen.block(now.grid));
    return now;
  };
  EXPECT_LT(place(blocked(floor).grid), 0.2F);
  unseen.remember({-3, 0, 0}, floor.grid, floor.grid);
  EXPECT_LT(place(blocked(floor).grid), 0.2F) << "from farther away nobody knows";
  unseen.remember({-0.7, 0, 0}, floor.grid, floor.grid);
  EXPECT_FALSE(unseen.block(floor.grid)) << "it was seen";
}
}  // namespace
