#pragma once
#include <talus/io/hidden_folder.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace talus::io
{
/** Of the hidden folders in which an AtomicFile is written. */
constexpr const char* kFilePrefix = ".talus-file.";

/** A file that appears whole or not at all: written in a hidden folder beside it, then moved. What
 * was there before stays until commit() has succeeded. */
class AtomicFile
{
 public:
  /** Creates the file (symbolic links are followed), and removes what was left in its folder by
   * processes that were killed while they wrote. Throws std::runtime_error naming the file, why it
   * cannot be written and what to do; also where a device or a pipe would be replaced. */
  explicit AtomicFile(const std::string& path);
  /** Without commit(): removes what was written. */
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /** Where to write to. It exists, is empty, and has the final name. */
  const std::string& temporary_path() const { return temporary_path_; }
  /** Where temporary_path() lies; what else is put there is removed with it. */
  const HiddenFolder& hidden_folder() const { return *hidden_; }

  /** Writes all bytes. Throws std::runtime_error. */
  void write(std::string_view bytes);

  /** Brings what was written to the disk, with the permissions that it will have: nothing is left
   * to do but to move it. Throws std::runtime_error. */
  void finish();

  /** finish(), then gives it its place. Throws std::runtime_error. */
  void commit();

 private:
  std::string path_, temporary_path_;
  std::unique_ptr<HiddenFolder> hidden_;
};

/** Writes all bytes into a file through AtomicFile. Throws std::runtime_error. */
void write_file(const std::string& path, std::string_view bytes);

/** Removes what was left by processes that were killed while an AtomicFile in the folder of `path`
 * was written; how many there were. */
std::size_t remove_abandoned_files(const std::string& path);

}  // namespace talus::io
