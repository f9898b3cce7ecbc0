#include <gtest/gtest.h>
#include "scene.h"

using namespace talus;
using namespace talus::test;

TEST(Stage4Classify, AOneSidedGuessIsRefilledWhenTheOtherSideIsSeen)
{
  const auto slope = [](double x, double) { return 0.1 * (x - 1); };
  TestMap m(Scan().add_surface(1.0, -0.5, 1.5, 0.5, slope));
  EXPECT_EQ(m.state(1.775, 0.025), CellState::FilledOneSided);
  EXPECT_LE(m.ground(1.775, 0.025), 0.05);
  m.update(Scan().add_surface(2.0, -0.5, 2.5, 0.5, slope));
  EXPECT_EQ(m.state(1.775, 0.025), CellState::FilledTwoSided);
  EXPECT_GT(m.ground(1.775, 0.025), 0.05);
}

TEST(Stage4Classify, AFillFollowsNearerDataUpToAMeasurementAndKeepsItsStateWithoutAny)
{
  TestMap m(Scan().add_surface(1.0, -0.5, 1.5, 0.5, flat).add_surface(2.0, -0.5, 2.5, 0.5, flat));
  ASSERT_EQ(m.state(1.775, 0.025), CellState::FilledTwoSided);
  const float before = m.ground(1.775, 0.025);
  m.update(Scan());
  EXPECT_EQ(m.ground(1.775, 0.025), before);
  m.update(Scan().add_surface(1.55, -0.5, 1.75, 0.5, level(0.05)));
  EXPECT_GT(m.ground(1.775, 0.025), before + 0.02);
  EXPECT_EQ(m.state(1.775, 0.025), CellState::FilledTwoSided);
  m.update(Scan().add(1.775, 0.025, 0.04));
  EXPECT_EQ(m.state(1.775, 0.025), CellState::Measured);
  EXPECT_NEAR(m.ground(1.775, 0.025), 0.04, 1e-6);
}

TEST(Stage4Classify, AWallWhoseFootWasNeverSeenGetsTheGroundBesideIt)
{
  TestMap m(Scan()
                .add_surface(1.0, -1, 2.0, 1, flat)
                .add_surface(2.1, -1, 3.0, 1, flat)
                .add_surface(2.0, -1, 2.1, 1, level(0.4))
                .add_surface(2.0, -1, 2.1, 1, level(0.9)));
  EXPECT_NEAR(m.ground(2.025, 0.025), 0.0, 1e-5);
  EXPECT_NEAR(m.elevation(2.025, 0.025), 0.9, 1e-5);
  EXPECT_NE(m.state(2.025, 0.025), CellState::Measured);
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  EXPECT_GT(m.traversability(1.975, 0.025), 0.99f);  // the floor beside it stays free
}

TEST(Stage4Classify, TheLowestHitOnAFaceIsNoGroundWhereBareFloorIsInReach)
{
  // A slope of 45 degrees would lead up to it.
  for (const double floor_ends_m : {1.6, 1.8})
  {
    Scan s = Scan().add_surface(0.5, -1, floor_ends_m, 1, flat);
    for (const double hit_m : {0.25, 0.5, 0.8}) s.add_surface(2.0, -1, 2.1, 1, level(hit_m));
    TestMap m(s);
    EXPECT_EQ(m.state(2.025, 0.025), CellState::FilledOneSided) << floor_ends_m;
    EXPECT_NEAR(m.ground(2.025, 0.025), 0.0, 1e-3) << floor_ends_m;
    EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f) << floor_ends_m;
  }
}

TEST(Stage4Classify, WhatStandsOnTheEdgeOfAPlatformStandsOnThePlatform)
{
  TestMap m(Scan()
                .add_surface(0.5, -1, 2.0, 1, flat)
                .add_surface(2.0, -1, 3.5, 1, level(0.4))
                .add_surface(2.0, -1, 2.1, 1, level(0.8))
                .add_surface(2.0, -1, 2.1, 1, level(1.2)));
  EXPECT_EQ(m.state(2.025, 0.025), CellState::Measured);
  EXPECT_NEAR(m.ground(2.025, 0.025), 0.4, 1e-5);
  EXPECT_NEAR(m.elevation(2.025, 0.025), 1.2, 1e-5);
}

TEST(Stage4Classify, UnknownGroundBehindAWallDoesNotMakeItWide)
{
  // Of a wall all around the foot is hidden, and all that is behind it.
  Scan s = Scan().add_surface(-1.5, -1.5, 1.5, 1.5, flat);
  for (double y = -2; y < 2; y += 0.02)
    for (double z = 0.5; z < 1.2; z += 0.1) s.add(1.775, y, z);
  TestMap m(s);
  EXPECT_NEAR(m.ground(1.775, 0.025), 0.0, 0.02);
  EXPECT_NEAR(m.ground(2.225, 0.025), 0.0, 0.02) << "what a fill behind it builds on";
  EXPECT_EQ(m.traversability(1.775, 0.025), 0.0f);
}

TEST(Stage4Classify, ABranchSeenBeforeTheGroundAroundItEndsPassable)
{
  const auto branch = level(0.9);
  TestMap m(Scan().add_surface(2.0, -0.05, 2.1, 0.05, branch));
  EXPECT_NEAR(m.ground(2.025, 0.025), 0.9, 1e-5);
  m.update(Scan().add_surface(1.0, -1, 2.0, 1, flat).add_surface(2.1, -1, 3.0, 1, flat));
  EXPECT_NEAR(m.ground(2.025, 0.025), 0.0, 1e-5);
  // It is seen again, from below, over ground that rays passed low.
  m.update(Scan().add_surface(2.0, -0.05, 2.1, 0.05, branch));
  EXPECT_GT(m.traversability(2.025, 0.025), 0.99f);
}

TEST(Stage4Classify, ASignIsNotJoinedToItself)
{
  // It is met before the floor below it; the robot fits below. The same on short legs stands.
  const auto meet = [](TestMap& m, double underside_m)
  {
    const Box sign{{1.5, -0.3, underside_m}, {1.55, 0.3, underside_m + 0.35}};
    for (int i = 0; i < 3; i++) m.update(Scan().cast({sign}, 720, -0.38, 0.35));
  };
  TestMap high, low;
  meet(high, 0.85);
  meet(low, 0.1);
  for (const double y : {-0.125, 0.025, 0.175})
  {
    EXPECT_NEAR(high.ground(1.525, y), 0, 0.03) << y;
    EXPECT_FALSE(high.elevation(1.525, y) > 0.1f) << y;
    EXPECT_GT(low.elevation(1.525, y), 0.4f) << y;
  }
}

/** Adds what is met of something over a strip of floor, every 0.1 m up to below a height. */
void add_face(Scan& s, double x0, double x1, double y0, double y1, double low_m, double high_m)
{
  for (double z = low_m; z < high_m; z += 0.1) s.add_surface(x0, y0, x1, y1, level(z));
}

TEST(Stage4Classify, ASignHangsBesideItsPost)
{
  Scan floor = Scan().add_surface(1.0, -1, 2.0, 1, flat).add_surface(2.3, -1, 3.0, 1, flat);
  TestMap sign;
  Scan with_sign = floor;
  add_face(with_sign, 2.0, 2.1, 0, 0.1, 0.0, 2.05);
  add_face(with_sign, 2.0, 2.1, 0.1, 0.4, 1.4, 1.85);
  for (int i = 0; i < 2; i++) sign.update(with_sign);
  EXPECT_NEAR(sign.elevation(2.025, 0.025), 2.0, 0.01);
  EXPECT_FALSE(sign.elevation(2.025, 0.175) > 0.1f);
}

TEST(Stage4Classify, ABankSteeperThanTheRobotClimbsIsGroundToo)
{
  const double tangent = std::tan(42 * M_PI / 180);
  TestMap m(Scan()
                .add_surface(0, -1, 2, 1, flat)
                .add_surface(2, -1, 3, 1, [&](double x, double) { return tangent * (x - 2); }));
  for (double x = 2.025; x < 3; x += 0.05) EXPECT_EQ(m.state(x, 0.525), CellState::Measured) << x;
  for (double x = 2.075; x < 2.9; x += 0.05) EXPECT_EQ(m.traversability(x, 0.525), 0.0f) << x;
}

TEST(Stage4Classify, TheEdgeOfAPlatformOnWhichTheRobotStandsIsGround)
{
  // In pairs of cells the edge may share one with the floor, or not.
  for (const double edge_m : {2.0, 2.05})
  {
    TestMap m(Scan(3, 0, 1.0)
                  .add_surface(0, -1, edge_m, 1, flat)
                  .add_surface(edge_m, -1, 4, 1, level(0.3)));
    for (double x = edge_m + 0.025; x < 3; x += 0.05)
    {
      EXPECT_EQ(m.state(x, 0.525), CellState::Measured) << edge_m << " at " << x;
      EXPECT_NEAR(m.ground(x, 0.525), 0.3, 1e-5) << edge_m << " at " << x;
    }
  }
}

TEST(Stage4Classify, ABridgeAndAJettyAreGroundToTheirEnds)
{
  const auto low = level(-0.6);
  TestMap m(Scan()
                .add_surface(-2, -2.5, 1, 2.5, flat)
                .add_surface(2.2, -2.5, 4, 2.5, flat)
                .add_surface(1, -2.5, 2.2, -0.5, low)
                .add_surface(1, 0.5, 2.2, 2.5, low)
                .add_surface(1, -0.5, 2.2, 0.5, flat));
  for (double y = -0.375; y < 0.4; y += 0.05)
  {
    EXPECT_EQ(m.state(1.625, y), CellState::Measured) << y;
    EXPECT_NEAR(m.ground(1.625, y), 0.0, 1e-5) << y;
  }
  TestMap jetty(Scan()
                    .add_surface(-2, -3, 0.5, 3, flat)
                    .add_surface(0.5, -0.3, 3.5, 0.3, flat)
                    .add_surface(0.5, -3, 3.5, -0.3, low)
                    .add_surface(0.5, 0.3, 3.5, 3, low));
  for (double x = 0.525; x < 3.2; x += 0.05)
  {
    EXPECT_EQ(jetty.state(x, 0.025), CellState::Measured) << x;
    EXPECT_NEAR(jetty.ground(x, 0.025), 0.0, 1e-5) << x;
  }
}

/** A map after a drive past some things. */
void drive_past(TestMap& m, const std::vector<Box>& boxes)
{
  for (double x = -0.5; x < 2.5; x += 0.1)
    m.update(Scan(x, 0, 1.0).cast(boxes, 720, -0.6, 0.1, 96));
}

/** Share of the cells inside a thing, half a metre from its sides, of which `is` holds. */
template <class Predicate>
double share_inside(const TestMap& m, const Box& thing, Predicate is)
{
  int cells = 0, those = 0;
  for (double x = thing.min[0] + 0.525; x < thing.max[0] - 0.5; x += 0.05)
    for (double y = thing.min[1] + 0.525; y < thing.max[1] - 0.5; y += 0.05)
      cells++, those += is(m.traversability(x, y));
  return static_cast<double>(those) / cells;
}
bool blocked(float traversability) { return traversability == 0.0f; }
bool passable(float traversability) { return traversability > 0.0f; }

/** A trailer 0.4 m above the ground: rays reach the ground below it, its top is seen from above. */
const Box kTrailer{{1.0, 1.0, 0.4}, {2.6, 2.4, 0.8}};

TEST(Stage4Classify, WhatHasAirBelowItIsBlockedInItsMiddleTooAndBelowATableTheRobotFits)
{
  TestMap trailer, table;
  drive_past(trailer, {kTrailer});
  EXPECT_GT(share_inside(trailer, kTrailer, blocked), 0.9);
  for (int i = 0; i < 3; i++) trailer.update(Scan(2.5, 0, 1.0).cast({}, 720, -0.6, 0.1, 96));
  EXPECT_EQ(share_inside(trailer, kTrailer, passable), 1.0) << "it has gone";

  const Box plate{{1.0, 1.0, 0.75}, {2.6, 2.4, 0.8}};
  std::vector<Box> boxes{plate};
  for (const double x : {1.0, 2.52})
    for (const double y : {1.2, 2.32}) boxes.push_back({{x, y, 0}, {x + 0.08, y + 0.08, 0.75}});
  drive_past(table, boxes);
  // Below its far side no ray passed as high as the robot, since the sensor passed too near.
  EXPECT_GT(share_inside(table, plate, passable), 0.75);
}

TEST(Stage4Classify, AWallAtTheWindowsBorderIsNoGround)
{
  // What is seen of it stands upright, or is higher than the sensor.
  const double seen_m[2][2] = {{0.4, 0.9}, {0.8, 1.0}};
  for (const auto& [lowest_m, highest_m] : seen_m)
  {
    Scan s = Scan().add_surface(-1, 0, 1, 3.8, flat);
    add_face(s, -1, 1, 3.85, 3.95, lowest_m, highest_m);
    TestMap m(s);
    EXPECT_NE(m.state(0.525, 3.925), CellState::Measured) << lowest_m;
    EXPECT_NEAR(m.ground(0.525, 3.925), 0.0, 1e-5) << lowest_m;
  }
}

namespace
{
/** The floor around the robot, and a platform of 0.3 m that begins at x = 1; behind y = -0.5 a ramp
 * leads up to it, or nothing. */
Scan platform(bool ramp)
{
  const auto height = [](double x, double y) {
    return y < -0.5 ? std::clamp(0.2 * (x - 0.2), 0.0, 0.3) : x < 1 ? 0.0 : 0.3;
  };
  return Scan().add_surface(-1, ramp ? -2.5 : -0.5, 3.9, 2.5, height);
}
}  // namespace

TEST(Stage4Reach, TheTopOfABoxIsNoGroundThoughNothingBesideOrBehindItWasSeen)
{
  TestMap m(Scan().add_surface(-1, -2, 2, 2, flat).add_surface(2, -0.8, 2.5, 0.8, level(0.8)));
  for (double x = 2.025; x < 2.5; x += 0.05)
  {
    EXPECT_EQ(m.traversability(x, 0.025), 0.0f) << x;
    EXPECT_NEAR(m.elevation(x, 0.025), 0.8, 1e-5) << x;
    EXPECT_LT(m.ground(x, 0.025), 0.1) << x;
  }
  EXPECT_GT(m.traversability(1.525, 0.025), 0.99f) << "the floor before it";
}

TEST(Stage4Reach, TheFloorBehindAWallIsGroundThoughNoWayLeadsThere)
{
  Scan s = Scan().add_surface(-1, -4, 2, 4, flat).add_surface(2.1, -4, 3.5, 4, flat);
  for (const double z : {0.5, 1.0}) s.add_surface(2, -4, 2.1, 4, level(z));
  TestMap m(s);
  EXPECT_EQ(m.state(3.025, 0.025), CellState::Measured);
  EXPECT_GT(m.traversability(3.025, 0.025), 0.99f);
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  EXPECT_EQ(m.at(Layer::Reached, 1.025, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Reached, 3.025, 0.025), 0.0f) << "free, and shown as not reached";
  EXPECT_TRUE(std::isnan(m.at(Layer::Reached, -3.5, 0.025))) << "not known";
}

TEST(Stage4Reach, ATerraceIsGroundAndSoIsAPlatformUpToItsEdgeAsSoonAsAWayIsSeenThatLeadsThere)
{
  TestMap terrace(platform(false)), ramp(platform(true));
  for (const double x : {1.525, 3.025}) EXPECT_NEAR(terrace.ground(x, 1.525), 0.3, 1e-5) << x;
  for (const double x : {1.525, 3.025})
    EXPECT_EQ(terrace.state(x, 1.525), CellState::Measured) << x;
  // The first frame shows what is passable, and the next one where that leads to.
  for (int i = 0; i < 3; i++) terrace.update(platform(true));
  for (double x = 1.025; x < 3; x += 0.05)
  {
    if (x > 1.3) EXPECT_EQ(terrace.state(x, 1.525), CellState::Measured) << x;
    EXPECT_EQ(ramp.state(x, 1.525), CellState::Measured) << x;
    EXPECT_NEAR(ramp.ground(x, 1.525), 0.3, 1e-5) << x;
  }
  EXPECT_GT(terrace.traversability(1.525, 1.525), 0.99f);
  EXPECT_GT(ramp.traversability(2.025, 1.525), 0.99f);
}

TEST(Stage4Reach, AGuessBetweenTheFloorAndTheTopOfABoxLeadsNowhere)
{
  // A high scanner of 16 beams sees the top first, and the floor around it from farther on.
  TestMap m(with({{"window_m", 16}}));
  const std::vector<Box> box{{{3.5, 1.1, 0}, {4.5, 2.1, 0.6}}};
  for (int i = 0; i < 110; i++)
  {
    const Scan s = Scan(0.1 * i, 0, 1.5).cast(box, 900, -0.2618, 0.2618, 16);
    m.update(s, translation(0, 0, 1.5), 0.1 * i);
  }
  int free = 0;
  for (double x = 3.525; x < 4.5; x += 0.05)
    for (double y = 1.125; y < 2.1; y += 0.05) free += m.traversability(x, y) > 0;
  EXPECT_LE(free, 20) << "of 400";
}
