#pragma once
#include <cstdint>
#include <string>

namespace talus::io
{
/** Checks that `path` is a regular file that can be read and is not empty. `kind` is a word for
 * messages, e.g. "rawlog". Throws std::runtime_error that names the file, what is wrong and what to
 * do. */
void require_readable_file(const std::string& path, const std::string& kind);

/** Reads a file (gz or plain) to its end, which makes zlib compare the checksum and the length in
 * the trailer of every gz member, and returns the number of bytes after decompression. Throws
 * std::runtime_error when the data is cut short or damaged. */
std::uint64_t verified_size(const std::string& path);

}  // namespace talus::io
