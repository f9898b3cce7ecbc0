#pragma once
#include <string>

namespace talus::io
{
/** Checks that a gz or zstd file that was just written is whole: MRPT's streams do not tell when
 * their last bytes do not reach the disk. Call it after close() and before the file gets its name.
 * `name` is what messages call it, empty: `path`. Throws std::runtime_error that names it and asks
 * whether the disk is full. */
void require_complete_packed(const std::string& path, const std::string& name = "");

}  // namespace talus::io
