#include <gtest/gtest.h>
#include "scene.h"

using namespace talus;
using namespace talus::test;

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
  TestMap m;
  m.update(Scan().add_surface(-1, -2, 2, 2, flat).add_surface(2, -0.8, 2.5, 0.8, level(0.8)));
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
  TestMap m;
  Scan s;
  s.add_surface(-1, -4, 2, 4, flat).add_surface(2.1, -4, 3.5, 4, flat);
  for (const double z : {0.5, 1.0}) s.add_surface(2, -4, 2.1, 4, level(z));
  m.update(s);
  EXPECT_EQ(m.state(3.025, 0.025), CellState::Measured);
  EXPECT_GT(m.traversability(3.025, 0.025), 0.99f);
  EXPECT_EQ(m.traversability(2.025, 0.025), 0.0f);
  EXPECT_EQ(m.at(Layer::Reached, 1.025, 0.025), 1.0f);
  EXPECT_EQ(m.at(Layer::Reached, 3.025, 0.025), 0.0f) << "free, and shown as not reached";
  EXPECT_TRUE(std::isnan(m.at(Layer::Reached, -3.5, 0.025))) << "not known";
}

TEST(Stage4Reach, APlatformWithARampIsGroundUpToItsEdge)
{
  TestMap m;
  m.update(platform(true));
  for (double x = 1.025; x < 3; x += 0.05)
  {
    EXPECT_EQ(m.state(x, 1.525), CellState::Measured) << x;
    EXPECT_NEAR(m.ground(x, 1.525), 0.3, 1e-5) << x;
  }
  EXPECT_GT(m.traversability(2.025, 1.525), 0.99f);
}

TEST(Stage4Reach, ATerraceThatNoWayLeadsToIsGround)
{
  TestMap m;
  m.update(platform(false));
  for (const double x : {1.525, 3.025})
  {
    EXPECT_EQ(m.state(x, 1.525), CellState::Measured) << x;
    EXPECT_NEAR(m.ground(x, 1.525), 0.3, 1e-5) << x;
  }
}

TEST(Stage4Reach, AWayThatIsSeenLaterLeadsToThePlatform)
{
  TestMap m;
  m.update(platform(false));
  // The first frame shows what is passable, and the next one where that leads to.
  for (int i = 0; i < 3; i++) m.update(platform(true));
  EXPECT_EQ(m.state(1.325, 1.525), CellState::Measured);
  EXPECT_GT(m.traversability(1.525, 1.525), 0.99f);
}

TEST(Stage4Reach, AGuessBetweenTheFloorAndTheTopOfABoxLeadsNowhere)
{
  // A high scanner of 16 beams sees the top first, and the floor around it from farther on.
  Parameters p;
  p.window_m = 16;
  TestMap m(p);
  const std::vector<Box> box{{{3.5, 1.1, 0}, {4.5, 2.1, 0.6}}};
  for (int i = 0; i < 110; i++)
  {
    Scan s(0.1 * i, 0, 1.5);
    Frame f = s.cast(box, 900, -0.2618, 0.2618, 16).frame(0.1 * i);
    f.T_base_sensor = translation(0, 0, 1.5);
    m.map.update(f);
  }
  int free = 0;
  for (double x = 3.525; x < 4.5; x += 0.05)
    for (double y = 1.125; y < 2.1; y += 0.05) free += m.traversability(x, y) > 0;
  EXPECT_LE(free, 20) << "of 400";
}
