#include <talus/io/atomic_file.h>

#include <stdexcept>

#include "packed_file.h"

namespace talus::io
{
void require_complete_packed(const std::string& path, const std::string& name)
{
  const std::string shown = name.empty() ? path : name;
  std::string reason = "not even its header";
  try
  {
    if (PackedFile(path).is_packed())
    {
      verified_size(path);
      return;
    }
  }
  catch (const std::exception&)
  {
    reason = "not to its end";
  }
  throw std::runtime_error(
      shown + ": could not be written, " + reason + "; is the disk full? Free some space there");
}

}  // namespace talus::io
