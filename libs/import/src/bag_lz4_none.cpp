#include <stdexcept>

#include "bag_unpack.h"

namespace talus::import
{
void unpack_lz4(std::string_view, std::size_t, bool, std::vector<char>&)
{
  throw std::runtime_error(
      "is packed with lz4, and this program was built without it: install liblz4-dev and build "
      "again");
}

}  // namespace talus::import
