// Obstacles and costmaps out of the map, on a floor with a box, a low box and a shadow.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/nav/planners/PlannerSimple2D.h>
#include <talus/mrpt/obstacles.h>
#include <talus/risk.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "message_of.h"
#include "room_for_maps.h"

using namespace talus;
using mrpt::maps::COccupancyGridMap2D;
using talus_test::CDualElevationMap;
using talus_test::CPose3D;
using talus_test::CSimplePointsMap;

namespace
{
/** What is not known is left to the planner. */
ObstacleOptions only_known()
{
  ObstacleOptions o;
  o.unseen = Unseen::Free;
  return o;
}

struct Extent
{
  float min_x = 1e9F, max_x = -1e9F, min_y = 1e9F, max_y = -1e9F;
};
Extent extent_of(const CSimplePointsMap& points)
{
  Extent e;
  for (std::size_t i = 0; i < points.size(); i++)
  {
    float x = 0, y = 0;
    points.getPoint(i, x, y);
    e = {std::min(e.min_x, x), std::max(e.max_x, x), std::min(e.min_y, y), std::max(e.max_y, y)};
  }
  return e;
}

std::size_t count_at(const CSimplePointsMap& points, float z)
{
  const auto& all = points.getPointsBufferRef_z();
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [z](float v) { return std::abs(v - z) < 1e-4F; }));
}

/** One box of the room, x in [1.02, 1.63], |y| <= 0.52, 0.45 m high; the other one is cut off. */
ObstacleOptions near_box()
{
  ObstacleOptions o = only_known();
  o.range_m = 1.75;
  return o;
}
CDualElevationMap seen_room() { return talus_test::map_of_room(); }

/** What a live map shows of the frames of map_of_room(). */
MapSnapshot snapshot_of_room()
{
  LiveMap live(
      talus_test::small_window(),
      {Layer::GroundElevation, Layer::Elevation, Layer::Variance, Layer::State, Layer::Sparsity,
       Layer::Traversability},
      Backend::Cpu);
  SensorPoints points;
  for (int i = 0; i < 3; i++)
  {
    const CPose3D pose(0.03 * i, -0.02 * i, 0, 0.1 * i, 0, 0);
    EXPECT_TRUE(points_from_observation(talus_test::scan_of_room(pose), points));
    Frame frame = frame_from(points, pose);
    frame.stamp_s += 0.1 * i;
    EXPECT_EQ(live.ingest(frame), FrameOrder::Newest);
  }
  return *live.snapshot();
}

const CPose3D kRight(0, -0.6, 0, 0, 0, 0);  // a place from where the range holds only that box

constexpr double kCell_m = 0.05, kFeature_m = 0.15;
}  // namespace

TEST(Obstacles, lie_around_the_box_in_the_frame_of_the_robot)
{
  const auto map = seen_room();
  CSimplePointsMap points;
  obstacles_2d(map.mapper(), kRight, near_box(), points);
  const auto e = extent_of(points);
  EXPECT_NEAR(e.min_x, 1.02, kFeature_m + kCell_m);
  EXPECT_NEAR(e.min_y, 0.08, kFeature_m + kCell_m) << "-0.52 in the map";
  EXPECT_EQ(count_at(points, 0.1F), points.size()) << "all at the height of the option";
}

TEST(Obstacles, turn_with_the_yaw_of_the_robot_only)
{
  const auto map = seen_room();
  CSimplePointsMap level, turned;
  obstacles_2d(map.mapper(), kRight, near_box(), level);
  obstacles_2d(map.mapper(), CPose3D(0, -0.6, 0.4, M_PI / 2, 0.2, -0.1), near_box(), turned);
  ASSERT_EQ(level.size(), turned.size());
  const auto a = extent_of(level), b = extent_of(turned);
  EXPECT_NEAR(b.min_x, a.min_y, 1e-5);
  EXPECT_NEAR(b.max_y, -a.min_x, 1e-5);
}

TEST(Obstacles, are_only_the_boundary_and_one_a_square)
{
  const auto map = seen_room();
  ObstacleOptions all = near_box();
  all.spacing_m = 0;
  all.boundary_only = false;
  CSimplePointsMap filled, boundary, thinned;
  obstacles_2d(map.mapper(), kRight, all, filled);
  all.boundary_only = true;
  obstacles_2d(map.mapper(), kRight, all, boundary);
  obstacles_2d(map.mapper(), kRight, near_box(), thinned);
  EXPECT_LT(boundary.size(), filled.size() / 2);
  EXPECT_LT(thinned.size(), 0.75 * static_cast<double>(boundary.size()));
  EXPECT_GT(thinned.size(), 8U);
  EXPECT_NEAR(extent_of(thinned).min_x, extent_of(filled).min_x, 1e-5)
      << "the nearest of each square stays";
}

TEST(Obstacles, reach_the_prisms_that_the_box_is_high_enough_for)
{
  const auto map = seen_room();
  CSimplePointsMap points;
  obstacles_3d(map.mapper(), CPose3D(0, -0.6, 5, 0, 0, 0), near_box(), {0.2, 0.2, 0.4}, points);
  EXPECT_GT(count_at(points, 0.1F), 5U);
  EXPECT_GT(count_at(points, 0.3F), 5U) << "0.45 m reaches into the second prism";
  EXPECT_GT(count_at(points, 0.6F), 5U) << "and above its top at 0.4 m";
  obstacles_3d(map.mapper(), kRight, near_box(), {0.25, 0.25, 0.3}, points);
  EXPECT_EQ(count_at(points, 0.65F), 0U) << "but not to 0.5 m";
  EXPECT_GT(count_at(points, 0.125F), 5U);
}

TEST(Obstacles, of_a_snapshot_are_those_of_the_map)
{
  CSimplePointsMap of_map, of_snapshot;
  obstacles_2d(seen_room().mapper(), kRight, near_box(), of_map);
  obstacles_2d(snapshot_of_room(), kRight, near_box(), of_snapshot);
  ASSERT_GT(of_map.size(), 8U);
  EXPECT_EQ(of_map.getPointsBufferRef_x(), of_snapshot.getPointsBufferRef_x());
  EXPECT_EQ(of_map.getPointsBufferRef_y(), of_snapshot.getPointsBufferRef_y());
}

TEST(Obstacles, are_what_is_not_known_near_the_robot_unless_it_is_free)
{
  const auto map = seen_room();
  const CPose3D beside(0.5, -2.6, 0, 0, 0, 0);  // the edge of what was seen
  ObstacleOptions o;
  o.range_m = 1.2;
  o.seen_within_m = 0.8;
  const auto nearest_and_farthest_m = [&]
  {
    CSimplePointsMap points;
    obstacles_2d(map.mapper(), beside, o, points);
    double nearest = 1e9, farthest = 0;
    for (std::size_t i = 0; i < points.size(); i++)
    {
      float x = 0, y = 0;
      points.getPoint(i, x, y);
      nearest = std::min<double>(nearest, std::hypot(x, y));
      farthest = std::max<double>(farthest, std::hypot(x, y));
    }
    return std::pair{nearest, farthest};
  };
  EXPECT_GT(nearest_and_farthest_m().second, 0.6);
  EXPECT_LE(nearest_and_farthest_m().second, 0.8) << "farther away it is left to the planner";
  EXPECT_GE(nearest_and_farthest_m().first, o.body_radius_m);
  o.unseen = Unseen::Free;
  EXPECT_EQ(nearest_and_farthest_m().second, 0) << "none";
}

TEST(Obstacles, are_all_cells_that_are_blocked_also_beside_the_robot)
{
  const auto map = seen_room();
  const CPose3D touching(0.7, 0, 0, 0, 0, 0);  // 0.32 m before the box
  ObstacleOptions o = only_known();
  o.range_m = 0.6;
  CSimplePointsMap points;
  obstacles_2d(map.mapper(), touching, o, points);
  EXPECT_NEAR(extent_of(points).min_x, 0.32, kFeature_m + kCell_m);
}

namespace
{
/** A room that is free but for one cell, which is blocked beside a fill: `cell`, at (-1, -1). */
struct RoomWithDoubt
{
  RoomWithDoubt()
  {
    std::fill(layer(Layer::Traversability).begin(), layer(Layer::Traversability).end(), 1.0F);
    fill_state(CellState::Measured);
    layer(Layer::Elevation)[cell] = layer(Layer::GroundElevation)[cell];
    layer(Layer::Traversability)[cell] = 0;
    layer(Layer::State)[cell + 1] = static_cast<float>(CellState::FilledOneSided);
  }
  std::vector<float>& layer(Layer l) { return map.layers[static_cast<std::size_t>(l)]; }
  /** A square of 0.25 m beside the cell that nobody saw. */
  void widen_guess()
  {
    const auto n = static_cast<std::size_t>(map.window.cells);
    for (std::size_t y = 0; y < 5; y++)
      for (std::size_t x = 1; x <= 5; x++)
        layer(Layer::State)[cell + x + n * y - 2 * n] =
            static_cast<float>(CellState::FilledOneSided);
  }
  void fill_state(CellState state)
  {
    std::fill(layer(Layer::State).begin(), layer(Layer::State).end(), static_cast<float>(state));
  }

  MapSnapshot map = snapshot_of_room();
  std::size_t cell = *map.window.index_at(-1.0, -1.0);
};
}  // namespace

TEST(Obstacles, are_blocked_cells_and_near_the_robot_those_in_doubt_or_unknown)
{
  RoomWithDoubt room;
  const auto passage_from = [&](double x_m)
  { return classify_cells(room.map, CPose3D(x_m, -1.0, 0, 0, 0, 0), {})[room.cell]; };
  EXPECT_EQ(passage_from(-0.2), Passage::Obstacle);
  EXPECT_EQ(passage_from(0.7), Passage::Unknown) << "from nearby it may look better";
  room.fill_state(CellState::Measured);
  EXPECT_EQ(passage_from(0.7), Passage::Obstacle);
  room.layer(Layer::Traversability)[room.cell] = NAN;
  EXPECT_EQ(passage_from(-0.2), Passage::Obstacle);
  EXPECT_EQ(passage_from(0.7), Passage::Unknown);
}

TEST(Obstacles, are_no_doubts_in_a_gap_of_one_cell_between_measured_ground)
{
  RoomWithDoubt room;
  const auto is_doubtful = [&](std::size_t cell) -> bool
  { return find_doubtful(room.map, {})[cell]; };
  const auto fill = [&](std::size_t cell)
  { room.layer(Layer::State)[cell] = static_cast<float>(CellState::FilledTwoSided); };
  const auto n = static_cast<std::size_t>(room.map.window.cells);
  fill(room.cell + 1);
  EXPECT_FALSE(is_doubtful(room.cell)) << "nothing can fall into it";
  fill(room.cell + 1 + n);
  EXPECT_FALSE(is_doubtful(room.cell)) << "a cell wide still";
  for (const std::size_t y : {std::size_t{0}, n, 2 * n}) fill(room.cell + 2 + y);
  EXPECT_TRUE(is_doubtful(room.cell)) << "two cells wide";
  room.fill_state(CellState::Measured);
  fill(room.cell + 1);
  room.layer(Layer::GroundElevation)[room.cell + 1] -= 0.1F;
  EXPECT_TRUE(is_doubtful(room.cell)) << "it falls";
}

TEST(Obstacles, are_no_guesses_in_a_narrow_gap_between_known_ground)
{
  RoomWithDoubt room;
  room.layer(Layer::Traversability)[room.cell] = 1;
  const auto n = static_cast<std::size_t>(room.map.window.cells);
  const std::size_t middle = room.cell + 4;
  const auto passage_in_square = [&](std::size_t reach)
  {
    for (std::size_t y = 0; y <= 2 * reach; y++)
      for (std::size_t x = 0; x <= 2 * reach; x++)
        room.layer(Layer::State)[middle + x - reach + n * y - n * reach] =
            static_cast<float>(CellState::FilledOneSided);
    return classify_cells(room.map, CPose3D(-0.4, -1.0, 0, 0, 0, 0), {})[middle];
  };
  EXPECT_EQ(passage_in_square(1), Passage::Free) << "0.15 m wide";
  EXPECT_EQ(passage_in_square(2), Passage::Obstacle) << "0.25 m wide";
}

TEST(Obstacles, are_guesses_from_one_side_near_the_robot_where_it_avoids_drops)
{
  RoomWithDoubt room;
  room.widen_guess();
  ObstacleOptions o;
  const auto passage_from = [&](double x_m)
  { return classify_cells(room.map, CPose3D(x_m, -1.0, 0, 0, 0, 0), o)[room.cell + 1]; };
  EXPECT_EQ(passage_from(-0.2), Passage::Obstacle) << "an edge may lie in it";
  EXPECT_EQ(passage_from(0.7), Passage::Free) << "from nearby it may be seen";
  o.drops = Drops::Slope;
  EXPECT_EQ(passage_from(-0.2), Passage::Obstacle) << "beside a drop that no slope explains";
  o.drops = Drops::Ignore;
  EXPECT_EQ(passage_from(-0.2), Passage::Free);
  o = only_known();
  EXPECT_EQ(passage_from(-0.2), Passage::Free);
}

TEST(Obstacles, are_no_guesses_beside_a_wall)
{
  RoomWithDoubt room;
  room.widen_guess();
  const std::size_t wall = room.cell + 4;
  const auto passage = [&]
  { return classify_cells(room.map, CPose3D(-0.2, -1.0, 0, 0, 0, 0), {})[room.cell + 1]; };
  EXPECT_EQ(passage(), Passage::Obstacle);
  room.layer(Layer::Elevation)[wall] = room.layer(Layer::GroundElevation)[wall] + 0.5F;
  EXPECT_EQ(passage(), Passage::Free) << "no robot fits between";
  room.layer(Layer::GroundElevation)[room.cell + 2] -= 0.5F;
  EXPECT_EQ(passage(), Passage::Obstacle) << "but the ground falls there";
}

TEST(Obstacles, do_not_reach_onto_the_ground_at_the_foot_of_what_rises)
{
  RoomWithDoubt room;
  room.fill_state(CellState::Measured);
  const auto passage = [&]
  { return classify_cells(room.map, CPose3D(0.7, -1.0, 0, 0, 0, 0), {})[room.cell]; };
  EXPECT_EQ(passage(), Passage::Obstacle);
  room.layer(Layer::GroundElevation)[room.cell + 2] += 0.5F;
  EXPECT_EQ(passage(), Passage::Free) << "the robot may stand there";
  room.layer(Layer::GroundElevation)[room.cell - 2] -= 0.5F;
  EXPECT_EQ(passage(), Passage::Obstacle) << "it falls on the other side";
}

TEST(Obstacles, are_edges_where_nothing_stands_or_the_ground_falls)
{
  RoomWithDoubt room;
  const CPose3D base(0.7, -1.0, 0, 0, 0, 0);
  const auto is_edge = [&]() -> bool
  { return find_edges(room.map, base, classify_cells(room.map, base, {}))[room.cell]; };
  EXPECT_TRUE(is_edge());
  room.layer(Layer::Elevation)[room.cell + 3] += 0.5F;
  EXPECT_FALSE(is_edge()) << "beside a wall";
  room.layer(Layer::GroundElevation)[room.cell - 3] -= 0.5F;
  EXPECT_TRUE(is_edge()) << "a wall beside an edge";
  room.layer(Layer::Traversability)[room.cell] = 1;
  EXPECT_FALSE(is_edge()) << "it is free";
}

TEST(Obstacles, are_in_doubt_where_only_a_comparison_with_fills_blocks)
{
  RoomWithDoubt room;
  std::vector<bool> only_that(room.layer(Layer::State).size());
  only_that[room.cell] = true;
  EXPECT_EQ(find_doubtful(room.map, {}), only_that);
  room.layer(Layer::Elevation)[room.cell] += 0.2F;
  EXPECT_FALSE(find_doubtful(room.map, {})[room.cell]) << "something stands there";
  room.layer(Layer::Elevation)[room.cell] -= 0.2F;
  room.fill_state(CellState::Measured);
  EXPECT_FALSE(find_doubtful(room.map, {})[room.cell]) << "that was seen";
}

namespace
{
/** A floor that ends at x = -0.6 m. Beyond it nothing was seen up to x = 0.6 m, where the ground
 * may go on lower; a wall on both sides. */
struct FloorWithEdge
{
  FloorWithEdge()
  {
    for (const Layer l : {Layer::Traversability, Layer::State, Layer::Elevation})
      std::fill(layer(l).begin(), layer(l).end(), l == Layer::Elevation ? NAN : 1.0F);
    std::fill(layer(Layer::GroundElevation).begin(), layer(Layer::GroundElevation).end(), 0.0F);
    for_cells(
        -0.6, 0.6,
        [this](std::size_t i)
        {
          layer(Layer::Traversability)[i] = 0;
          layer(Layer::State)[i] = static_cast<float>(CellState::FilledTwoSided);
        });
    for (std::size_t i = 0; i < layer(Layer::State).size(); i++)
      if (std::abs(y_of(i)) > 1) layer(Layer::Elevation)[i] = 1;
    for (std::size_t i = 0; i < layer(Layer::State).size(); i++)
      if (std::abs(y_of(i)) > 1) layer(Layer::State)[i] = static_cast<float>(CellState::Measured);
  }
  std::vector<float>& layer(Layer l) { return map.layers[static_cast<std::size_t>(l)]; }
  double x_of(std::size_t i) const
  {
    const auto n = static_cast<std::size_t>(map.window.cells);
    return map.window.min_x_m() + (static_cast<double>(i % n) + 0.5) * kCell_m;
  }
  double y_of(std::size_t i) const
  {
    const auto n = static_cast<std::size_t>(map.window.cells);
    return map.window.min_y_m() + (static_cast<double>(i / n) + 0.5) * kCell_m;
  }
  template <class F>
  void for_cells(double from_x_m, double to_x_m, F f)
  {
    for (std::size_t i = 0; i < layer(Layer::State).size(); i++)
      if (x_of(i) > from_x_m && x_of(i) < to_x_m) f(i);
  }
  void go_on_at(double z_m)
  {
    for_cells(
        0.6, 9, [&](std::size_t i) { layer(Layer::GroundElevation)[i] = static_cast<float>(z_m); });
  }
  Passage passage(Drops drops) const
  {
    ObstacleOptions o;
    o.drops = drops;
    return classify_cells(map, CPose3D(-0.7, 0, 0, 0, 0, 0), o)[*map.window.index_at(0.02, 0.02)];
  }

  MapSnapshot map = snapshot_of_room();
};
}  // namespace

TEST(Drops, are_dared_where_a_slope_explains_how_far_the_ground_falls)
{
  FloorWithEdge floor;
  floor.go_on_at(-0.3);
  EXPECT_EQ(floor.passage(Drops::Avoid), Passage::Obstacle);
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Free) << "14 degrees";
  floor.go_on_at(-0.55);
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Obstacle) << "25 degrees";
  EXPECT_EQ(floor.passage(Drops::Ignore), Passage::Free);
  floor.go_on_at(0);
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Obstacle) << "level, with a hole in it";
}

TEST(Drops, are_not_dared_before_a_wall_that_begins_lower_nor_where_nothing_was_seen_behind)
{
  FloorWithEdge floor;
  floor.go_on_at(-0.3);
  const float steep_from = 0.65F;
  floor.for_cells(
      steep_from, 9, [&](std::size_t i) { floor.layer(Layer::GroundElevation)[i] = 0; });
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Obstacle) << "the far wall of a ditch";
  floor.go_on_at(-0.3);
  ASSERT_EQ(floor.passage(Drops::Slope), Passage::Free);
  floor.for_cells(
      0.6, 9,
      [&](std::size_t i)
      { floor.layer(Layer::State)[i] = static_cast<float>(CellState::FilledOneSided); });
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Obstacle) << "nobody knows how deep";
}

TEST(Drops, are_not_dared_at_a_corner_where_one_line_alone_meets_lower_ground)
{
  FloorWithEdge floor;
  floor.go_on_at(-0.3);
  floor.for_cells(
      0.6, 9,
      [&](std::size_t i)
      {
        if (std::abs(floor.y_of(i)) > 0.2)
          floor.layer(Layer::State)[i] = static_cast<float>(CellState::FilledOneSided);
      });
  EXPECT_EQ(floor.passage(Drops::Slope), Passage::Obstacle) << "nobody knows how deep it is beside";
}

TEST(Drops, a_guess_beside_one_is_driven_on_only_where_a_slope_explains_the_drop)
{
  FloorWithEdge floor;
  const std::size_t before = *floor.map.window.index_at(-0.4, 0.02);
  floor.for_cells(-0.6, -0.35, [&](std::size_t i) { floor.layer(Layer::Traversability)[i] = 1; });
  const auto passage = [&](double goes_on_at_m, Drops drops)
  {
    floor.go_on_at(goes_on_at_m);
    ObstacleOptions o;
    o.drops = drops;
    return classify_cells(floor.map, CPose3D(-0.7, 0, 0, 0, 0, 0), o)[before];
  };
  EXPECT_EQ(passage(0, Drops::Avoid), Passage::Obstacle);
  EXPECT_EQ(passage(0, Drops::Slope), Passage::Obstacle);
  EXPECT_EQ(passage(-0.3, Drops::Slope), Passage::Free);
  EXPECT_EQ(passage(0, Drops::Ignore), Passage::Free);
}

TEST(KnownAhead, ends_with_what_was_seen_and_goes_on_over_what_is_dared)
{
  FloorWithEdge floor;
  floor.go_on_at(-0.3);
  const auto ahead_m = [&](Drops drops)
  {
    ObstacleOptions o;
    o.drops = drops;
    return known_ahead_m(floor.map, CPose3D(-1.5, 0, 0, 0, 0, 0), 1, 0, 0.5, o);
  };
  EXPECT_NEAR(ahead_m(Drops::Avoid), 0.9, kCell_m);
  EXPECT_GT(ahead_m(Drops::Slope), 1.3) << "to the border of the window";
}

TEST(Costmap, opens_what_is_in_doubt_until_it_stayed_so_from_nearby)
{
  RoomWithDoubt room;
  COccupancyGridMap2D grid;
  const int x = static_cast<int>(room.cell) % room.map.window.cells;
  const int y = static_cast<int>(room.cell) / room.map.window.cells;
  const auto seen_from = [&](double x_m)
  {
    update_costmap(room.map, CPose3D(x_m, -1.0, 0, 0, 0, 0), only_known(), grid);
    return grid.getCell(x, y);
  };
  const auto admitted = [&]
  {
    auto hoped = grid;
    admit_doubtful(hoped);
    return hoped.getCell(x, y);
  };
  costmap_from_map(room.map, CPose3D(0.7, -1.0, 0, 0, 0, 0), only_known(), grid);
  EXPECT_NEAR(grid.getCell(x, y), 0.2F, 0.01F) << "it may drop";
  EXPECT_NEAR(admitted(), 0.55F, 0.01F);
  room.layer(Layer::Traversability)[room.cell] = NAN;
  EXPECT_NEAR(seen_from(0.7), 0.2F, 0.01F) << "what is forgotten stays as it was";
  room.layer(Layer::Traversability)[room.cell] = 0;
  EXPECT_NEAR(seen_from(-0.2), 0.1F, 0.01F) << "nearer than it is to be seen";
  EXPECT_NEAR(seen_from(0.7), 0.1F, 0.01F) << "the robot does not come back for it";
  EXPECT_NEAR(admitted(), 0.1F, 0.01F);
  room.fill_state(CellState::Measured);
  EXPECT_NEAR(seen_from(0.7), 0.15F, 0.01F) << "that was seen, and nothing stands there";
  for (const std::size_t beside : {room.cell - 3, room.cell + 3})
    room.layer(Layer::Elevation)[beside] = room.layer(Layer::GroundElevation)[beside] + 0.5F;
  EXPECT_NEAR(seen_from(0.7), 0.05F, 0.01F) << "beside a wall";
}

TEST(Costmap, tells_what_may_drop_beside_a_wall_from_what_may_drop_elsewhere)
{
  RoomWithDoubt room;
  const std::size_t beside = room.cell + 3;
  room.layer(Layer::Elevation)[beside] = room.layer(Layer::GroundElevation)[beside] + 0.5F;
  COccupancyGridMap2D grid;
  costmap_from_map(room.map, CPose3D(0.7, -1.0, 0, 0, 0, 0), only_known(), grid);
  const int x = static_cast<int>(room.cell) % room.map.window.cells;
  const int y = static_cast<int>(room.cell) / room.map.window.cells;
  EXPECT_NEAR(grid.getCell(x, y), 0.25F, 0.01F);
  update_costmap(room.map, CPose3D(-0.2, -1.0, 0, 0, 0, 0), only_known(), grid);
  EXPECT_NEAR(grid.getCell(x, y), 0.3F, 0.01F) << "from nearby, too";
  admit_doubtful(grid);
  EXPECT_NEAR(grid.getCell(x, y), 0.3F, 0.01F);
}

TEST(KnownAhead, ends_at_the_first_cell_that_is_not_known_on_the_way)
{
  MapSnapshot map = snapshot_of_room();
  auto& traversability = map.layers[static_cast<std::size_t>(Layer::Traversability)];
  std::fill(traversability.begin(), traversability.end(), 1.0F);
  const auto forget = [&](double x_m, double y_m)
  { traversability[*map.window.index_at(x_m, y_m)] = NAN; };
  const CPose3D base(0.5, 0, 0, M_PI / 2, 0, 0);  // looks to +y
  const ObstacleOptions o = only_known();
  const auto known_m = [&](double v_mps, double w_radps)
  { return known_ahead_m(map, base, v_mps, w_radps, 0.6, o); };
  const double to_border_m = known_m(1, 0);
  EXPECT_GT(to_border_m, 1.5);
  forget(0.51, 1.01);
  EXPECT_NEAR(known_m(1, 0), 1.0, kCell_m);
  EXPECT_NEAR(known_m(-1, 0), to_border_m, 1e-9) << "it lies ahead";
  forget(0.51, -0.79);
  EXPECT_NEAR(known_m(-1, 0), 0.8, kCell_m);
  EXPECT_NEAR(known_m(1, 1), to_border_m, 1e-9) << "they lie in the middle of a circle, or beside";
  forget(-0.49, 1.01);
  EXPECT_NEAR(known_m(1, 1), M_PI / 2, kCell_m) << "a quarter of that circle";
  EXPECT_NEAR(known_m(1, -1), to_border_m, 1e-9) << "that to the right";
  EXPECT_EQ(known_m(0, 1), o.range_m);
  const ElevationMapper empty({}, Backend::Cpu);
  EXPECT_EQ(known_ahead_m(empty, base, 1, 0, 0.6, o), 0);
}

TEST(KnownAhead, is_enough_to_stop_from_the_speed_that_goes_with_it)
{
  for (const double distance_m : {0.05, 0.5, 3.0})
  {
    const double v = stopping_speed_mps(distance_m, 0.4, 1.5);
    EXPECT_NEAR(v * 0.4 + v * v / (2 * 1.5), distance_m, 1e-9);
  }
  EXPECT_EQ(stopping_speed_mps(-0.1, 0.4, 1.5), 0);
  EXPECT_EQ(stopping_speed_mps(NAN, 0.4, 1.5), 0);
}

TEST(Obstacles, of_an_empty_map_are_none)
{
  const ElevationMapper map({}, Backend::Cpu);
  CSimplePointsMap points;
  points.insertPoint(1, 2, 3);
  obstacles_2d(map, {}, {}, points);
  EXPECT_EQ(points.size(), 0U);
}

TEST(Costmap, tells_free_from_blocked_and_unknown)
{
  const auto map = seen_room();
  COccupancyGridMap2D grid;
  map.getAsOccupancyGrid(grid, only_known());
  EXPECT_LT(grid.getPos(1.3F, 0.5F), 0.1F) << "the box";
  EXPECT_GT(grid.getPos(0.5F, -1.5F), 0.9F) << "the floor";
  EXPECT_NEAR(grid.getPos(2.95F, 2.95F), 0.5F, 0.01F) << "the corner that was not seen";
  EXPECT_NEAR(grid.getXMin(), map.mapper().window().min_x_m(), 1e-5);
}

TEST(Costmap, leads_the_grid_planner_around_the_box)
{
  const auto map = seen_room();
  COccupancyGridMap2D grid;
  map.getAsOccupancyGrid(grid, only_known());
  mrpt::nav::PlannerSimple2D planner;
  planner.robotRadius = 0.2F;
  std::deque<mrpt::math::TPoint2D> path;
  bool not_found = true;
  planner.computePath(grid, {0, 0, 0}, {2.1, 0, 0}, path, not_found);
  ASSERT_FALSE(not_found);
  for (const auto& p : path)
    EXPECT_FALSE(p.x > 1.02 && p.x < 1.63 && std::abs(p.y) < 0.52) << p.x << " " << p.y;
}

TEST(Costmap, of_the_world_keeps_what_left_the_window)
{
  const auto map = seen_room();
  COccupancyGridMap2D world;
  world.setSize(-10, 10, -10, 10, 0.05F, 0.6F);
  world.setPos(8, 8, 0.05F);
  update_costmap(map.mapper(), {}, only_known(), world);
  EXPECT_LT(world.getPos(8, 8), 0.1F);
  EXPECT_LT(world.getPos(1.3F, 0.5F), 0.1F);
  EXPECT_NEAR(world.getPos(2.95F, 2.95F), 0.6F, 0.01F) << "unknown in the window stays too";
  COccupancyGridMap2D other;
  other.setSize(-10, 10, -10, 10, 0.1F);
  EXPECT_THROW(update_costmap(map.mapper(), {}, {}, other), std::invalid_argument);
}

TEST(Costmap, stays_as_it_is_where_the_window_lies_far_outside_of_it)
{
  MapSnapshot far_away = snapshot_of_room();
  far_away.window.min_cell_x -= std::int64_t{1} << 32;  // an int would wrap back into the costmap
  COccupancyGridMap2D world;
  world.setSize(-10, 10, -10, 10, 0.05F, 0.6F);
  update_costmap(far_away, {}, only_known(), world);
  EXPECT_NEAR(world.getPos(1.3F, 0.5F), 0.6F, 0.01F) << "the box";
  EXPECT_NEAR(world.getPos(0.5F, -1.5F), 0.6F, 0.01F) << "the floor";
}

TEST(Costmap, is_refused_where_its_borders_cannot_be_told_apart)
{
  CDualElevationMap map(talus_test::small_window(), Backend::Cpu);
  ASSERT_TRUE(
      map.insertObservation(talus_test::scan_of_room({}), CPose3D(300000.4, 0, 0, 0, 0, 0)));
  COccupancyGridMap2D grid;
  const std::string said = message_of([&] { map.getAsOccupancyGrid(grid, only_known()); });
  EXPECT_TRUE(has(said, "choose a map frame whose origin is near"));
}

TEST(Obstacles, are_not_made_of_numbers_that_are_none)
{
  const auto map = seen_room();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CSimplePointsMap points;
  COccupancyGridMap2D grid;
  for (const CPose3D& pose : {CPose3D(NAN, 0, 0, 0, 0, 0), CPose3D(0, 0, kInfinity, 0, 0, 0)})
  {
    EXPECT_THROW(obstacles_2d(map.mapper(), pose, {}, points), std::invalid_argument);
    EXPECT_THROW(obstacles_3d(map.mapper(), pose, {}, {0.5}, points), std::invalid_argument);
    EXPECT_THROW(costmap_from_map(map.mapper(), pose, {}, grid), std::invalid_argument);
  }
  ObstacleOptions o;
  o.blocked_at = NAN;
  EXPECT_THROW(obstacles_2d(map.mapper(), {}, o, points), std::invalid_argument);
}

TEST(Obstacles, are_cells_with_more_risk_than_asked_for)
{
  // A rough slope, nearly as steep as the robot climbs.
  std::vector<float> x, y, z;
  for (float u = 0.525F; u < 2.5F; u += 0.05F)
    for (float v = -0.975F; v < 1; v += 0.05F)
    {
      x.push_back(u), y.push_back(v);
      z.push_back(0.6F * u + 0.008F * std::sin(30 * u + 3 * v) * std::cos(50 * v) - 0.7F);
    }
  Frame frame;
  frame.T_map_sensor.m[11] = 0.7;
  frame.x_m = x.data(), frame.y_m = y.data(), frame.z_m = z.data(), frame.size = x.size();
  ElevationMapper map({}, Backend::Cpu, 1);
  map.update(frame);
  ObstacleOptions careful = only_known();
  careful.risk_at = 0.001;
  const auto before = classify_cells(map, {}, only_known()),
             after = classify_cells(map, {}, careful);
  const auto risks = risk(map);
  std::size_t more = 0;
  for (std::size_t i = 0; i < before.size(); i++)
    if (before[i] != after[i])
    {
      more++;
      EXPECT_EQ(before[i], Passage::Free);
      EXPECT_GT(risks[i], 0.001F);
    }
  EXPECT_GT(more, 10U);
  EXPECT_LT(more, 40U * 40U);
}

TEST(ObstacleOptions, refuse_what_makes_no_sense_and_say_what_is_allowed)
{
  const auto message = [](const std::string& line)
  {
    const mrpt::config::CConfigFileMemory ini("[obstacles]\n" + line + "\n");
    return message_of([&] { ObstacleOptions().loadFromConfigFile(ini, "obstacles"); });
  };
  EXPECT_EQ(
      message("unseen = maybe"),
      "unseen = 'maybe': must be obstacle or free (in section obstacles)");
  EXPECT_EQ(
      message("drops = jump"),
      "drops = 'jump': must be avoid, slope or ignore (in section obstacles)");
}

TEST(Obstacles, all_stay_however_small_the_squares_of_the_spacing_are)
{
  const auto map = seen_room();
  ObstacleOptions o = near_box();
  o.spacing_m = 0;
  CSimplePointsMap all, thinned;
  obstacles_2d(map.mapper(), kRight, o, all);
  for (const double spacing_m : {1e-9, 1e-12, 1e-20})
  {
    o.spacing_m = spacing_m;
    obstacles_2d(map.mapper(), kRight, o, thinned);
    EXPECT_EQ(thinned.size(), all.size()) << spacing_m;
  }
}
