#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/system/os.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <cstring>
#include <limits>
#include <stdexcept>

#include "message_of.h"
#include "room_for_maps.h"
#include "streams.h"

using mrpt::config::CConfigFileMemory;
using mrpt::maps::CMultiMetricMap;
using namespace talus_test;

namespace
{
constexpr double kQuarterTurn_rad = M_PI / 2;

void expect_same_bits(const CDualElevationMap& a, const CDualElevationMap& b)
{
  for (int i = 0; i < talus::kLayerCount; i++)
  {
    const auto& la = a.mapper().layer(static_cast<Layer>(i));
    const auto& lb = b.mapper().layer(static_cast<Layer>(i));
    ASSERT_EQ(la.size(), lb.size());
    EXPECT_EQ(std::memcmp(la.data(), lb.data(), la.size() * sizeof(float)), 0)
        << talus::kLayerTable[i].name;
  }
}

CMultiMetricMap map_from_ini(const std::string& text, const std::string& section = "Maps")
{
  talus::register_mrpt_classes();  // as a program does at its start
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFileMemory(text), section);
  return CMultiMetricMap(definitions);
}

/** What goes to stderr meanwhile. */
template <typename Function>
std::string told(Function&& f)
{
  testing::internal::CaptureStderr();
  f();
  return testing::internal::GetCapturedStderr();
}

int count_of(const std::string& text, const std::string& part)
{
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) count++;
  return count;
}

/** As a program keeps options that it does not write to a file. */
template <typename Options>
void expect_survives(const Options& options)
{
  CConfigFileMemory memory;
  options.saveToConfigFile(memory, "Section");
  Options loaded;
  std::stringstream before, after;
  loaded.dumpToTextStream(before);
  loaded.loadFromConfigFile(memory, "Section");
  loaded.dumpToTextStream(after);
  std::stringstream expected;
  options.dumpToTextStream(expected);
  EXPECT_EQ(after.str(), expected.str());
  EXPECT_NE(after.str(), before.str());
}

const std::string kIni =
    "[Maps]\nterrain_count = 1\npointsMap_count = 1\n"
    "[Maps_terrain_00_creationOpts]\nresolution = 0.1\nwindow = 6\nbackend = cpu\nthreads = 2\n"
    "enableSaveAs3DObject = false\n"
    "[Maps_terrain_00_insertOpts]\nmin_height_m = -3\nmax_height_m = 3\n"
    "[Maps_terrain_00_likelihoodOpts]\nsigma_m = 0.08\ndecimation = 3\n"
    "[Maps_terrain_00_renderOpts]\nshowElevation = false\ncolormap = cmHOT\n";
}  // namespace

TEST(DualElevationMap, is_created_from_an_ini_file_beside_another_map)
{
  const CMultiMetricMap maps = map_from_ini(kIni);
  ASSERT_EQ(maps.maps.size(), 2U);
  const auto map = maps.mapByClass<CDualElevationMap>();
  ASSERT_TRUE(map);
  EXPECT_TRUE(maps.mapByClass<CSimplePointsMap>());
  EXPECT_TRUE(map->isEmpty());
  EXPECT_EQ(map->mapper().window().cells, 60);
  EXPECT_EQ(map->mapper().parameters().min_height_m, -3);
  EXPECT_EQ(map->backend(), talus::Backend::Cpu);
  EXPECT_EQ(map->threads(), 2);
  EXPECT_FALSE(map->genericMapParams.enableSaveAs3DObject);
  EXPECT_EQ(map->likelihoodOptions.sigma_m, 0.08);
  EXPECT_EQ(map->likelihoodOptions.decimation, 3);
  EXPECT_FALSE(map->renderOptions.showElevation);
  EXPECT_EQ(map->renderOptions.colormap, mrpt::img::cmHOT);
}

TEST(DualElevationMap, bad_values_of_an_ini_file_are_refused)
{
  for (const std::string bad :
       {"creationOpts]\nresolution = 0", "creationOpts]\nbackend = tpu",
        "creationOpts]\nthreads = -2", "insertOpts]\nfill_samples = best",
        "likelihoodOpts]\nsigma_m = 0", "likelihoodOpts]\noutlierRatio = 1",
        "likelihoodOpts]\ndecimation = 0", "renderOpts]\nmaxCells = 1"})
    EXPECT_THROW(
        map_from_ini("[Maps]\nterrain_count = 1\n[Maps_terrain_00_" + bad + "\n"), std::exception)
        << bad;
  EXPECT_THROW(CDualElevationMap(talus::Parameters{-1.0}), std::invalid_argument);
}

TEST(DualElevationMap, sections_with_the_number_of_no_map_and_their_lack_are_told_once)
{
  const auto told_of = [](const std::string& name, const std::string& sections)
  { return told([&] { map_from_ini("[" + name + "]\nterrain_count = " + sections, name); }); };
  // One number off, as in observations2map.ini with a section renamed.
  const std::string off = told_of(
      "Off",
      "1\n[Off_terrain_01_creationOpts]\nresolution = 0.1\n[Off_terrain_00_insertOpts]\n"
      "clearance_m = 0.7\n");
  EXPECT_EQ(count_of(off, "no section [Off_terrain_00_creationOpts]"), 1) << off;
  EXPECT_EQ(count_of(off, "section [Off_terrain_01_creationOpts] is not read"), 1) << off;
  EXPECT_TRUE(has(off, "terrain_count = 1"));
  const std::string bare = told_of("Bare", "1\n");
  EXPECT_EQ(count_of(bare, "no section"), 1) << bare;
  EXPECT_EQ(count_of(bare, "[Bare_terrain_00_creationOpts]"), 1) << bare;
  EXPECT_EQ(
      told_of(
          "Two",
          "2\n[Two_terrain_00_creationOpts]\nwindow = 6\n[Two_terrain_01_creationOpts]\n"
          "window = 5\n[Two_terrain_01_insertOpts]\nvoxel_m = 0\n[Two_pointsMap_07_insertOpts]\n"
          "x = 1\n"),
      "");
}

TEST(DualElevationMap, a_device_that_is_not_there_is_told_with_the_section_that_wants_it)
{
  const std::string ini =
      "[Maps]\nterrain_count = 1\n[Maps_terrain_00_creationOpts]\nbackend = cuda\n";
  const std::string message = message_of([&] { map_from_ini(ini); });
  if (message == "no error") GTEST_SKIP() << "a device answers";
  EXPECT_TRUE(has(message, "(in section Maps_terrain_00_creationOpts)"));
}

TEST(DualElevationMap, every_option_survives_saving_and_loading_in_memory)
{
  CDualElevationMap::TInsertionOptions insertion;
  insertion.clearance_m = 0.75;
  insertion.fill_samples = 7;
  insertion.body_boxes_m = {{-1, 1, -0.5, 0.5, 0, 1.1}, {1, 1.25, -0.3, 0.3, 0.2, 0.4}};
  CDualElevationMap::TLikelihoodOptions likelihood;
  likelihood.sigma_m = 0.2;
  likelihood.outlierRatio = 0.25;
  likelihood.decimation = 3;
  CDualElevationMap::TRenderOptions render;
  render.showGround = render.showElevation = render.colorByTraversability = false;
  render.colormap = mrpt::img::cmHOT;
  render.maxCells = 77;
  talus::ObstacleOptions obstacles;
  obstacles.blocked_at = 0.125;
  obstacles.range_m = 7.5;
  obstacles.risk_at = 0.3;
  obstacles.drops = talus::Drops::Slope;
  obstacles.unseen = talus::Unseen::Free;
  obstacles.boundary_only = !obstacles.boundary_only;
  const std::string text = told(
      [&]
      {
        expect_survives(insertion);
        expect_survives(likelihood);
        expect_survives(render);
        expect_survives(obstacles);
      });
  EXPECT_EQ(text, "") << "no key is unknown";
}

TEST(DualElevationMap, options_print_themselves_and_definitions_can_be_made_in_code)
{
  CDualElevationMap::TMapDefinition def;
  def.resolution = 0.2;
  def.insertionOpts.window_m = 4;
  def.backend = talus::Backend::Cpu;
  mrpt::maps::TSetOfMetricMapInitializers set;
  set.push_back(def);
  const CMultiMetricMap maps(set);
  EXPECT_EQ(maps.mapByClass<CDualElevationMap>()->mapper().window().cells, 20);
  std::stringstream text;
  set.dumpToTextStream(text);
  for (const char* part : {"resolution = 0.2", "slope_threshold_rad", "sigma_m", "colormap"})
    EXPECT_TRUE(has(text.str(), part)) << part << " in\n" << text.str();
}

TEST(DualElevationMap, programs_that_know_no_class_change_its_options_by_name)
{
  CDualElevationMap map;
  EXPECT_EQ(map.optionsByName().size(), 3U);
  const CConfigFileMemory ini(std::string("[L]\ndecimation = 5\n[I]\nclearance_m = 0.8\n"));
  map.optionsByName().at("likelihoodOptions")->loadFromConfigFile(ini, "L");
  map.optionsByName().at("insertionOptions")->loadFromConfigFile(ini, "I");
  EXPECT_EQ(map.likelihoodOptions.decimation, 5);
  EXPECT_EQ(map.insertionOptions.clearance_m, 0.8);
}

// Robot at (10, 4, 0.3) heading north. Sensor 0.5 m ahead and 0.8 m up, looking to the robot's
// left. A point 2 m ahead of the sensor and 0.6 m below it is 0.5 m ahead and 2 m left of the
// robot: (10 - 2, 4 + 0.5, 0.3 + 0.8 - 0.6).
TEST(DualElevationMap, points_are_placed_by_robot_pose_and_sensor_pose)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  const CPose3D T_map_base(10, 4, 0.3, kQuarterTurn_rad, 0, 0);
  const CPose3D T_base_sensor(0.5, 0, 0.8, kQuarterTurn_rad, 0, 0);
  const TPoint3D p_sensor(2.02, 0.03, -0.6);  // off the borders of cells: map (7.98, 4.47, 0.5)
  ASSERT_TRUE(map.insertObservation(cloud({p_sensor}, T_base_sensor), T_map_base));
  EXPECT_EQ(map.lastReport().points_accepted, 1U);
  EXPECT_NEAR(at(map, Layer::Elevation, 7.98, 4.47), 0.5, 1e-5);
  EXPECT_NEAR(at(map, Layer::GroundElevation, 7.98, 4.47), 0.5, 1e-5);
}

// The sensor looks straight down (pitch a quarter turn: its x axis points to the robot's -z, its z
// axis ahead). A point at (1, 0.02, 0.73) of the sensor lies 0.73 m ahead, 0.02 m left and 1 m
// below it.
TEST(DualElevationMap, points_of_a_sensor_that_looks_down_are_placed_ahead_and_below)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  const CPose3D T_base_sensor(0.2, 0, 1.5, 0, kQuarterTurn_rad, 0);
  ASSERT_TRUE(map.insertObservation(cloud({{1, 0.02, 0.73}}, T_base_sensor)));
  EXPECT_NEAR(at(map, Layer::Elevation, 0.93, 0.02), 0.5, 1e-5);
}

TEST(DualElevationMap, an_unsupported_observation_is_refused_and_leaves_the_map_empty)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  EXPECT_FALSE(map.insertObservation(mrpt::obs::CObservationOdometry()));
  EXPECT_TRUE(map.isEmpty());
  EXPECT_FALSE(map.canComputeObservationLikelihood(mrpt::obs::CObservationOdometry()));
  EXPECT_EQ(map.computeObservationLikelihood(mrpt::obs::CObservationOdometry(), CPose3D()), 0);
}

TEST(DualElevationMap, no_exception_leaves_an_insertion)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  EXPECT_NO_THROW(EXPECT_FALSE(map.insertObservation(CObservationPointCloud())));  // no cloud
  const CPose3D nowhere(std::numeric_limits<double>::quiet_NaN(), 0, 0, 0, 0, 0);
  EXPECT_NO_THROW(EXPECT_FALSE(map.insertObservation(cloud({{1, 0, -0.5}}, {}), nowhere)));
  EXPECT_TRUE(map.isEmpty());
}

TEST(DualElevationMap, a_level_2d_scan_is_told_once_and_a_tilted_or_nodding_one_is_fine)
{
  constexpr double kDegree = M_PI / 180;
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  const auto insert = [&](const CPose3D& T_base_sensor, const CPose3D& T_map_base, double nod_rad)
  {
    mrpt::obs::CObservation2DRangeScan scan;
    scan.resizeScanAndAssign(91, 2.0F, true);
    scan.sensorPose = T_base_sensor;
    scan.deltaPitch = nod_rad;
    return told([&] { EXPECT_TRUE(map.insertObservation(scan, T_map_base)); });
  };
  const CPose3D level(0.1, 0, 0.5, 1, 0, 0), down(0.1, 0, 0.5, 0, 20 * kDegree, 0);
  const CPose3D slope(0, 0, 0, 0, -20 * kDegree, 0);
  EXPECT_EQ(insert(down, {}, 0), "");
  EXPECT_EQ(insert(level, slope, 0), "");
  EXPECT_EQ(insert(level, {}, 20 * kDegree), "");
  EXPECT_TRUE(has(insert(down, slope, 0), "level 2D scan shows no terrain"));
  EXPECT_EQ(insert(CPose3D(0, 0, 0.5, 0, 4 * kDegree, 0), {}, 0), "") << "told already";
}

TEST(DualElevationMap, insertion_can_be_disabled_as_in_any_mrpt_map)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  map.genericMapParams.enableObservationInsertion = false;
  EXPECT_FALSE(map.insertObservation(scan_of_room({}), CPose3D()));
  EXPECT_TRUE(map.isEmpty());
}

TEST(DualElevationMap, both_surfaces_of_a_room_are_where_they_are)
{
  const auto map = map_of_room();
  EXPECT_FALSE(map.isEmpty());
  EXPECT_NEAR(at(map, Layer::GroundElevation, -0.5, -0.5), 0, 0.01);
  EXPECT_NEAR(at(map, Layer::Elevation, 1.3, 0.1), 0.45, 0.01);
  EXPECT_NEAR(at(map, Layer::Traversability, -1.5, -1.5), 1, 0.05);
  EXPECT_TRUE(has(map.asString(), "6 x 6 m at 0.05 m"));
}

TEST(DualElevationMap, clear_empties_it_and_the_next_scan_starts_anew)
{
  auto map = map_of_room(2);
  map.clear();
  EXPECT_TRUE(map.isEmpty());
  map.insertObservation(scan_of_room({}), CPose3D());
  expect_same_bits(map, map_of_room(1));
}

TEST(DualElevationMap, a_serialized_map_goes_on_with_the_same_bits)
{
  auto map = map_of_room();
  map.likelihoodOptions.sigma_m = 0.07;
  map.renderOptions.maxCells = 77;
  map.genericMapParams.enableObservationLikelihood = false;
  auto copy = read<CDualElevationMap>(bytes_of(map));
  expect_same_bits(copy, map);
  EXPECT_EQ(copy.likelihoodOptions.sigma_m, 0.07);
  EXPECT_EQ(copy.renderOptions.maxCells, 77);
  EXPECT_FALSE(copy.genericMapParams.enableObservationLikelihood);
  for (const auto& info : talus::parameter_table())
    EXPECT_TRUE(talus::is_same_value(info, copy.insertionOptions, map.insertionOptions))
        << info.name;
  for (int i = 1; i < 5; i++)
  {
    const CPose3D pose(0.2 * i, 0.1 * i, 0.01 * i, 0.3, 0.02, 0);
    map.insertObservation(scan_of_room(pose), pose);
    copy.insertObservation(scan_of_room(pose), pose);
    expect_same_bits(copy, map);
  }
}

TEST(DualElevationMap, a_copy_is_independent_and_the_copy_of_an_empty_map_is_empty)
{
  auto map = map_of_room(1);
  const CDualElevationMap copy(map);
  map.clear();
  EXPECT_FALSE(copy.isEmpty());
  expect_same_bits(copy, map_of_room(1));
  const CDualElevationMap empty(map);
  EXPECT_TRUE(empty.isEmpty());
}

TEST(DualElevationMap, a_multi_map_that_holds_one_can_be_copied)
{
  auto maps = map_from_ini(kIni);
  EXPECT_TRUE(CMultiMetricMap(maps).mapByClass<CDualElevationMap>()->isEmpty());
  EXPECT_TRUE(maps.insertObservation(scan_of_room({}), CPose3D()));
  const CMultiMetricMap copy(maps);
  ASSERT_EQ(copy.maps.size(), 2U);
  const auto a = maps.mapByClass<CDualElevationMap>();
  const auto b = copy.mapByClass<CDualElevationMap>();
  ASSERT_TRUE(b);
  EXPECT_NE(a, b);
  EXPECT_EQ(b->threads(), 2);
  expect_same_bits(*a, *b);
}

TEST(DualElevationMap, programs_that_make_maps_of_any_class_save_and_load_it)
{
  // As sm2mm of mp2p_icp does: its generator turns YAML into sections, its .mm is named layers.
  for (const std::string name : {"talus::CDualElevationMap", "terrain"})
  {
    CConfigFileMemory ini;
    ini.write("map", name + "_count", std::string("1"));
    ini.write("map_" + name + "_00_creationOpts", "resolution", std::string("0.1"));
    ini.write("map_" + name + "_00_creationOpts", "backend", std::string("cpu"));
    ini.write("map_" + name + "_00_insertOpts", "clearance_m", std::string("0.7"));
    mrpt::maps::TSetOfMetricMapInitializers definitions;
    EXPECT_EQ(told([&] { definitions.loadFromConfigFile(ini, "map"); }), "");
    CMultiMetricMap maps;
    maps.setListOfMaps(definitions);
    ASSERT_EQ(maps.maps.size(), 1U);
    const mrpt::maps::CMetricMap::Ptr layer = maps.maps.at(0);
    EXPECT_TRUE(layer->insertObservation(scan_of_room({}), CPose3D(0.2, 0, 0, 0.1, 0, 0)));
    mrpt::io::CMemoryStream file;
    auto archive = mrpt::serialization::archiveFrom(file);
    archive << std::string("terrain") << *layer;
    file.Seek(0);
    std::string label;
    archive >> label;
    const auto loaded = std::dynamic_pointer_cast<CDualElevationMap>(archive.ReadObject());
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->insertionOptions.clearance_m, 0.7);
    expect_same_bits(*loaded, dynamic_cast<const CDualElevationMap&>(*layer));
  }
}

TEST(DualElevationMap, a_cloud_that_nobody_saw_is_told_once_and_a_scan_is_fine)
{
  CDualElevationMap map(small_window(), talus::Backend::Cpu);
  const auto insert = [&](const CPose3D& T_base_sensor, const char* label)
  {
    auto obs = cloud({{1, 0, 0}}, T_base_sensor);
    obs.sensorLabel = label;
    return told([&] { EXPECT_TRUE(map.insertObservation(obs, CPose3D())); });
  };
  EXPECT_EQ(insert({}, "lidar"), "");
  EXPECT_EQ(insert(CPose3D(0, 0, 0.7, 0, 0, 0), ""), "");
  EXPECT_TRUE(has(insert({}, ""), "no viewpoint"));
  EXPECT_EQ(insert({}, ""), "") << "told already";
}

TEST(DualElevationMap, the_plugin_may_be_loaded_into_a_program_that_has_the_class)
{
  for (int i = 0; i < 2; i++)
  {
    std::string errors;
    ASSERT_TRUE(mrpt::system::loadPluginModule(TALUS_PLUGIN, errors)) << errors;
    auto maps = map_from_ini(kIni);
    ASSERT_EQ(maps.countMapsByClass<CDualElevationMap>(), 1U) << "a map of this program's class";
    EXPECT_TRUE(maps.insertObservation(scan_of_room({}), CPose3D()));
    const CMultiMetricMap copy(maps);
    EXPECT_EQ(copy.countMapsByClass<CDualElevationMap>(), 1U);
  }
}

TEST(DualElevationMap, changed_options_count_from_the_next_insertion_on)
{
  auto map = map_of_room(2);
  map.mapper().set_output_layers({Layer::State});
  map.insertionOptions.step_threshold_m = 0.5;
  map.insertObservation(scan_of_room({}), CPose3D());
  EXPECT_EQ(map.mapper().parameters().step_threshold_m, 0.5);
  EXPECT_FALSE(std::isnan(at(map, Layer::Elevation, 1.3, 0.1)));
  map.insertionOptions.resolution_m = 0.1;
  map.insertObservation(scan_of_room({}), CPose3D());
  EXPECT_EQ(map.mapper().window().cells, 60);
  EXPECT_EQ(map.mapper().output_layers(), std::vector<Layer>{Layer::State});
}
