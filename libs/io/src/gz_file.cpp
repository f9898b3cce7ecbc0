#include <talus/io/gz_file.h>

#include <fstream>
#include <stdexcept>

#include "packed_file.h"

namespace talus::io
{
void require_complete_gz(const std::string& path, const std::string& name)
{
  const std::string shown = name.empty() ? path : name;
  std::string reason = "not even its header";
  char magic[2] = {};  // a file without it is read as it is
  if (std::ifstream(path, std::ios::binary).read(magic, 2) && magic[0] == '\x1f' &&
      magic[1] == '\x8b')
    try
    {
      verified_size(path);
      return;
    }
    catch (const std::exception&)
    {
      reason = "not to its end";
    }
  throw std::runtime_error(
      shown + ": could not be written, " + reason + "; is the disk full? Free some space there");
}

}  // namespace talus::io
