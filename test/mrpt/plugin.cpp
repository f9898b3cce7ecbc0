// Links MRPT only: everything of talus comes out of the plugin.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/system/os.h>

using mrpt::maps::CMultiMetricMap;

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
