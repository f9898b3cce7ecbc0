#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <iostream>

// Runs when the library is loaded, and draws the classes out of the static library. A program that
// links talus itself has them already: its copy stays.
MRPT_INITIALIZER(register_talus_plugin)
{
  if (!mrpt::rtti::findRegisteredClass("talus::CDualElevationMap", false))
    talus::register_mrpt_classes();
  else
    std::cerr << "[libtalus-mrpt.so] the classes of talus are known already (another copy of this "
                 "library, or a program that links talus): that copy stays"
              << std::endl;
}
