#pragma once
#include <mrpt/math/TPose2D.h>
#include <talus/nav/heading_cost.h>

namespace talus
{
using nav::Footprint, nav::HeadingCost;

/** nav::heading_cost() at a pose of MRPT. */
inline HeadingCost heading_cost(
    const MapView& map, const Footprint& robot, const mrpt::math::TPose2D& T_map_base)
{
  return nav::heading_cost(map, robot, {T_map_base.x, T_map_base.y, T_map_base.phi});
}

}  // namespace talus
