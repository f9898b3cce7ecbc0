// The command talus-export from end to end: stock programs open what it writes and find the cells
// of the GeoTIFF.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/serialization/CArchive.h>
#include <octomap/OcTree.h>
#include <talus/io/geotiff.h>
#include <talus/site/site_files.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "command_run.h"
#include "sites.h"
#include "small_terrain.h"

using namespace talus;
using namespace talus::test;

namespace
{
class TalusExport : public CommandTest
{
 protected:
  TalusExport() : CommandTest(TALUS_EXPORT_EXE)
  {
    io::write_geotiff(dir_ / "site.tif", small_terrain());
  }
  bool has(const std::string& program) const { return shell("command -v " + program).code == 0; }
};

/** Cells that are occupied, free, and neither. */
std::array<int, 3> counts(const mrpt::maps::COccupancyGridMap2D& grid)
{
  std::array<int, 3> n{};
  for (unsigned y = 0; y < grid.getSizeY(); ++y)
    for (unsigned x = 0; x < grid.getSizeX(); ++x)
    {
      const float free = grid.getCell(static_cast<int>(x), static_cast<int>(y));
      ++n[free < 0.4F ? 0 : free > 0.6F ? 1 : 2];
    }
  return n;
}
const std::array<int, 3> kCounts{
    kSmallTerrainBox, kSmallTerrainJudged - kSmallTerrainBox, 60 * 40 - kSmallTerrainJudged};

TEST_F(TalusExport, stock_programs_find_the_cells_of_the_map_in_each_format)
{
  runs("site.tif --to ros,occupancy,gridmap,octomap,ply,heightmap,qgis,html --output a/b");
  for (const char* name : {"site_height.png", "site_height.json", "site.qml", "site.html"})
    EXPECT_TRUE(exists("a/b/" + std::string(name))) << name;

  mrpt::maps::COccupancyGridMap2D grid;
  ASSERT_TRUE(grid.loadFromROSMapServerYAML(path("a/b/site.yaml")));
  EXPECT_EQ(grid.getSizeX(), 60U);
  EXPECT_NEAR(grid.getXMin(), -1, 0.06);
  EXPECT_NEAR(grid.getYMin(), 2, 0.06);
  EXPECT_EQ(counts(grid)[0], kCounts[0]);
  EXPECT_LT(grid.getPos(1.05F, 3.05F), 0.1F) << "the box is where it is in the GeoTIFF";
  EXPECT_GT(grid.getPos(0.05F, 3.05F), 0.9F);

  const cv::Mat picture = cv::imread(path("a/b/site.pgm"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.size(), cv::Size(60, 40));
  std::array<int, 3> n{};
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
    {
      const double occupied = (255 - picture.at<uchar>(y, x)) / 255.0;  // as map_server, trinary
      ++n[occupied > 0.65 ? 0 : occupied < 0.196 ? 1 : 2];
    }
  EXPECT_EQ(n, kCounts);
  EXPECT_EQ(picture.at<uchar>(39 - 12, 22), 0) << "its last row is the southernmost";

  mrpt::io::CFileGZInputStream stream(path("a/b/site.gridmap.gz"));
  mrpt::serialization::archiveFrom(stream) >> grid;
  EXPECT_EQ(counts(grid), kCounts);

  const std::string bag = read_bytes(dir_ / "a/b/site_gridmap.mcap");
  const auto row_index =
      bag.find("row_index");  // of its first layer, then size, stride, offset, count
  ASSERT_NE(row_index, std::string::npos);
  std::array<std::uint32_t, 4> n_rows{};
  const std::size_t numbers_at = row_index + 10 + 2;
  std::memcpy(n_rows.data(), bag.data() + numbers_at, sizeof n_rows);
  EXPECT_EQ(n_rows, (std::array<std::uint32_t, 4>{60, 60, 0, 60 * 40}));
  float of_box = 1;  // (22, 12); its first cell is the north-easternmost
  std::memcpy(&of_box, bag.data() + numbers_at + 4 * (4 + 2399 - (12 * 60 + 22)), sizeof of_box);
  EXPECT_EQ(of_box, 0);
  expect_end(
      shell(TALUS_BIN "/talus-import a/b/site_gridmap.mcap --output no.rawlog"), 1,
      {"grid_map_msgs/msg/GridMap"});

  const octomap::OcTree tree(path("a/b/site.bt"));
  int leaves = 0, voxels = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf)
  {
    if (!tree.isNodeOccupied(*leaf)) continue;
    const auto side = static_cast<int>(std::lround(leaf.getSize() / tree.getResolution()));
    voxels += side * side * side;
    ++leaves;
  }
  EXPECT_EQ(voxels, kSmallTerrainJudged + 5 * kSmallTerrainBox)
      << "the ground, and five above each of the box";
  if (has("bt2vrml"))
  {
    EXPECT_SAYS(
        shell("bt2vrml a/b/site.bt").text,
        "Finished writing " + std::to_string(leaves) + " voxels");
  }

  mrpt::maps::CSimplePointsMap points;
  ASSERT_TRUE(points.loadFromPlyFile(path("a/b/site.ply")));
  EXPECT_EQ(points.size(), std::size_t{50 * 40 + 4 * kSmallTerrainBox + 2 * (20 + 20)});
  if (has("assimp"))
  {
    EXPECT_SAYS(
        shell("assimp info a/b/site.ply").text,
        "Faces:              " + std::to_string(kSmallTerrainFaces));
  }
}

TEST_F(TalusExport, a_name_of_a_map_is_one_value_of_its_yaml)
{
  const std::string name = "hall #2\nnegate: 1";
  std::filesystem::rename(dir_ / "site.tif", dir_ / (name + ".tif"));
  runs("'" + name + ".tif' --to ros");
  const std::string yaml = read_bytes(dir_ / (name + ".yaml"));
  EXPECT_SAYS(yaml, "image: \"hall #2\\nnegate: 1.pgm\"");
  mrpt::maps::COccupancyGridMap2D grid;
  EXPECT_TRUE(grid.loadFromROSMapServerYAML(dir_ / (name + ".yaml")));
}

TEST_F(TalusExport, scale_tells_how_well_a_free_cell_drives_and_what_is_unknown)
{
  runs("site.tif --to ros --ros-mode scale");
  const cv::Mat picture = cv::imread(dir_ / "site_scale.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.type(), CV_8UC4);
  const auto at = [&](int ix, int iy) { return picture.at<cv::Vec4b>(39 - iy, ix); };
  EXPECT_EQ(at(22, 12)[0], 0);
  EXPECT_EQ(at(10, 12)[0], 91 + 130) << "0.8 of the way from what is nearly blocked to free";
  EXPECT_EQ(at(10, 12)[3], 255);
  EXPECT_EQ(at(55, 12)[3], 0);
  EXPECT_SAYS(read_bytes(dir_ / "site.yaml"), "mode: scale");
}

TEST_F(TalusExport, a_site_is_exported_with_its_floors)
{
  site::Site site(0.05, std::size_t{64} << 20, dir_ / "tiles");
  for (const int floor : {0, 1}) cell_at(site, 0, 0, floor) = measured(1);
  site::write_site_files(dir_ / "two.tif", "", site);
  runs("two.tif --to ros --output out");
  EXPECT_TRUE(std::filesystem::exists(dir_ / "out/two.yaml"));
  EXPECT_TRUE(std::filesystem::exists(dir_ / "out/two_floor_1.yaml"));
}

TEST_F(TalusExport, of_a_site_with_a_flipped_bit_or_of_a_part_whose_name_is_that_of_a_floor)
{
  site::Site site(0.05, std::size_t{64} << 20, dir_ / "tiles");
  cell_at(site, 0, 0) = measured(1);
  site::write_site_files(dir_ / "whole.tif", "", site);
  std::string bytes = read_bytes(dir_ / "whole.tif");
  const std::size_t sums = bytes.find("TALUS_TILE_SUMS");
  bytes[bytes.find("</Item>", sums) - 1] ^= 1;  // of what the cells must sum to
  write_bytes(dir_ / "whole.tif", bytes);
  fails("whole.tif --to ros", 1, {"whole.tif: its cells near (3, 3) m are not those"});

  std::filesystem::copy_file(dir_ / "site.tif", dir_ / "site_floor_1.tif");
  runs("site_floor_1.tif --to ply");
  runs("site.tif --to ply,octomap --quiet");
  EXPECT_TRUE(exists("site_floor_1.ply")) << "it is of another map";
}

TEST_F(TalusExport, replaces_no_input_and_no_file_of_its_own)
{
  std::filesystem::create_directories(dir_ / "friday");
  std::filesystem::copy_file(dir_ / "site.tif", dir_ / "friday/site.tif");
  std::filesystem::copy_file(dir_ / "site.tif", dir_ / "page.html");
  const std::string map = read_bytes(dir_ / "site.tif");
  fails("page.html --to html", 1, {"page.html' would be overwritten", "is an input"});
  EXPECT_EQ(read_bytes(dir_ / "page.html"), map);
  fails(
      "site.tif friday/site.tif --to ros --output share", 1,
      {"site.tif and friday/site.tif: both would be written as share/site.yaml"});
  EXPECT_FALSE(std::filesystem::exists(dir_ / "share"));
}

TEST_F(TalusExport, on_a_full_disk_the_good_files_of_before_stay)
{
  io::LayerStack map = small_terrain();
  map.cells_x = map.cells_y = 320;
  for (auto& layer : map.layers) layer.assign(102'400, 1.0F);
  for (std::uint32_t i = 0; i < 102'400; ++i)
    map.layers[0][i] = map.layers[1][i] = static_cast<float>(i * i * 2654435761U >> 16 & 1U);
  std::filesystem::create_directory(dir_ / "noise");
  io::write_geotiff(dir_ / "noise/site.tif", map);
  for (const std::string format : {"occupancy", "octomap", "ply", "heightmap", "ros", "html"})
  {
    runs("site.tif --output out --to " + format);
    std::map<std::string, std::string> before;
    for (const auto& e : std::filesystem::directory_iterator(dir_ / "out"))
      before[e.path().string()] = read_bytes(e.path().string());
    const CommandEnd full = run("noise/site.tif --output out --to " + format, "ulimit -f 16;");
    EXPECT_EQ(full.code, 1) << format << full.text;
    EXPECT_SAYS_NOT(full.text, "MRPT");
    for (const auto& [file, bytes] : before) EXPECT_TRUE(read_bytes(file) == bytes) << file;
  }
}

TEST_F(TalusExport, that_is_stopped_leaves_a_picture_and_its_yaml_of_one_map)
{
  io::LayerStack map = small_terrain();
  map.cells_y = 20;
  for (auto& layer : map.layers) layer.resize(60 * 20);
  map.min_x_m = 7;
  io::write_geotiff(dir_ / "low.tif", map);
  std::filesystem::create_directory(dir_ / "friday");
  std::filesystem::rename(dir_ / "low.tif", dir_ / "friday/site.tif");
  for (const std::string after_s : {"0.02", "0.08", "0.16", "0.3"})
  {
    runs("site.tif --to ros --output out");
    const CommandEnd o = shell(
        "timeout --preserve-status -s TERM " + after_s +
        " " TALUS_EXPORT_EXE " friday/site.tif --to ros,ply,heightmap --output out");
    const bool is_new = o.code == 0;
    EXPECT_TRUE(is_new || o.code == 128 + 15) << o.code << o.text;
    EXPECT_EQ(o.text.find("wrote") != std::string::npos, is_new) << o.text;
    EXPECT_EQ(read_bytes(dir_ / "out/site.yaml").find("[7, 2, 0]") != std::string::npos, is_new);
    EXPECT_EQ(read_bytes(dir_ / "out/site.pgm").find("60 20\n") != std::string::npos, is_new);
  }
}

TEST_F(TalusExport, a_format_that_fails_costs_no_other_file)
{
  io::LayerStack map = small_terrain();
  map.names[1] = "other";
  io::write_geotiff(dir_ / "flat.tif", map);
  fails(
      "flat.tif site.tif --to ply,ros", 1,
      {"no layer 'ground_elevation'", "wrote   flat.yaml", "wrote   site.ply"});
  EXPECT_TRUE(std::filesystem::exists(dir_ / "flat.pgm"));
  EXPECT_FALSE(std::filesystem::exists(dir_ / "flat.ply"));
}

TEST_F(TalusExport, says_what_is_wrong)
{
  fails("site.tif", 2, {"--to is required"});
  fails("site.tif --to rso", 2, {"rso", "ros"});
  fails("site.tif --to ros --changes c.tif", 2, {"--changes is shown by html only"});
  for (const std::string origin : {"nan,0,0", "1e300,0,0", "0,0"})
    fails("site.tif --to ply --origin " + origin, 2, {"--origin"});
  fails("site.tif --to occupancy --origin 4000000.13,0,0", 1, {"borders of 32 bit", "--origin"});
  fails("none.tif --to ros", 1, {"none.tif", "no such file"});
  io::LayerStack other = small_terrain();
  other.names = {"a", "b", "c", "d"};
  io::write_geotiff(dir_ / "other.tif", other);
  fails("other.tif --to ros", 1, {"other.tif", "none of the bands of a map"});
  for (const float v : {1e38F, INFINITY, -INFINITY})
  {
    io::LayerStack high = small_terrain();
    high.layers[2][5] = v;
    io::write_geotiff(dir_ / "high.tif", high);
    fails("high.tif --to ply", 1, {"high.tif", "'elevation' has the value", "make it anew"});
  }
  io::LayerStack mean = small_terrain();
  for (std::size_t i = 0; i < mean.names.size(); ++i)
    if (mean.names[i] == "state") mean.layers[i][5] = 1.5F;
  io::write_geotiff(dir_ / "mean.tif", mean);
  fails("mean.tif --to octomap", 1, {"mean.tif", "'state' has the value 1.5"});
  EXPECT_EQ(runs("site.tif --to octomap --quiet").text, "");
  io::LayerStack elsewhere = small_terrain();
  elsewhere.min_x_m += 100;
  io::write_geotiff(dir_ / "elsewhere.tif", elsewhere);
  fails("site.tif --to html --changes elsewhere.tif", 1, {"elsewhere.tif", "lies elsewhere"});
  fails("site.tif --to html --changes site.tif", 1, {"'kind'", "changes.tif of talus-merge"});
  fails("site.tif --to ros --output site.tif/x", 1, {"site.tif"});
}

TEST_F(TalusExport, the_page_works_in_a_browser)
{
  runs("site.tif --to html --title '<img src=x onerror=alert()><script>alert()</script>'");
  EXPECT_NE(
      read_bytes(dir_ / "site.html").find("Copyright (c) 2010-2019, Vladimir Agafonkin"),
      std::string::npos);
  const CommandEnd o = shell("/usr/bin/python3 " TALUS_BROWSER_SCRIPT " site.html");
  if (o.code == 77) GTEST_SKIP() << o.text;
  EXPECT_EQ(o.code, 0) << o.text;
}

/** The ground has the label 4 and one colour, the box the label 7 and another. */
TEST_F(TalusExport, channels_are_layers_of_the_page)
{
  io::LayerStack map = small_terrain();
  const std::vector<float> state = *map.find("state");
  const auto add = [&](const std::string& name, float ground, float standing)
  {
    for (const bool stands : {false, true})
    {
      map.names.push_back(stands ? name + "_standing" : name);
      auto& layer = map.layers.emplace_back(state.size(), NAN);
      for (int iy = stands ? 10 : 0; iy < (stands ? 15 : map.cells_y); ++iy)
        for (int ix = stands ? 20 : 0; ix < (stands ? 25 : 50); ++ix)
          layer[static_cast<std::size_t>(iy * map.cells_x + ix)] = stands ? standing : ground;
    }
  };
  add("label", 4, 7);
  add("red", 200, 10);
  add("green", 100, 20);
  add("blue", 50, 30);
  io::write_geotiff(dir_ / "channels.tif", map);
  runs("channels.tif --to html");
  const std::string page = read_bytes(dir_ / "channels.html");
  EXPECT_SAYS(page, "\"name\":\"label_standing\"");
  const CommandEnd o = shell("/usr/bin/python3 " TALUS_BROWSER_SCRIPT " channels.html");
  if (o.code == 77) GTEST_SKIP() << o.text;
  EXPECT_EQ(o.code, 0) << o.text;
}
}  // namespace
