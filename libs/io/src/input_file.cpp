#include "input_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::io
{
void require_readable_file(const std::string& path, const std::string& kind)
{
  std::error_code error;
  const auto status = fs::status(path, error);
  if (error == std::errc::permission_denied)
    throw std::runtime_error(path + ": cannot be reached. Check the permissions of its folders.");
  if (!fs::exists(status))
    throw std::runtime_error(path + ": no such file. Check the path of the " + kind + ".");
  if (fs::is_directory(status))
    throw std::runtime_error(
        path + ": is a directory, not a " + kind + ". Name the file inside it.");
  if (!fs::is_regular_file(status))  // to open a pipe may wait for ever
    throw std::runtime_error(
        path + ": is a pipe or a device, and a " + kind +
        " is read more than once. Save it as a file first.");
  errno = 0;
  if (!std::ifstream(path, std::ios::binary))
    throw std::runtime_error(
        path + ": cannot be opened (" + std::strerror(errno) + "). Check its permissions.");
  if (fs::file_size(path, error) == 0)
    throw std::runtime_error(
        path + ": is empty (0 bytes), not a " + kind + ". Copy or record it again.");
}

}  // namespace talus::io
