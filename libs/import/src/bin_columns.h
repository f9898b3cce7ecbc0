#pragma once
#include <cstddef>
#include <string_view>

namespace talus::import
{
/** How many floats a point of a .bin file really has, where its numbers tell, and not `expected`;
 * else `expected`. Read with a wrong count, each column is a mixture of all of them: coordinates,
 * intensities, whole numbers of beams. */
std::size_t floats_a_point(std::string_view bytes, std::size_t expected);

}  // namespace talus::import
