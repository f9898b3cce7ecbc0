#include "input_file.h"

#include <talus/io/gz_file.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <vector>

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

std::uint64_t verified_size(const std::string& path)
{
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) throw std::runtime_error(path + ": cannot be opened. Check its permissions.");
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> closer(file, gzclose);
  constexpr unsigned kChunk = 1 << 18;
  gzbuffer(file, kChunk);

  std::vector<char> chunk(kChunk);
  std::uint64_t size = 0;
  int got = 0;
  while ((got = gzread(file, chunk.data(), kChunk)) > 0) size += static_cast<std::uint64_t>(got);

  int code = Z_OK;
  const std::string zlib_says = gzerror(file, &code);
  if (code == Z_BUF_ERROR)
    throw std::runtime_error(
        path + ": gz file is cut short, its data ends at byte " + std::to_string(size) +
        " (uncompressed) before the trailer. Copy it again.");
  if (got < 0 || (code != Z_OK && code != Z_STREAM_END))
    throw std::runtime_error(
        path + ": gz data is damaged before byte " + std::to_string(size + kChunk) +
        " (uncompressed): " + zlib_says + ". Copy it again.");
  return size;
}

void require_complete_gz(const std::string& path, const std::string& name)
{
  const std::string shown = name.empty() ? path : name;
  std::string reason = "not even its header";
  char magic[2] = {};  // zlib takes a file without it for one that is not compressed
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
