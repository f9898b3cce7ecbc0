#pragma once
#include <talus/parameters.h>
#include "kernels/config.h"

namespace talus
{
/** talus::Parameters as the kernels want them. */
kernels::Config make_config(const Parameters& p);

}  // namespace talus
