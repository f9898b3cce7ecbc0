#include <talus/input_file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus
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
  if (!fs::is_regular_file(status))
    throw std::runtime_error(
        path + ": is a pipe or a device, not a " + kind + ". Save it as a file first.");
  errno = 0;
  if (!std::ifstream(path, std::ios::binary))
    throw std::runtime_error(
        path + ": cannot be opened (" + std::strerror(errno) + "). Check its permissions.");
  if (fs::file_size(path, error) == 0)
    throw std::runtime_error(
        path + ": is empty (0 bytes), not a " + kind + ". Copy or record it again.");
}

std::string read_input_file(
    const std::string& path, const std::string& kind, std::uint64_t most_bytes)
{
  require_readable_file(path, kind);
  const std::uint64_t size = fs::file_size(path);
  if (size > most_bytes)
    throw std::runtime_error(
        path + ": has " + std::to_string(size) + " bytes, a " + kind + " at most " +
        std::to_string(most_bytes) + ". Is it another file?");
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  errno = 0;
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw std::runtime_error(
        path + ": cannot be read to its end (" + std::strerror(errno) + "). Copy it again.");
  return bytes;
}

}  // namespace talus
