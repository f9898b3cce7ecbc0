#pragma once
#include <memory>
#include <string>

namespace mrpt::serialization
{
class CSerializable;
}

namespace talus::io
{
/** A file name without the ending of a packed file: .gz, .zst, .zstd. */
std::string without_packing(const std::string& name);

/** A file of MRPT's objects that is written, gz-packed: a rawlog, or one map. All functions throw
 * std::runtime_error that names the file and says what is wrong. */
class PackedLog
{
 public:
  /** Makes the file, or empties it. `name`: what errors call it; empty: its path. */
  explicit PackedLog(std::string path, const std::string& name = "");
  ~PackedLog();
  PackedLog(const PackedLog&) = delete;
  PackedLog& operator=(const PackedLog&) = delete;

  /** Adds an observation, an action or a map, after those before. */
  void write(const mrpt::serialization::CSerializable& object);
  /** Ends a part of the file: a reader finds all that was written until now. */
  void flush();
  /** Ends the file, and reads it again to see that it is whole. */
  void close();

 private:
  struct Impl;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_, name_;
  std::unique_ptr<Impl> file_;  //!< null: it is ended
};

}  // namespace talus::io
