#pragma once
#include <string>
#include <string_view>

namespace talus::io
{
/** A file that appears whole or not at all: written under another name in the same folder, then
 * renamed. What was there before stays until commit() has succeeded. */
class AtomicFile
{
 public:
  /** Creates the file beside `path` (symbolic links are followed). Throws std::runtime_error naming
   * the file, why it cannot be written and what to do; also where a device or a pipe would be
   * replaced. */
  explicit AtomicFile(const std::string& path);
  /** Without commit(): removes what was written. */
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /** Where to write to. It exists, is empty, and has the ending of the final name. */
  const std::string& temporary_path() const { return temporary_path_; }

  /** Brings what was written to the disk and gives it its name. Throws std::runtime_error. */
  void commit();

 private:
  std::string path_, temporary_path_;
};

/** Writes all bytes into a file through AtomicFile. Throws std::runtime_error. */
void write_file(const std::string& path, std::string_view bytes);

}  // namespace talus::io
