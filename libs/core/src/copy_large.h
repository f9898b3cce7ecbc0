#pragma once
#include <cstddef>

namespace talus
{
/** memcpy; large blocks by several threads where there is oneTBB, since one core does not keep up
 * with the bus to a device. */
void copy_large(void* to, const void* from, std::size_t bytes);

}  // namespace talus
