// Links MRPT only: everything of talus comes out of the plugin.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/system/os.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "comma_locale.h"
#include "message_of.h"

namespace fs = std::filesystem;
using mrpt::maps::CMultiMetricMap;
using talus::test::CommaLocale;

namespace
{
const std::string kClass = "talus::CDualElevationMap";
const std::string kIni = TALUS_SOURCE_DIR "/datasets/configs/observations2map.ini";

bool class_is_known() { return mrpt::rtti::findRegisteredClass(kClass, false) != nullptr; }

CMultiMetricMap maps_from_shipped_ini()
{
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFile(kIni), "MappingApplication");
  return CMultiMetricMap(definitions);
}

int terrain_maps(const CMultiMetricMap& maps)
{
  int count = 0;
  for (const auto& m : maps.maps) count += m->GetRuntimeClass()->className == kClass;
  return count;
}

mrpt::obs::CObservationPointCloud square_of_floor()
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int x = -20; x < 20; x++)
    for (int y = -20; y < 20; y++) points->insertPoint(0.11F * x, 0.11F * y, -0.5F);
  mrpt::obs::CObservationPointCloud obs;
  obs.pointcloud = points;
  return obs;
}
}  // namespace

TEST(Plugin, loaded_by_dlopen_twice_it_registers_the_class_once)
{
  ASSERT_FALSE(class_is_known());
  for (int i = 0; i < 2; i++)
  {
    void* library = dlopen(TALUS_PLUGIN, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library, nullptr) << dlerror();
    EXPECT_TRUE(class_is_known());
    dlclose(library);
  }
  EXPECT_TRUE(class_is_known());
  EXPECT_EQ(terrain_maps(maps_from_shipped_ini()), 1);
}

TEST(Plugin, loaded_by_mrpt_twice_it_gives_a_map_that_works_in_a_multi_map)
{
  for (int i = 0; i < 2; i++)
  {
    std::string errors;
    ASSERT_TRUE(mrpt::system::loadPluginModules(TALUS_PLUGIN, errors)) << errors;
  }
  auto maps = maps_from_shipped_ini();
  ASSERT_EQ(maps.maps.size(), 2U);
  ASSERT_EQ(terrain_maps(maps), 1);
  EXPECT_TRUE(maps.insertObservation(square_of_floor(), mrpt::poses::CPose3D(0, 0, 0.5, 0, 0, 0)));
  const CMultiMetricMap copy(maps);
  EXPECT_EQ(terrain_maps(copy), 1);
  for (const auto& m : copy.maps) EXPECT_FALSE(m->isEmpty()) << m->GetRuntimeClass()->className;
}

TEST_F(CommaLocale, an_ini_file_gives_the_map_of_the_plugin_its_numbers)
{
  std::string errors;
  ASSERT_TRUE(mrpt::system::loadPluginModules(TALUS_PLUGIN, errors)) << errors;
  const fs::path ini =
      fs::temp_directory_path() / ("talus_comma_" + std::to_string(getpid()) + ".ini");
  std::ofstream(ini) << "[Maps]\nterrain_count = 1\n"
                        "[Maps_terrain_00_creationOpts]\nresolution = 0.10\nwindow = 6.5\n"
                        "[Maps_terrain_00_insertOpts]\nmin_height_m = -1.25\n"
                        "[Maps_terrain_00_likelihoodOpts]\nsigma_m = 0.25\n"
                        "[Maps_terrain_00_renderOpts]\nmaxCells = 12345\n";
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFile(ini.string()), "Maps");
  fs::remove(ini);
  std::stringstream text;
  definitions.dumpToTextStream(text);
  for (const std::string line :
       {"resolution = 0.1 m", "window     = 6.5 m", "= -1.25 m", "0.25", "12345"})
    EXPECT_TRUE(has(text.str(), line)) << line << "\n" << text.str();
  const CMultiMetricMap maps(definitions);
  ASSERT_EQ(terrain_maps(maps), 1);
  EXPECT_EQ(maps.maps.front()->asString(), "talus::CDualElevationMap, 6.5 x 6.5 m at 0.1 m, empty");
}
