#pragma once
#include <cstdint>
#include <string>

namespace talus
{
/** Checks that `path` is a regular, readable file that is not empty: a pipe may block for ever, and
 * a device may never end. `kind` is a word for messages, e.g. "rawlog". Throws std::runtime_error
 * that names the file, what is wrong and what to do. */
void require_readable_file(const std::string& path, const std::string& kind);

/** Reads such a file. Throws as require_readable_file() does, and, before it allocates memory, if
 * the file is larger than `most_bytes`. */
std::string read_input_file(
    const std::string& path, const std::string& kind, std::uint64_t most_bytes);

}  // namespace talus
