#include "lzf.h"

#include <algorithm>
#include <cstddef>

namespace talus::import
{
// A byte below 32: so many bytes and one more follow as they are. Else a piece of what was unpacked
// follows again: its length in the upper three bits (7: and the next byte) and two more, its
// distance in the lower five and the next byte, and one more.
bool unpack_lzf(std::string_view packed, std::size_t size, std::string& out)
{
  out.clear();
  out.reserve(size);
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(packed[at]); };
  for (std::size_t at = 0; at < packed.size();)
  {
    const std::size_t control = byte(at++);
    if (control < 32)
    {
      const std::size_t count = control + 1;
      if (count > packed.size() - at || count > size - out.size()) return false;
      out.append(packed.substr(at, count));
      at += count;
      continue;
    }
    std::size_t count = (control >> 5) + 2;
    const std::size_t more = control >= 7 * 32 ? 2 : 1;
    if (more > packed.size() - at) return false;
    if (more == 2) count += byte(at++);
    const std::size_t distance = ((control & 31) << 8) + byte(at++) + 1;
    if (distance > out.size() || count > size - out.size()) return false;
    for (std::size_t from = out.size() - distance; count > 0; --count) out.push_back(out[from++]);
  }
  return out.size() == size;
}

}  // namespace talus::import
