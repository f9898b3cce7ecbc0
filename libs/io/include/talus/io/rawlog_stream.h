#pragma once
#include <mrpt/serialization/CSerializable.h>

#include <memory>
#include <string>

namespace talus::io
{
/** The objects of a rawlog (plain, gz or zstd) one after the other, whatever their class. */
class RawlogStream
{
 public:
  /** Throws std::runtime_error that names the file, what is wrong and what to do. */
  explicit RawlogStream(const std::string& path);
  ~RawlogStream();

  /** The next object, or nullptr at the end, where packed data has been compared with its checksum.
   * Throws std::runtime_error naming the file and the byte offset (after unpacking) at which the
   * object begins, or, of packed data that is cut short or damaged, where it is that. */
  mrpt::serialization::CSerializable::Ptr next();

  /** Throws std::runtime_error: `what` is wrong with the object that next() returned last. */
  [[noreturn]] void fail(const std::string& what) const;

  /** Fraction of the data read so far, 0..1. */
  double progress() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::io
