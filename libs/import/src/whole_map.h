#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
/** How many of the points of a cloud lie behind others, as seen from its origin (0..1): hardly any
 * of a scan. */
double hidden_share(const ScanFile& cloud);

/** A cloud that is no scan of one place, but what a SLAM program made of a drive. Where each point
 * says from where it was seen (vp_x, vp_y, vp_z), there is a scan from each of these places. Else
 * the cloud is cut into tiles, each with a sensor above its ground, so that no ray shows anything
 * but its end. Null: it is a scan. */
std::unique_ptr<ScanSource> open_whole_map(const Input& input, const SourceOptions& options);

}  // namespace talus::import
