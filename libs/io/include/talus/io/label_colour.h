#pragma once
#include <talus/point_labels.h>

#include <array>
#include <cstdint>

namespace talus::io
{
/** The colour, red, green, blue, of the points of a label in pictures and tables. Also those who
 * see no red or no green tell them apart. */
std::array<std::uint8_t, 3> label_colour(PointLabel label);

}  // namespace talus::io
