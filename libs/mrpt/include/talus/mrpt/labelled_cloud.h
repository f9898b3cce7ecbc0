#pragma once
#include <mrpt/maps/CPointsMap.h>
#include <talus/mrpt/observation_points.h>
#include <talus/point_labels.h>

#include <vector>

namespace talus
{
/** The points of an observation in the frame of their sensor, as a cloud with the number of each
 * one's label as its intensity: the one field of a point that clouds of all versions of MRPT write
 * into logs. Throws std::invalid_argument unless there is a label for each point. */
mrpt::maps::CPointsMap::Ptr labelled_cloud(
    const SensorPoints& points, const std::vector<PointLabel>& labels);

}  // namespace talus
