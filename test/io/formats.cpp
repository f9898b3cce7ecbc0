// Maps of terrain as maps of MRPT and OctoMap: the same cells, places and heights.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/serialization/CArchive.h>
#include <octomap/OcTree.h>
#include <talus/formats/convert.h>
#include <talus/formats/page.h>
#include <talus/formats/write.h>

#include <cstdlib>

#include "log_files.h"
#include "small_terrain.h"

using namespace talus;
using namespace talus::formats;
using namespace talus::test;

namespace
{
TEST(Formats, the_occupancy_grid_has_the_cells_of_the_map)
{
  mrpt::maps::COccupancyGridMap2D grid;
  to_occupancy_grid(small_terrain(), 0.0, grid);
  ASSERT_EQ(grid.getSizeX(), 60U);
  ASSERT_EQ(grid.getSizeY(), 40U);
  EXPECT_NEAR(grid.getXMin(), -1, 1e-6);
  EXPECT_NEAR(grid.getYMin(), 2, 1e-6);
  EXPECT_LT(grid.getCell(22, 12), 0.1F);
  EXPECT_GT(grid.getCell(10, 12), 0.9F);
  EXPECT_NEAR(grid.getCell(10, 0), 0.5F, 0.01F);
  EXPECT_NEAR(grid.getCell(55, 12), 0.5F, 0.01F);
  to_occupancy_grid(small_terrain(), 0.8, grid);
  EXPECT_LT(grid.getCell(10, 12), 0.1F) << "0.8 or less is blocked now";
}

TEST(Formats, free_islands_that_are_smaller_than_the_robot_are_closed)
{
  io::LayerStack map = small_terrain();
  auto& score = map.layers[0];
  const auto at = [&](int x, int y) -> float&
  { return score[static_cast<std::size_t>(y * map.cells_x + x)]; };
  at(22, 12) = 0.5F;  // on the box
  for (const int x : {53, 54, 55}) at(x, 5) = 1;  // in the unknown
  for (int x = 52; x < 58; ++x) at(x, 30 + std::abs(x - 54)) = 1;  // corner by corner
  const ScratchDir dir;
  const auto pixels = [&](double close_m)
  {
    write_ros_map(dir / "m.yaml", map, RosMode::Trinary, {0.0, close_m});
    const std::string pgm = read_bytes(dir / "m.pgm");
    return pgm.substr(pgm.size() - score.size());
  };
  const auto pixel = [&](const std::string& of, int x, int y)
  { return static_cast<unsigned char>(of[static_cast<std::size_t>((39 - y) * 60 + x)]); };
  const std::string all = pixels(0), closed = pixels(0.5);
  for (const auto& p : {std::pair{22, 12}, std::pair{54, 5}, std::pair{54, 30}})
    EXPECT_EQ(pixel(all, p.first, p.second), 254);
  EXPECT_EQ(pixel(closed, 22, 12), 0) << "blocked as the box around it";
  EXPECT_EQ(pixel(closed, 54, 5), 205) << "unknown as what is around it";
  EXPECT_EQ(pixel(closed, 54, 30), 254) << "0.6 m wide";
  EXPECT_EQ(pixel(closed, 10, 12), 254);
}

TEST(Formats, points_are_the_measured_ground_or_the_columns_on_it)
{
  mrpt::maps::CSimplePointsMap ground, standing;
  to_points(small_terrain(), Surface::Ground, ground);
  to_points(small_terrain(), Surface::Standing, standing);
  EXPECT_EQ(ground.size(), std::size_t{kSmallTerrainJudged});
  EXPECT_EQ(standing.size(), std::size_t{5 * kSmallTerrainBox}) << "0.5 m in steps of a cell";
  float x = 0, y = 0, z = 0;
  standing.getPoint(0, x, y, z);
  EXPECT_NEAR(x, 1.05, 1e-5);
  EXPECT_NEAR(y, 3.05, 1e-5);
  EXPECT_NEAR(z, 1.7, 1e-5);
}

TEST(Formats, the_octree_is_occupied_free_or_unknown_as_the_map_is)
{
  octomap::OcTree tree(0.1);
  to_octomap(small_terrain(), 0.6, tree);
  const auto at = [&](double x, double y, double z)
  {
    const auto* node = tree.search(x, y, z);
    return !node ? '?' : tree.isNodeOccupied(node) ? '#' : ' ';
  };
  EXPECT_EQ(at(1.05, 3.05, 1.25), '#') << "the ground below the box";
  EXPECT_EQ(at(1.05, 3.05, 1.65), '#') << "the box";
  EXPECT_EQ(at(1.05, 3.05, 1.95), '?') << "above the box";
  EXPECT_EQ(at(0.05, 3.05, 1.15), '#') << "bare ground";
  EXPECT_EQ(at(0.05, 3.05, 1.55), ' ') << "above bare ground";
  EXPECT_EQ(at(0.05, 3.05, 1.95), '?') << "above the clearance";
  EXPECT_EQ(at(0.05, 2.05, 1.55), '?') << "above ground that was not measured";
  EXPECT_EQ(at(0.05, 2.05, 1.15), '?') << "a guess that was not judged";
  EXPECT_EQ(at(4.55, 3.05, 1.55), '?') << "nothing is known";
}

TEST(Formats, the_octree_of_a_map_that_reaches_too_far_is_coarser_and_told)
{
  const ScratchDir dir;
  io::LayerStack map = small_terrain();
  EXPECT_EQ(write_octomap(dir / "near.bt", map, 0.6), "");
  map.min_x_m = 4000;  // 40000 voxels
  const std::string told = write_octomap(dir / "far.bt", map, 0.6);
  EXPECT_SAYS(told, "far.bt: its voxels are 0.2 m wide, not 0.1 m");
  const octomap::OcTree tree(dir / "far.bt");
  const auto* box = tree.search(4002.1, 3.1, 1.5);
  ASSERT_TRUE(box);
  EXPECT_TRUE(tree.isNodeOccupied(box));
}

TEST(Formats, far_coordinates_are_less_by_an_origin_that_is_named)
{
  const ScratchDir dir;
  io::LayerStack map = small_terrain();
  EXPECT_EQ(origin_for(map).x_m, 0);
  map.min_x_m += 548123;
  map.min_y_m += 4076543;
  const FileOrigin origin = origin_for(map);
  EXPECT_EQ(origin.x_m, 548000);
  EXPECT_EQ(origin.y_m, 4077000);
  write_mesh(dir / "m.ply", map, 1000000, origin);
  const std::string mesh = read_bytes(dir / "m.ply");
  EXPECT_SAYS(mesh, "comment origin_m: 548000 4077000 0\n");
  EXPECT_EQ(read_bytes(dir / "m_mesh.json"), "{\"origin_m\": [548000,4077000,0]}\n");
  mrpt::maps::CSimplePointsMap points;
  ASSERT_TRUE(points.loadFromPlyFile(dir / "m.ply"));
  float x = 0, y = 0, z = 0, next_x = 0;
  points.getPoint(0, x, y, z);
  points.getPoint(1, next_x, y, z);
  EXPECT_NEAR(x, 122.05, 1e-4);
  EXPECT_NEAR(next_x - x, 0.1, 1e-4);
  EXPECT_EQ(write_octomap(dir / "m.bt", map, 0.6, origin), "");
  const octomap::OcTree tree(dir / "m.bt");
  const auto* box = tree.search(124.05, -453.95, 1.65);
  ASSERT_TRUE(box);
  EXPECT_TRUE(tree.isNodeOccupied(box));
  EXPECT_SAYS(read_bytes(dir / "m.bt"), "# origin_m: 548000 4077000 0\n");
  write_occupancy_grid(dir / "m.gz", map, {}, origin);
  mrpt::maps::COccupancyGridMap2D grid;
  mrpt::io::CFileGZInputStream stream(dir / "m.gz");
  mrpt::serialization::archiveFrom(stream) >> grid;
  EXPECT_EQ(grid.getSizeX(), 60U);
  EXPECT_LT(grid.getPos(124.05F, -453.95F), 0.1F);
}

TEST(Formats, the_occupancy_grid_has_its_cells_where_the_map_has_them)
{
  const ScratchDir dir;
  io::LayerStack map = small_terrain();
  map.resolution_m = 0.15;
  map.min_x_m = 548000.05;
  map.min_y_m = 0.07;
  const FileOrigin origin = origin_for(map);
  EXPECT_NEAR(std::remainder(map.min_x_m - origin.x_m, 0.15), 0, 1e-6);
  EXPECT_NEAR(origin.x_m, 548000, 0.15);
  expect_error(
      [&] { write_occupancy_grid(dir / "m.gz", map, {}, origin); },
      {"whole multiples of its cells", "548000.05,0.07", "--origin"});
  write_occupancy_grid(dir / "m.gz", map, {}, {origin.x_m, 0.07, 0});
  mrpt::maps::COccupancyGridMap2D grid;
  mrpt::io::CFileGZInputStream stream(dir / "m.gz");
  mrpt::serialization::archiveFrom(stream) >> grid;
  EXPECT_NEAR(grid.getXMin(), map.min_x_m - origin.x_m, 1e-3);
}

TEST(Formats, files_of_a_map_by_strips_are_those_of_the_whole)
{
  io::LayerStack map = small_terrain();
  map.cells_x = 4150;  // two pieces, as files are read
  map.cells_y = 300;
  map.resolution_m = 0.125;  // so that no number is rounded
  for (auto& layer : map.layers)
  {
    const std::vector<float> some = layer;
    layer.resize(4150U * 300U);
    for (std::size_t i = 0; i < layer.size(); ++i)  // on both sides of the border of the pieces
      layer[i] = some[i % 4150 < 4000 ? 59 : i % 2391];
  }
  const ScratchDir dir;
  io::write_geotiff(dir / "map.tif", map);
  const io::GeotiffFile file(dir / "map.tif");
  const MapStrips whole(map), strips(file, map.names);
  int count = 0;
  strips.for_each([&](const Strip&) { ++count; });
  EXPECT_EQ(count, 2);
  const auto files = [&](const MapStrips& of)
  {
    write_mesh(dir / "fine.ply", of, 1'000'000);
    write_mesh(dir / "coarse.ply", of, 10'000);
    write_heightmap(dir / "height.png", of);
    write_octomap(dir / "tree.bt", of, 0.6);
    write_ros_map(dir / "map.yaml", of, RosMode::Trinary, {0, 0.5});
    write_ros_map(dir / "map.yaml", of, RosMode::Scale, {});
    write_grid_map(dir / "map.mcap", of, 1.5);
    std::vector<std::string> bytes;
    for (const char* name :
         {"fine.ply", "coarse.ply", "height.png", "tree.bt", "map.pgm", "map_scale.png",
          "map.mcap"})
      bytes.push_back(read_bytes(dir / name));
    return bytes;
  };
  EXPECT_TRUE(files(whole) == files(strips));
}

TEST(Formats, a_wide_map_has_strips_of_fewer_rows)
{
  io::LayerStack map;
  map.cells_x = 70'000;
  map.cells_y = 250;
  map.resolution_m = 0.125;
  map.names = {"traversability"};
  map.layers = {std::vector<float>(17'500'000, 1.0F)};
  const ScratchDir dir;
  io::write_geotiff(dir / "map.tif", map);
  const io::GeotiffFile file(dir / "map.tif");
  const MapStrips strips(file, map.names);
  std::size_t cells = 0;
  strips.for_each(
      [&](const Strip& strip)
      {
        cells += strip.map.layers[0].size();
        EXPECT_LE(strip.map.layers[0].size(), std::size_t{16} << 20);
      });
  EXPECT_EQ(cells, 17'500'000U);
}

TEST(Formats, a_layer_that_is_missing_is_named)
{
  io::LayerStack map = small_terrain();
  map.names[0] = "other";
  mrpt::maps::COccupancyGridMap2D grid;
  expect_error([&] { to_occupancy_grid(map, 0, grid); }, {"'traversability'"});
}

TEST(Formats, the_heightmap_has_2_to_the_n_and_1_pixels_and_tells_where_it_lies)
{
  const ScratchDir dir;
  const HeightmapPlace p = write_heightmap(dir / "h.png", small_terrain());
  EXPECT_EQ(p.side_pixels, 65);
  EXPECT_NEAR(p.size_m, 6.4, 1e-9);
  EXPECT_NEAR(p.lowest_m, 1.0, 1e-6);
  EXPECT_NEAR(p.height_m, 0.49, 1e-6);
  EXPECT_NEAR(p.center_x_m, 1.5, 0.051) << "of the known cells";
  EXPECT_NEAR(p.center_y_m, 4.0, 0.051);
  EXPECT_SAYS(read_bytes(dir / "h.json"), "\"side_pixels\": 65");
}

TEST(Formats, a_mesh_has_no_more_faces_than_are_wanted)
{
  const ScratchDir dir;
  const auto faces = [&](std::size_t most)
  {
    write_mesh(dir / "m.ply", small_terrain(), most);
    const std::string text = read_bytes(dir / "m.ply");
    return std::stoul(text.substr(text.find("element face ") + 13));
  };
  EXPECT_EQ(faces(1000000), kSmallTerrainFaces);
  EXPECT_LE(faces(1100), 1100U);
  EXPECT_GT(faces(1100), 500U);
}

TEST(Formats, a_page_gets_coarser_until_it_is_small_enough)
{
  io::LayerStack map = small_terrain();  // larger, with heights that no picture packs
  map.cells_x = map.cells_y = 512;
  for (auto& layer : map.layers) layer.assign(std::size_t{1} << 18, 1.0F);
  for (std::size_t i = 0; i < map.layers[1].size(); ++i)
    map.layers[1][i] =
        static_cast<float>((static_cast<std::uint32_t>(i * i) * 2654435761U) >> 16) * 0.001F;
  const ScratchDir dir;
  PageOptions options;
  options.title = "<!--<script> /* data */ </script> & b";
  write_page(dir / "fine.html", page_map(map), options);
  options.max_bytes = std::size_t{1} << 19;
  write_page(dir / "small.html", page_map(map), options);
  const std::string fine = read_bytes(dir / "fine.html"), small = read_bytes(dir / "small.html");
  EXPECT_GT(fine.size(), options.max_bytes);
  EXPECT_LE(small.size(), options.max_bytes);
  EXPECT_SAYS(fine, "\"resolution_m\":0.1,");
  EXPECT_SAYS(small, "\"resolution_m\":0.2,");
  EXPECT_SAYS_NOT(fine, "<!--<script") << "would begin a script";
  EXPECT_SAYS(fine, "\"title\":\"\\u003c!--\\u003cscript> /* data */");
  EXPECT_SAYS(fine, "script-src 'nonce-");
}

TEST(Formats, no_script_of_a_stranger_is_the_name_of_a_layer)
{
  const std::string script = "<img src=x onerror=alert()>";
  EXPECT_EQ(
      channel_bands({"label", "label_standing", "state", script, script + "_standing"}),
      (std::vector<std::string>{"label", "label_standing"}));
}

TEST(Formats, changes_of_another_size_of_cells_are_refused)
{
  const ScratchDir dir;
  io::LayerStack changes = small_terrain();
  changes.names = {"kind", "change_m", "a", "b"};
  changes.resolution_m = 0.2;
  const io::LayerStack map = small_terrain();
  PageMap shown = page_map(changes);
  PageOptions options;
  options.changes = &shown;
  EXPECT_THROW(write_page(dir / "p.html", page_map(map), options), std::runtime_error);
  changes.resolution_m = 0.1;
  shown = page_map(changes);
  EXPECT_NO_THROW(write_page(dir / "p.html", page_map(map), options));
}
}  // namespace
