#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// Labels of points in the format of SemanticKITTI: 32 bits each, of which the lower 16 are it.

namespace talus::import
{
/** Names of values that such files have: as they are, and as the classes of
 * class_of_semantickitti(). */
constexpr const char *kLabels = "label", *kSemanticKitti = "semantickitti";

/** Those of a scan of `points`: `labels/000000.label` beside the folder of
 * `velodyne/000000.bin`, else `000000.label` beside it. Empty for a scan without points. Throws
 * std::runtime_error that names the file, also where it has another number of labels. */
std::vector<std::uint32_t> read_labels(const std::string& scan, std::size_t points);

/** The labels of SemanticKITTI in 16 classes, see doc/channels.md: what moves and what does not is
 * one, and so is what is alike to a robot. Others become 0. */
std::uint32_t class_of_semantickitti(std::uint32_t label);

/** How many floats a point of a .bin file really has, where its numbers show that, and not
 * `expected`; else `expected`. Read with a wrong count, each column is a mixture of all of them:
 * coordinates, intensities, whole numbers of beams. */
std::size_t floats_a_point(std::string_view bytes, std::size_t expected);

}  // namespace talus::import
