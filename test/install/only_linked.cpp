// Links talus::mrpt and names nothing of it: its MRPT knows the map and its snapshots all the same.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/rtti/CObject.h>

#include <cstdio>
#include <string>

int main()
{
  const mrpt::config::CConfigFileMemory ini(
      std::string("[Maps]\nterrain_count = 1\n[Maps_terrain_00_creationOpts]\nwindow = 4\n"));
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(ini, "Maps");
  const mrpt::maps::CMultiMetricMap maps(definitions);
  const bool knows_snapshots =
      mrpt::rtti::findRegisteredClass("talus::CObservationTraversability", false) != nullptr;
  std::printf("%zu map, snapshots %s\n", maps.maps.size(), knows_snapshots ? "known" : "unknown");
  return maps.maps.size() == 1 && knows_snapshots ? 0 : 1;
}
