#pragma once
#include "oblique.h"

#include <talus/baselines/sequence.h>

#include <opencv2/core.hpp>

#include <vector>

namespace talus::pictures
{
/** The points of some scans of a drive, all coloured by what the map says of them after the last
 * one, above what the colours mean. */
cv::Mat draw_labelled_scans(
    const std::vector<baselines::ScanFrame>& frames, std::size_t every, const Camera& camera);

}  // namespace talus::pictures
