#pragma once
#include <talus/point_labels.h>

#include <array>
#include <cstdint>

namespace talus::io
{
/** The colour, red, green, blue, of a score or traversability in all pictures: from dark orange at
 * 0, blocked, over a pale middle to blue at 1, free. Also those who see no red or no green tell
 * both ends, by hue and by lightness. NaN, not judged: mauve. Values beyond count as the ends. */
std::array<std::uint8_t, 3> score_colour(float score);

/** The colour, red, green, blue, of the points of a label in pictures and tables. Also those who
 * see no red or no green tell them apart. */
std::array<std::uint8_t, 3> label_colour(PointLabel label);

}  // namespace talus::io
