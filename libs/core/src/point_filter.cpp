#include <talus/point_filter.h>
#include "config.h"
#include "kernels/1_accept.h"

namespace talus
{
PointFilter::PointFilter(const Parameters& p)
    : config_(std::make_unique<const kernels::Config>(make_config(p)))
{
}
PointFilter::~PointFilter() = default;

bool PointFilter::accepts(float x_m, float y_m, float z_m) const
{
  return kernels::accept({x_m, y_m, z_m}, *config_).code == kernels::kAccepted;
}

}  // namespace talus
