// A file that is the map of a whole drive: what of it is ground, and the scans that it is cut into.
#include <gtest/gtest.h>

#include <cmath>

#include "bags.h"
#include "ground_levels.h"
#include "scan_formats.h"
#include "whole_map.h"

using namespace talus::import;
using namespace talus::test;

namespace
{
void add(ScanFile& cloud, double x, double y, double z)
{
  cloud.x_m.push_back(x);
  cloud.y_m.push_back(y);
  cloud.z_m.push_back(z);
}

/** A yard of 20 x 20 m with a ramp of 1 in 4, a house of which roof and walls are seen, and a yard
 * of 8 x 8 m far away. */
ScanFile yard()
{
  ScanFile cloud;
  for (double x = -10; x < 10; x += 0.1)
    for (double y = -10; y < 10; y += 0.1)
    {
      const bool is_house = x > -8 && x < -2 && y > -3 && y < 3;
      add(cloud, x, y, is_house ? 3 : x > 4 ? (x - 4) / 4 : 0);
    }
  for (double z = 0; z < 3; z += 0.1)
    for (double y = -3; y < 3; y += 0.1)
      for (const double x : {-8.0, -2.0}) add(cloud, x, y, z);
  for (double x = 30; x < 38; x += 0.1)
    for (double y = 0; y < 8; y += 0.1) add(cloud, x, y, -1);
  return cloud;
}

std::string with_viewpoints(int count)
{
  std::string bytes =
      "VERSION 0.7\nFIELDS x y z vp_x vp_y vp_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
      "COUNT 1 1 1 1 1 1\nWIDTH " +
      std::to_string(count) + "\nHEIGHT 1\nPOINTS " + std::to_string(count) + "\nDATA binary\n";
  for (int i = 0; i < count; ++i)
    for (const float number :
         {0.1F * static_cast<float>(i), 1.0F, 0.0F, 0.5F * static_cast<float>(i / 10), 0.0F,
          i == 7 ? NAN : 0.6F})
      put(bytes, number);
  return bytes;
}
}  // namespace

TEST(GroundLevels, ConnectAndRoofsDoNot)
{
  GroundLevels ground(yard());
  ASSERT_TRUE(ground.reach_from(0, 0, 1.2));
  EXPECT_NEAR(ground.below(0, 5, 1).value(), 0, 1e-6);
  EXPECT_NEAR(ground.below(9, 0, 1.5).value(), 1.25, 0.1) << "up the ramp";
  EXPECT_NEAR(ground.below(-5, 0, 3).value_or(0), 0, 1e-6) << "the roof is high above ground";
  EXPECT_FALSE(ground.below(34, 4, -1));
  ground.reach_rest();
  EXPECT_NEAR(ground.below(34, 4, -1).value(), -1, 1e-6) << "a yard of its own";
  EXPECT_FALSE(ground.below(-5, 0, 3).value_or(0) > 1) << "not so the roof, which lies beside it";
  EXPECT_FALSE(ground.has_storeys());
}

TEST(GroundLevels, WithoutABeginningAreTheLowOnesOfTheLarge)
{
  ScanFile rooms;
  for (double x = 0; x < 10; x += 0.1)
    for (double y = 0; y < 10; y += 0.1)
      for (const double z : {100.0, 102.5}) add(rooms, x, y, z);
  GroundLevels ground(rooms);
  EXPECT_FALSE(ground.reach_from(0, 0, 0));
  ground.reach_rest();
  EXPECT_EQ(ground.below(5, 5, 103).value(), 100) << "the other is a ceiling";
}

TEST(WholeMap, IsCutIntoTilesWithSteepRays)
{
  const ScratchDir dir;
  const ScanFile cloud = yard();
  Points p;
  for (std::size_t i = 0; i < cloud.x_m.size(); ++i)
  {
    p.x.push_back(static_cast<float>(cloud.x_m[i]));
    p.y.push_back(static_cast<float>(cloud.y_m[i]));
    p.z.push_back(static_cast<float>(cloud.z_m[i] - 0.5));
  }
  write_bytes(dir / "map.pcd", pcd_binary(p));
  const auto map = open_scan_source(Input(dir / "map.pcd"), {});
  EXPECT_EQ(map->pieces(), Pieces::Tiles);
  std::size_t points = 0;
  const auto scans = all_of(*map);
  for (const auto& scan : scans)
    for (std::size_t i = 0; i < scan.x_m.size(); ++i, ++points)
    {
      ASSERT_LT(std::max(std::abs(scan.x_m[i]), std::abs(scan.y_m[i])), 0.251);
      ASSERT_LT(scan.z_m[i], -0.6) << "nothing of the roof";
      ASSERT_GT(scan.z_m[i], -2.9);
    }
  EXPECT_GT(points, cloud.x_m.size() - 3600 - 2000) << "all but the roof and the tops of walls";
  const auto poses = map->poses();
  ASSERT_EQ(poses.entries().size(), scans.size());
  EXPECT_EQ(poses.entries()[5].T_map_base, *scans[5].T_map_sensor);

  SourceOptions options;
  options.scale = 1000;
  expect_error(
      [&] { open_scan_source(Input(dir / "map.pcd"), options); },
      {"map.pcd", "--mount", "--scale"});
  options = {};
  options.is_one_scan = true;
  const auto scan = open_scan_source(Input(dir / "map.pcd"), options);
  EXPECT_EQ(scan->pieces(), Pieces::Scans);
  EXPECT_EQ(all_of(*scan).size(), 1u);
}

TEST(WholeMap, WithViewpointsIsScans)
{
  const ScratchDir dir;
  write_bytes(dir / "map.pcd", with_viewpoints(30));
  const auto map = open_scan_source(Input(dir / "map.pcd"), {});
  EXPECT_EQ(map->pieces(), Pieces::Viewpoints);
  const auto scans = all_of(*map);
  ASSERT_EQ(scans.size(), 3u);
  std::size_t points = 0;
  for (std::size_t i = 0; i < 3; ++i)
  {
    EXPECT_NEAR(scans[i].T_map_sensor->x(), 0.5 * static_cast<double>(i), 1e-6);
    EXPECT_NEAR(scans[i].T_base_sensor.z(), 0.6, 1e-6) << "above the points";
    EXPECT_NEAR(scans[i].x_m[0], 0.5 * static_cast<double>(i), 1e-5);
    points += scans[i].x_m.size();
  }
  EXPECT_EQ(points, 29u) << "one has none";
}
