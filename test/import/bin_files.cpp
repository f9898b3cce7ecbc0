// .bin files: how many floats a point has, and what they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bin_columns.h"
#include "log_files.h"
#include "scan_files.h"
#include "scan_formats.h"

using namespace talus::import;
using namespace talus::test;

namespace
{
/** A turn of 32 beams, 1.8 m above a floor and before a wall: x y z intensity ring time each. */
std::vector<std::vector<float>> turn()
{
  std::vector<std::vector<float>> points;
  for (int i = 0; i < 200; ++i)
    for (int beam = 0; beam < 32; ++beam)
    {
      const double angle = 2 * M_PI * i / 200, up = (beam - 24) * 0.02;
      const double to_floor_m = up < 0 ? -1.8 / std::sin(up) : 1e9,
                   to_wall_m = angle < M_PI ? 4 / std::max(std::sin(angle), 1e-3) : 1e9;
      const double range_m = std::min({to_floor_m, to_wall_m, 60.0});
      const double flat_m = range_m * std::cos(up);
      std::vector<float> point;
      for (const double number :
           {flat_m * std::cos(angle), flat_m * std::sin(angle), range_m * std::sin(up),
            std::floor(40 + 30 * std::sin(range_m)), 1.0 * beam, 5e-4 * i})
        point.push_back(static_cast<float>(number));
      points.push_back(point);
    }
  return points;
}

/** The first `count` numbers of each point. */
std::string bin_of(const std::vector<std::vector<float>>& points, std::size_t count)
{
  std::string bytes;
  for (const auto& point : points)
    for (std::size_t k = 0; k < count; ++k) put(bytes, point[k]);
  return bytes;
}

class BinFiles : public testing::Test
{
 protected:
  ScanFile read(const std::string& bytes, const std::vector<std::string>& fields) const
  {
    write_bytes(dir_ / "0.bin", bytes);
    ScanFile scan;
    read_bin(dir_ / "0.bin", fields, scan);
    return scan;
  }
  void refuses(
      const std::string& bytes, const std::vector<std::string>& fields,
      std::vector<std::string> words) const
  {
    words.push_back(dir_ / "0.bin");
    expect_error([&] { read(bytes, fields); }, words);
  }
  ScratchDir dir_;
};
}  // namespace

TEST_F(BinFiles, tell_how_many_floats_a_point_has_in_whatever_order_the_points_are)
{
  auto points = turn();
  for (const bool is_shuffled : {false, true})
  {
    if (is_shuffled) std::shuffle(points.begin(), points.end(), std::mt19937(3));
    for (const std::size_t count : {3, 4, 5, 6})
      for (const std::size_t expected : {3, 4, 5, 6})
      {
        if (count == 2 * expected || expected == 2 * count) continue;  // two points look like one
        EXPECT_EQ(floats_a_point(bin_of(points, count), expected), count)
            << expected << (is_shuffled ? " shuffled" : "");
      }
  }
}

TEST_F(BinFiles, of_another_count_than_kittis_are_refused_with_the_switch_that_reads_them)
{
  const auto points = turn();
  refuses(bin_of(points, 5), {}, {"has 5 floats a point", "--fields x,y,z,intensity,ring."});
  refuses(bin_of(points, 6), {}, {"has 6 floats a point", "--fields x,y,z,intensity,ring,time."});
  refuses(
      bin_of(points, 4), {"x", "y", "z", "i", "ring"}, {"has 4 floats", "not 5 (x y z i ring)"});
  const auto few = std::vector<std::vector<float>>(points.begin(), points.begin() + 3);
  refuses(bin_of(few, 5), {}, {"60 bytes, no multiple of 16", "--fields x,y,z,intensity,ring"});
}

TEST_F(BinFiles, have_the_fields_that_are_named)
{
  const auto points = turn();
  const ScanFile scan = read(bin_of(points, 6), {"x", "y", "z", "intensity", "ring", "time"});
  ASSERT_EQ(scan.x_m.size(), points.size());
  EXPECT_EQ(static_cast<float>(scan.z_m[70]), points[70][2]);
  EXPECT_EQ(scan.intensity[70], points[70][3]);
  EXPECT_EQ(scan.ring[70], 70 % 32);
  EXPECT_EQ(static_cast<float>(scan.time[70]), points[70][5]);
  const ScanFile other = read(bin_of(points, 6), {"y", "x", "z", "_", "_", "_"});
  EXPECT_EQ(static_cast<float>(other.y_m[70]), points[70][0]);
  EXPECT_TRUE(other.intensity.empty() && other.ring.empty() && other.time.empty());
}

TEST_F(BinFiles, of_nuscenes_are_known_by_their_name)
{
  const auto points = turn();
  write_bytes(dir_ / "LIDAR_TOP__1.pcd.bin", bin_of(points, 5));
  ScanFile scan;
  read_bin(dir_ / "LIDAR_TOP__1.pcd.bin", {}, scan);
  EXPECT_EQ(scan.ring[70], 70 % 32);
  EXPECT_EQ(scan.intensity[70], points[70][3]);
}
