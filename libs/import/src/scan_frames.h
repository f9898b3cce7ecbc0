#pragma once
#include <talus/import/scan_source.h>

#include <array>

namespace talus::import
{
/** Whether the points are so far away that no sensor is at their origin. */
bool is_in_world(const ImportedScan& scan);

/** Points in the map frame become points in the frame of the sensor; in double precision. */
void bring_to_sensor(const mrpt::poses::CPose3D& T_map_sensor, ImportedScan& scan);

/** Of points in world coordinates the ground below their middle: in whole metres, its height in
 * centimetres, not turned. There is one point at least. */
mrpt::poses::CPose3D base_below(const ImportedScan& scan);

/** The median of how far the points are from a place in their frame; 0 without points. */
double median_range_m(const ImportedScan& scan, const std::array<double, 3>& from_m);

}  // namespace talus::import
