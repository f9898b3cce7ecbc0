#pragma once
#include <string>
#include <vector>

#include "bag_file.h"

namespace talus::import
{
/** What a topic of a bag is read for. */
enum class BagRole
{
  None,
  Cloud,
  Tf,
  TfStatic,
  Odometry,
  Pose,  //!< with or without covariance
  Path
};

/** By its name, type and encoding. */
BagRole role_of(const BagTopic& topic);

/** One role a topic. `wanted` (all, where none is named): the clouds of these topics, and the poses
 * of one of them. Throws std::runtime_error that names `path` where there are no such clouds, and
 * lists what there is. */
std::vector<BagRole> roles_of(
    const std::vector<BagTopic>& topics, const std::vector<std::string>& wanted,
    const std::string& path);

/** What is wrong with so many topics, whose names, types and encodings have so many bytes: a small
 * bag can unpack to more than memory holds. Empty: nothing. */
std::string too_long_names(std::size_t bytes, std::size_t topics);

}  // namespace talus::import
