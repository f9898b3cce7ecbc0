#pragma once
#include <talus/parameters.h>
#include "kernels/config.h"

namespace talus
{
/** talus::Parameters as the kernels need them. */
struct MapConfig
{
  kernels::Config config;
  kernels::Body body;
};
MapConfig make_config(const Parameters& p);

}  // namespace talus
