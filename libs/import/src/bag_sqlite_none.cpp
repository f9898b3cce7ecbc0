#include <stdexcept>

#include "bag_file.h"

namespace talus::import
{
std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path, bool)
{
  throw std::runtime_error(
      path +
      ": is a bag in SQLite, and this program was built without it: install "
      "libsqlite3-dev and build again.");
}

}  // namespace talus::import
