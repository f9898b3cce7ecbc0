// Maps that keep the whole: what left the window is still there, asked for, saved and read.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <cmath>

#include "message_of.h"
#include "streams.h"

using namespace talus;
using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;
using talus_test::bytes_of;
using talus_test::read;

namespace
{
constexpr double kWindow_m = 6;

Parameters small_window()
{
  Parameters p;
  p.window_m = kWindow_m;
  p.resolution_m = 0.1;
  return p;
}

/** Level ground with a box of 0.5 m, 2 m to the left of the robot at x = 0. */
mrpt::obs::CObservationPointCloud scan_at(double x_m)
{
  mrpt::obs::CObservationPointCloud obs;
  obs.sensorLabel = "lidar";
  obs.timestamp = mrpt::Clock::fromDouble(1000 + x_m);
  obs.sensorPose = CPose3D(0, 0, 1, 0, 0, 0);
  auto points = CSimplePointsMap::Create();
  for (double x = -3; x < 3; x += 0.05)
    for (double y = -3; y < 3; y += 0.05)
    {
      const bool box = std::abs(x_m + x) < 0.3 && std::abs(y - 2) < 0.3;
      points->insertPoint(
          static_cast<float>(x), static_cast<float>(y), static_cast<float>(box ? -0.5 : -1));
    }
  obs.pointcloud = points;
  return obs;
}

void drive(CDualElevationMap& map, double from_m, double to_m)
{
  const double step_m = from_m < to_m ? 0.5 : -0.5;
  for (int i = 0; i <= std::lround(std::abs(to_m - from_m) / 0.5); i++)
  {
    const double x_m = from_m + i * step_m;
    ASSERT_TRUE(map.insertObservation(scan_at(x_m), CPose3D(x_m, 0, 0, 0, 0, 0)));
  }
}

CDualElevationMap keeper() { return CDualElevationMap(small_window(), Backend::Cpu, 1, true); }

/** Of the place of a point; NaN: unknown, or not in the map. */
float at(const CDualElevationMap& map, Layer layer, double x_m, double y_m)
{
  return map.view().at(layer, x_m, y_m);
}
}  // namespace

TEST(WholeMap, answers_everywhere_the_robot_was)
{
  CDualElevationMap whole = keeper(), window(small_window(), Backend::Cpu);
  drive(whole, 0, 20);
  drive(window, 0, 20);
  EXPECT_TRUE(std::isnan(at(window, Layer::GroundElevation, 0.05, 0.05)));
  EXPECT_NEAR(at(whole, Layer::GroundElevation, 0.05, 0.05), 0, 0.02);
  EXPECT_NEAR(at(whole, Layer::GroundElevation, 20.05, 0.05), 0, 0.02);
  EXPECT_NEAR(at(whole, Layer::Elevation, 0.05, 2.05), 0.5, 0.02);
  EXPECT_EQ(at(whole, Layer::Traversability, 0.05, 2.25), 0);
  EXPECT_GT(at(whole, Layer::Traversability, 0.05, 0.05), 0.5);

  const auto box = whole.boundingBox();
  EXPECT_LT(box.min.x, -2.8F);
  EXPECT_GT(box.max.x, 22.8F);
  EXPECT_GT(whole.getAsSimplePointsMap()->size(), 2 * window.getAsSimplePointsMap()->size());

  mrpt::maps::COccupancyGridMap2D grid;
  whole.getAsOccupancyGrid(grid);
  EXPECT_LT(grid.getPos(0.05F, 2.25F), 0.2F);
  EXPECT_GT(grid.getPos(0.05F, 0.05F), 0.6F);

  const auto scan = scan_at(0);
  const CPose3D true_pose(0, 0, 0, 0, 0, 0), higher(0, 0, 0.5, 0, 0, 0);
  EXPECT_GT(
      whole.computeObservationLikelihood(scan, true_pose),
      whole.computeObservationLikelihood(scan, higher) + 100);
}

TEST(WholeMap, gives_back_what_it_knew_where_the_robot_returns)
{
  CDualElevationMap map = keeper();
  drive(map, 0, 20);
  mrpt::obs::CObservationPointCloud little = scan_at(0);
  little.pointcloud = CSimplePointsMap::Create();
  for (int i = 0; i < 100; i++)  // a strip of the floor ahead
    little.pointcloud->insertPoint(1 + 0.01F * static_cast<float>(i), 0, -1);
  ASSERT_TRUE(map.insertObservation(little, CPose3D(0, 0, 0, 0, 0, 0)));
  ASSERT_TRUE(map.insertObservation(little, CPose3D(0, 0, 0, 0, 0, 0)));
  const Window w = map.mapper().window();
  const auto middle = static_cast<std::size_t>((w.cells / 2 + 20) * w.cells + w.cells / 2);
  EXPECT_NEAR(map.mapper().layer(Layer::Elevation)[middle], 0.5, 0.02);  // the box
}

TEST(WholeMap, is_made_from_an_ini_file)
{
  register_mrpt_classes();
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  testing::internal::CaptureStderr();
  definitions.loadFromConfigFile(
      mrpt::config::CConfigFileMemory(std::string(
          "[Maps]\nterrain_count = 1\n[Maps_terrain_00_creationOpts]\nwindow = 6\nbackend = "
          "cpu\nkeep_whole = true\n")),
      "Maps");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  const mrpt::maps::CMultiMetricMap maps(definitions);
  const auto map = maps.mapByClass<CDualElevationMap>();
  ASSERT_TRUE(map);
  EXPECT_TRUE(map->keepsWhole());
  EXPECT_FALSE(CDualElevationMap().keepsWhole());
}

TEST(WholeMap, goes_through_a_stream_whole_and_goes_on_with_the_same_bits)
{
  CDualElevationMap map = keeper(), copy, assigned;
  drive(map, 0, 12);
  const auto bytes = bytes_of(map);
  read(bytes, copy);
  assigned = map;
  EXPECT_TRUE(copy.keepsWhole());
  EXPECT_EQ(bytes_of(copy), bytes);
  EXPECT_EQ(bytes_of(assigned), bytes);
  for (CDualElevationMap* m : {&map, &copy, &assigned}) drive(*m, 12, 2);
  EXPECT_EQ(bytes_of(copy), bytes_of(map));
  EXPECT_EQ(bytes_of(assigned), bytes_of(map));
}

TEST(WholeMap, that_is_damaged_in_a_stream_is_refused_and_changes_nothing)
{
  CDualElevationMap map = keeper(), other = keeper();
  drive(map, 0, 4);
  drive(other, 0, 1);
  const auto bytes = bytes_of(map), before = bytes_of(other);
  int refused = 0;
  for (std::size_t i = 100; i < bytes.size(); i += bytes.size() / 97)
  {
    auto damaged = bytes;
    damaged[i] ^= 0xA5;
    CDualElevationMap m = other;
    refused += message_of([&] { read(damaged, m); }) != "no error";
    damaged.resize(i);
    EXPECT_THROW(read(damaged, other), std::exception);
    EXPECT_EQ(bytes_of(other), before);
  }
  EXPECT_GT(refused, 15) << "evidence may have any bytes, all else is checked";
}

TEST(WholeMap, writes_its_site_and_goes_on_with_it)
{
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "talus_whole_map";
  fs::remove_all(folder);
  fs::create_directories(folder);
  CDualElevationMap map = keeper(), next = keeper();
  drive(map, 0, 12);
  map.saveMetricMapRepresentationToFile((folder / "drive").string());
  for (const char* name : {"drive.tif", "drive.png", "drive_site.tif", "drive_site.png"})
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  next.loadSite((folder / "drive_site.tif").string());
  EXPECT_FALSE(next.isEmpty());
  EXPECT_NEAR(at(next, Layer::Elevation, 0.05, 2.05), 0.5, 0.02);
  drive(next, 12, 14);
  EXPECT_NEAR(at(next, Layer::Elevation, 0.05, 2.05), 0.5, 0.02);
  EXPECT_NEAR(at(next, Layer::GroundElevation, 16.05, 0.05), 0, 0.02);

  CDualElevationMap coarse(Parameters(), Backend::Cpu, 1, true), window(small_window());
  EXPECT_THROW(coarse.loadSite((folder / "drive_site.tif").string()), std::runtime_error);
  EXPECT_THROW(next.loadSite((folder / "drive_site.tif").string()), std::logic_error);
  EXPECT_THROW(window.loadSite((folder / "drive_site.tif").string()), std::logic_error);
  EXPECT_THROW(keeper().loadSite((folder / "none.tif").string()), std::runtime_error);
  fs::remove_all(folder);
}

TEST(WholeMap, of_another_resolution_begins_anew_and_of_another_window_goes_on)
{
  CDualElevationMap map = keeper();
  drive(map, 0, 12);
  map.insertionOptions.window_m = 8;
  drive(map, 12, 13);
  EXPECT_NEAR(at(map, Layer::GroundElevation, 0.05, 0.05), 0, 0.02);
  map.insertionOptions.resolution_m = 0.2;
  drive(map, 12, 13);
  EXPECT_TRUE(std::isnan(at(map, Layer::GroundElevation, 0.05, 0.05)));
  EXPECT_NEAR(at(map, Layer::GroundElevation, 13.05, 0.05), 0, 0.02);
  map.clear();
  EXPECT_TRUE(map.isEmpty());
}
