// The tree of frames of a bag: chains, what moves in them, what is forgotten.
#include "bag_frames.h"

#include <gtest/gtest.h>

using namespace talus::import;
using mrpt::math::TPose3DQuat;

namespace
{
constexpr std::int64_t kSecond_ns = 1000000000;

FrameTransform link(
    const std::string& parent, const std::string& child, double x_m, std::int64_t stamp_ns = 0)
{
  FrameTransform transform;
  transform.parent = {stamp_ns, parent};
  transform.child = child;
  transform.T_parent_child = TPose3DQuat(x_m, 0, 0, 1, 0, 0, 0);
  return transform;
}

/** map - odom - base - mast - lidar, of which odom and base move. */
FrameTree robot()
{
  FrameTree tree;
  tree.add(link("mast", "lidar", 0.25), true);
  for (int i = 0; i <= 10; ++i)
  {
    tree.add(link("odom", "base", i, i * kSecond_ns), false);
    if (i % 5 == 0) tree.add(link("map", "odom", 100.0 + i, i * kSecond_ns), false);
  }
  tree.add(link("base", "mast", 0.5), true);
  tree.sort();
  return tree;
}
}  // namespace

TEST(FrameTree, InterpolatesEachLinkOfAChainWhereverItsEndsAre)
{
  const auto tree = robot();
  EXPECT_NEAR(tree.T_between("map", "base", 5 * kSecond_ns / 2)->x(), 105, 1e-9);
  EXPECT_NEAR(tree.T_between("base", "map", 5 * kSecond_ns / 2)->x(), -105, 1e-9);
  EXPECT_NEAR(tree.T_between("base", "lidar", 0)->x(), 0.75, 1e-9);
  EXPECT_NEAR(tree.T_between("lidar", "odom", kSecond_ns)->x(), -1.75, 1e-9);
  EXPECT_EQ(tree.times_between("map", "base").size(), 11u);
  EXPECT_TRUE(tree.times_between("base", "lidar").empty());
}

TEST(FrameTree, KnowsNothingOutsideOfAHistoryAndBetweenTwoTrees)
{
  auto tree = robot();
  EXPECT_TRUE(tree.T_between("map", "base", 10 * kSecond_ns + 50000000).has_value());
  EXPECT_FALSE(tree.T_between("map", "base", 11 * kSecond_ns).has_value());
  EXPECT_TRUE(tree.T_between("base", "lidar", 11 * kSecond_ns).has_value());
  tree.add(link("dock", "beacon", 1), true);
  EXPECT_FALSE(tree.connects("base", "beacon"));
  EXPECT_FALSE(tree.T_between("base", "nowhere", 0).has_value());
}

TEST(FrameTree, StandsFramesInACircleAndWithTwoParents)
{
  FrameTree tree;
  tree.add(link("a", "b", 1), true);
  tree.add(link("b", "c", 1), true);
  tree.add(link("c", "a", 1), true);
  EXPECT_FALSE(tree.connects("a", "d"));
  tree.add(link("d", "b", 7), true);
  tree.add(link("d", "b", 7), true);
  EXPECT_EQ(tree.conflicts(), std::set<std::string>{"b"});
}

TEST(FrameTree, ForgetsLongHistoriesThatNobodyAsksForAndFastOnesInPart)
{
  auto tree = robot();
  for (int i = 0; i < 30000; ++i) tree.add(link("base", "wheel", i, i * kSecond_ns / 100), false);
  const auto before = tree.size();
  tree.keep_chains_of({"lidar"});
  EXPECT_LT(tree.size() + 29000, before);
  EXPECT_TRUE(tree.T_between("map", "lidar", kSecond_ns).has_value());
  EXPECT_FALSE(tree.T_between("base", "wheel", kSecond_ns).has_value());

  PoseHistory history;
  for (int i = 0; i < 1000; ++i) history.add(i * kSecond_ns / 1000, {});
  EXPECT_EQ(history.all().size(), 200u);
}
