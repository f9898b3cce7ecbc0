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
  /** Follows symbolic links, and removes what killed processes have left in the folder of the file.
   * Throws std::runtime_error naming the file, why it cannot be written and what to do. */
  explicit AtomicFile(const std::string& path);

  /** Where to write to: nothing yet, with the final name. */
  const std::string& temporary_path() const { return temporary_path_; }
  /** Where temporary_path() lies; what else is put there is removed with it. */
  const HiddenFolder& hidden_folder() const { return *hidden_; }

  /** Writes all bytes. Throws std::runtime_error. */
  void write(std::string_view bytes);

  /** Brings what was written to the disk and gives it its place. Throws std::runtime_error. */
  void commit();

 private:
  std::string path_, temporary_path_;
  std::unique_ptr<HiddenFolder> hidden_;
};

/** Writes all bytes into a file through AtomicFile. Throws std::runtime_error. */
void write_file(const std::string& path, std::string_view bytes);

/** Throws std::runtime_error where a folder, a device or a pipe has the name of a new file. */
void require_replaceable(const std::string& path);

/** Checks that a gz or zstd file that was just written is whole: MRPT's streams do not tell when
 * their last bytes do not reach the disk. Call it after close() and before the file gets its name.
 * `name` is what messages call it, empty: `path`. Throws std::runtime_error that names it and asks
 * whether the disk is full. */
void require_complete_packed(const std::string& path, const std::string& name = "");

}  // namespace talus::io
