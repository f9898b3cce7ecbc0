#include <gtest/gtest.h>

#include <algorithm>
#include "scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
const Parameters kNearWindow = with({{"window_m", 5}});  //!< for many frames of what stands near

/** A box of 0.3 m that stands at a distance in a direction given in degrees. */
Box box_at(double distance_m, double direction_deg, double height_m = 0.6, double half_m = 0.15)
{
  const double x = distance_m * std::cos(direction_deg * M_PI / 180);
  const double y = distance_m * std::sin(direction_deg * M_PI / 180);
  return {{x - half_m, y - half_m, 0}, {x + half_m, y + half_m, height_m}};
}

int cells_above(const TestMap& m, double height_m)
{
  int count = 0;
  for (float e : m.map.layer(Layer::Elevation)) count += e > height_m;
  return count;
}
}  // namespace

TEST(Stage5Cleanup, ABoxThatMovesAwayInAnyDirectionIsGoneWithinTwoFramesAndLeavesGround)
{
  const Scan without = Scan().cast({});
  for (const double direction_deg : {0, 45, 90, 135, 180, 225, 270, 315, 20, 70, 110, 200, 340})
  {
    const Box box = box_at(2.2, direction_deg);
    TestMap m(Scan().cast({box}), {}, 3);
    ASSERT_GE(cells_above(m, 0.1), 6);
    for (int i = 0; i < 2; i++) m.update(without);
    EXPECT_EQ(cells_above(m, 0.05), 0);
    for (double x = box.min[0] + 0.025; x < box.max[0]; x += 0.05)
      for (double y = box.min[1] + 0.025; y < box.max[1]; y += 0.05)
      {
        // The lowest hit on the box stays as ground where it lies within the margin of the rays.
        EXPECT_NEAR(m.ground(x, y), 0.0, Parameters().cleanup_margin_m) << x << "," << y;
        EXPECT_GT(m.traversability(x, y), 0.8f) << x << "," << y;
      }
  }
}

TEST(Stage5Cleanup, APostThatStaysIsNotEatenInTwoHundredFrames)
{
  TestMap m(kNearWindow);
  const Box post{{2.03, 0.41, 0}, {2.07, 0.44, 0.6}};
  for (int i = 0; i < 200; i++)
  {
    Scan s(0.0007 * i, 0, 0.7);  // a slow drive, so that rays sample the post anew in each frame
    m.update(s.cast({post}));
    const float top = std::max(m.elevation(2.045, 0.425), m.elevation(2.055, 0.425));
    ASSERT_GT(top, 0.4f) << "frame " << i;
  }
}

TEST(Stage5Cleanup, AWallSeenAtAGrazingAngleStays)
{
  TestMap m;
  const Box wall{{0.5, 0.80, 0}, {3.5, 0.85, 0.9}};
  for (int i = 0; i < 50; i++) m.update(Scan(0.01 * i, 0, 0.7).cast({wall}));
  int standing = 0, all = 0;
  for (double x = 0.625; x < 3.4; x += 0.05, all++) standing += m.elevation(x, 0.825) > 0.5f;
  EXPECT_EQ(standing, all);
}

TEST(Stage5Cleanup, ACellThatNoRayPassedKeepsItsObstacle)
{
  TestMap m;
  const Box near_box = box_at(1.5, 10), far_box = box_at(2.6, 10);
  const Scan hidden = Scan().cast({near_box, far_box});
  for (int i = 0; i < 3; i++) m.update(Scan().cast({far_box}));
  const float before = m.elevation(2.44, 0.451);
  ASSERT_GT(before, 0.3f);
  for (int i = 0; i < 5; i++) m.update(hidden);
  EXPECT_GE(m.elevation(2.44, 0.451), before - 0.05f);
}

TEST(Stage5Cleanup, TheNumberOfFramesThatMustSeeThroughIsAParameter)
{
  for (const int frames : {1, 2, 4})
  {
    TestMap m(Scan().cast({box_at(2.2, 30)}), with({{"cleanup_frames", frames}}));
    int needed = 0;
    while (cells_above(m, 0.05) > 0 && needed < 20)
    {
      m.update(Scan().cast({}));
      needed++;
    }
    EXPECT_EQ(needed, frames);
  }
}

TEST(Stage5Cleanup, ARailingThatIsHitAndSeenThroughIsNotEaten)
{
  // Three bars of 4 cm with air between; the drive makes the beams meet them now and then.
  std::vector<Box> bars;
  for (const double z : {0.25, 0.5, 0.75}) bars.push_back({{1.0, 1.02, z}, {3.0, 1.04, z + 0.04}});
  TestMap m;
  for (int i = 0; i < 60; i++) m.update(Scan(0.005 * i, 0, 0.7).cast(bars, 720, -0.6, 0.1, 16));
  int standing = 0, all = 0;
  for (double x = 1.125; x < 2.9; x += 0.05, all++) standing += m.elevation(x, 1.025) > 0.2f;
  EXPECT_GE(standing, all * 3 / 4) << "of " << all;
}

TEST(Stage5Cleanup, ABenchIsNotClearedByTheRaysThatPassBelowIt)
{
  const Box bench{{1.5, -0.4, 0.36}, {1.9, 0.4, 0.41}};
  TestMap m(kNearWindow);
  for (int i = 0; i < 3; i++) m.update(Scan(0, 0, 0.4).cast({bench}));
  ASSERT_GT(m.elevation(1.525, 0.025), 0.3f);
  // From now on the beams miss it, above and below.
  const Scan missing = Scan(0, 0, 0.4).cast({bench}, 720, -0.6, -0.05, 48);
  for (int i = 0; i < 100; i++) m.update(missing);
  EXPECT_GT(m.elevation(1.525, 0.025), 0.3f);
  EXPECT_EQ(m.traversability(1.525, 0.025), 0.0f);
}

TEST(Stage5Cleanup, WhatHasAirBelowItIsGoneWhenRaysGoOnAboveItsUnderside)
{
  const Box trailer{{1.8, -0.4, 0.2}, {2.4, 0.4, 0.55}};
  TestMap m(Scan().cast({trailer}), {}, 5);
  ASSERT_GT(m.elevation(1.825, 0.025), 0.4f);
  ASSERT_EQ(m.traversability(1.825, 0.025), 0.0f);
  for (int i = 0; i < 2; i++) m.update(Scan().cast({}));
  for (double y = -0.375; y < 0.4; y += 0.05) EXPECT_LT(m.elevation(1.825, y), 0.05f) << y;
}

TEST(Stage5Cleanup, HitsBeforeAndBehindACellTellHowFarWhatOverhangsThereReaches)
{
  // A face that leans back: a cell is hit by one beam at most, and in other frames by none.
  std::vector<Box> face;
  for (int i = 0; i < 6; i++)
    face.push_back({{1.8 + 0.05 * i, -0.4, 0.2 + 0.06 * i}, {2.4, 0.4, 0.26 + 0.06 * i}});
  TestMap m;
  for (int i = 0; i < 8; i++) m.update(Scan(0.01 * i, 0, 0.7).cast(face, 720, -0.6, 0.1, 48));
  for (double x = 1.825; x < 2.1; x += 0.05) ASSERT_GT(m.elevation(x, 0.025), 0.2f) << x;
  for (int i = 8; i < 12; i++) m.update(Scan(0.01 * i, 0, 0.7).cast({}, 720, -0.6, 0.1, 48));
  // Of the first and the last only one side is known to have been hit.
  for (double x = 1.875; x < 2.05; x += 0.05) EXPECT_LT(m.elevation(x, 0.025), 0.05f) << x;
}

TEST(Stage5Cleanup, WhatHasLeftTakesAlongItsPartsOfWhichRaysTellNothing)
{
  // A piece without a foot, alone or between two with one. Later no beam aims above its underside.
  const Box piece{{1.8, -0.05, 0.3}, {2.4, 0.05, 0.6}};
  const Box left{{1.8, 0.05, 0}, {2.4, 0.4, 0.6}}, right{{1.8, -0.4, 0}, {2.4, -0.05, 0.6}};
  for (const bool alone : {true, false})
  {
    TestMap m;
    const auto whole = alone ? std::vector<Box>{piece} : std::vector<Box>{piece, left, right};
    for (int i = 0; i < 5; i++) m.update(Scan().cast(whole));
    ASSERT_GT(m.elevation(1.825, 0.025), 0.4f);
    for (int i = 0; i < 6; i++) m.update(Scan().cast({}, 720, -0.6, -0.24));
    for (const double y : {-0.025, 0.025}) EXPECT_EQ(m.elevation(1.825, y) > 0.4f, alone) << y;
  }
}

TEST(Stage5Cleanup, WhatStandsWhereTheRobotDroveLeavesInItsOwnShadowAndAWallBesideItsWayStays)
{
  const Box follower{{-0.2, -0.15, 0}, {0.19, 0.15, 0.6}}, wall{{-0.2, 0.6, 0}, {0.19, 0.7, 0.6}};
  const Box nearer{{0.6, -0.6, 0}, {0.7, 1.4, 0.6}};  // hides both
  TestMap m;
  const auto drive = [&m](double x_m, const std::vector<Box>& boxes)
  { m.update(Scan(x_m, 0, 0.7).cast(boxes), translation(0, 0, 0.7)); };
  drive(0, {wall});
  for (int i = 0; i < 5; i++) drive(1.5, {wall, follower});
  ASSERT_GT(m.elevation(0.175, 0.025), 0.3f);
  ASSERT_GT(m.elevation(0.175, 0.625), 0.3f);
  for (int i = 0; i < 4; i++) drive(1.5, {nearer});
  EXPECT_GT(m.elevation(0.175, 0.025), 0.3f);
  for (int i = 0; i < 2; i++) drive(1.5, {nearer});
  EXPECT_LT(m.elevation(0.175, 0.025), 0.05f);
  EXPECT_GT(m.elevation(0.175, 0.625), 0.3f);
}

TEST(Stage5Cleanup, TheRimOfWhatIsStillHitStaysUntilThatLeavesOrItsOwnFloorIsHit)
{
  // Three beams pass the outer part of a post and meet no floor in its cells. 48 beams do.
  const Box whole{{1.5, -0.1, 0}, {1.6, 0.1, 0.6}}, core{{1.5, -0.1, 0}, {1.6, 0.05, 0.6}};
  for (const int beams : {3, 48})
  {
    TestMap m(kNearWindow);
    for (int i = 0; i < 3; i++) m.update(Scan(0, 0, 0.7).cast({whole}, 720, -0.6, -0.2, beams));
    ASSERT_GT(m.elevation(1.525, 0.075), 0.3f);
    for (int i = 0; i < 20; i++) m.update(Scan(0, 0, 0.7).cast({core}, 720, -0.6, -0.2, beams));
    EXPECT_EQ(m.elevation(1.525, 0.075) > 0.3f, beams == 3) << beams;
    for (int i = 0; i < 2; i++) m.update(Scan(0, 0, 0.7).cast({}, 720, -0.6, -0.2, beams));
    // The lowest hit on the post, of a beam 0.1 m high, may stay as ground.
    EXPECT_EQ(cells_above(m, 0.15), 0) << beams;
  }
}

TEST(Stage5Cleanup, WhatWasHitForASecondIsFreeHalfASecondAfterItMovedOn)
{
  for (const int beams : {16, 48})
  {
    TestMap m(kNearWindow);
    const auto at = [](double y) { return Box{{1.5, y, 0}, {1.8, y + 0.3, 0.6}}; };
    for (int i = 0; i < 10; i++) m.update(Scan(0, 0, 0.7).cast({at(-0.8)}, 720, -0.6, 0.1, beams));
    ASSERT_GT(cells_above(m, 0.3), 5);
    double y = -0.8;
    for (int i = 0; i < 12; i++)
      m.update(Scan(0, 0, 0.7).cast({at(y += 0.1)}, 720, -0.6, 0.1, beams));
    // In five frames it goes half a metre. Few beams leave the lowest hit on it as ground.
    for (double left = -0.775; left < y - 0.5; left += 0.05)
      for (double x = 1.525; x < 1.8; x += 0.05)
        EXPECT_FALSE(m.elevation(x, left) > 0.15f) << beams << " beams, " << x << "," << left;
  }
}

TEST(Stage5Cleanup, WhatRaysCombAndDoNotHitHasLeftWhereFewBeamsTellNothing)
{
  // A handlebar: so thin that few rays tell that they go where it was.
  const Box bar{{1.5, -0.4, 0.45}, {1.52, 0.4, 0.47}};
  for (const int beams : {96, 6})
  {
    TestMap m(Scan(0, 0, 0.7).cast({bar}, 720, -0.6, 0.0, 96), {}, 3);
    ASSERT_GT(cells_above(m, 0.3), 6);
    for (int i = 0; i < 5; i++) m.update(Scan(0, 0, 0.7).cast({}, 720, -0.6, 0.0, beams));
    if (beams == 96)
      EXPECT_EQ(cells_above(m, 0.1), 0);
    else
      EXPECT_GT(cells_above(m, 0.3), 6);
  }
}

TEST(Stage5Cleanup, WhatHungInACellLendsNoTimeToWhatStandsThereLater)
{
  // The branch is seen first, over a guess; the robot fits below it. Later beams pass below it.
  const Box branch{{1.5, -0.4, 0.9}, {1.9, 0.4, 0.95}}, person{{1.5, -0.2, 0}, {1.8, 0.2, 0.7}};
  TestMap m(Scan().cast({branch}, 720, -0.3, 0.2), {}, 3);
  ASSERT_EQ(cells_above(m, 0.05), 0);
  for (int i = 0; i < 3; i++) m.update(Scan().cast({branch, person}, 720, -0.6, 0.05));
  ASSERT_GT(cells_above(m, 0.3), 6);
  for (int i = 0; i < 2; i++) m.update(Scan().cast({branch}, 720, -0.6, 0.05));
  EXPECT_EQ(cells_above(m, 0.05), 0);
}

TEST(Stage5Cleanup, RangeNoiseDoesNotMakeABoxOverhang)
{
  // Every fifth hit lies 0.1 m before its face: other rays end behind those hits, on the box.
  const Box box{{2.1, -0.3, 0}, {2.4, 0.3, 0.6}};
  Scan noisy = Scan().cast({box});
  for (std::size_t i = 0; i < noisy.x_.size(); i += 5)
  {
    if (noisy.z_[i] < -0.65f || std::abs(noisy.y_[i]) > 0.3f || noisy.x_[i] < 2.0f) continue;
    const float nearer = 1 - 0.1f / noisy.x_[i];
    noisy.x_[i] *= nearer, noisy.y_[i] *= nearer, noisy.z_[i] *= nearer;
  }
  TestMap m(noisy, {}, 3);
  ASSERT_GE(cells_above(m, 0.1), 15);
  for (int i = 0; i < 2; i++) m.update(Scan().cast({}));
  EXPECT_EQ(cells_above(m, 0.05), 0);
}

TEST(Stage5Cleanup, WhatIsHitForEightFramesOnEndIsNoHedge)
{
  // It covers a cell in part: rays pass beside it, none in its own direction.
  const Scan floor = Scan().cast({}, 1440);
  Scan hit = Scan();
  for (std::size_t i = 0; i < floor.x_.size(); i++)
    if (floor.x_[i] < 1.4f || std::abs(floor.y_[i] / floor.x_[i] - 0.01875f) > 0.0065f)
      hit.add(floor.x_[i], floor.y_[i], floor.z_[i] + 0.7);
  for (double z = 0.05; z < 0.5; z += 0.05) hit.add(1.5, 0.028, z);
  TestMap m(hit, {}, 8);
  ASSERT_GT(m.elevation(1.5, 0.025), 0.3f);
  for (int i = 0; i < 2; i++) m.update(floor);
  EXPECT_FALSE(m.elevation(1.5, 0.025) > 0.05f);
}
