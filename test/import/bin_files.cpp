// .bin files: how many floats a point has, and what they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "label_file.h"
#include "log_files.h"
#include "formats.h"
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
    scan.fields = fields;
    read_bin(dir_ / "0.bin", scan);
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
  read_bin(dir_ / "LIDAR_TOP__1.pcd.bin", scan);
  EXPECT_EQ(scan.ring[70], 70 % 32);
  EXPECT_EQ(scan.intensity[70], points[70][3]);
}

namespace
{
struct LabelledBin : BinFiles
{
  /** Three points, the second of which is no number. */
  ScanFile read_labelled(const std::string& values) const
  {
    ScanFile scan;
    scan.values = values;
    const float none = std::nanf("");
    std::string bytes;
    for (const float v : {1.0F, 2.0F, 3.0F, 0.5F, none, 2.0F, 3.0F, 0.5F, 4.0F, 5.0F, 6.0F, 0.5F})
      put(bytes, v);
    write_bytes(dir_ / "velodyne/000007.bin", bytes);
    read_bin(dir_ / "velodyne/000007.bin", scan);
    return scan;
  }
  void write_labels(const std::string& path, const std::vector<std::uint32_t>& labels) const
  {
    std::string bytes;
    for (const std::uint32_t label : labels) put(bytes, label);
    write_bytes(dir_ / path, bytes);
  }
};
}  // namespace

TEST_F(LabelledBin, has_the_labels_of_a_file_beside_it)
{
  std::filesystem::create_directories(dir_ / "velodyne");
  std::filesystem::create_directories(dir_ / "labels");
  expect_error([&] { read_labelled("label"); }, {"000007.label"});
  write_labels("velodyne/000007.label", {1, 2, 3});
  EXPECT_EQ(read_labelled("label").intensity, (std::vector<float>{1, 3}));
  // Those of the data set come first; above the lower 16 bits is the number of the thing.
  write_labels("labels/000007.label", {(7U << 16) + 252, 0, 40});
  EXPECT_EQ(read_labelled("label").intensity, (std::vector<float>{252, 40}));
  EXPECT_EQ(read_labelled("semantickitti").intensity, (std::vector<float>{1, 6}));
  EXPECT_EQ(read_labelled("").intensity, (std::vector<float>{0.5F, 0.5F}));
  write_labels("labels/000007.label", {1, 2});
  expect_error([&] { read_labelled("label"); }, {"labels/000007.label", "8 bytes", "12"});
}

TEST(Labels, of_semantickitti_become_sixteen_classes)
{
  for (std::uint32_t label = 0; label < 300; ++label)
    EXPECT_LT(class_of_semantickitti(label), 16U) << label;
  for (const auto& [label, of_class] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
           {0, 0},
           {1, 0},
           {99, 0},
           {10, 1},
           {252, 1},
           {40, 6},
           {60, 6},
           {48, 8},
           {72, 14},
           {81, 15}})
    EXPECT_EQ(class_of_semantickitti(label), of_class) << label;
}
