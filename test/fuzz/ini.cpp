// The sections of a map in an INI file, as the class reads them for a CMultiMetricMap: what is read
// makes a map, and what is saved of it is read again.
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/parameters_ini.h>

#include <sstream>

#include "fuzz.h"

namespace
{
using namespace talus;

void use(const CDualElevationMap::TMapDefinition& read)
{
  std::ostringstream text;
  read.dumpToTextStream(text);
  read.insertionOpts.validate();
  mrpt::config::CConfigFileMemory saved;
  read.insertionOpts.saveToConfigFile(saved, "M_insertOpts");
  read.likelihoodOpts.saveToConfigFile(saved, "M_likelihoodOpts");
  read.renderOpts.saveToConfigFile(saved, "M_renderOpts");
  CDualElevationMap::TMapDefinition again;
  again.loadFromConfigFile(saved, "M");
  for (const auto& info : parameter_table())
    fuzz::require(
        is_same_value(info, again.insertionOpts, read.insertionOpts), "what is saved is read");
}
}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const fuzz::InputFile file(data, size, ".ini");
  CDualElevationMap::TMapDefinition definition;
  const bool taken = fuzz::is_read(
      [&]
      {
        const mrpt::config::CConfigFile config(file.path());
        definition.loadFromConfigFile(config, "M_terrain_00");
      });
  if (taken) use(definition);
  return 0;
}
