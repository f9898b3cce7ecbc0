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
  /** Reads the whole file first, so that one that is cut short or damaged is found before any work.
   * Throws std::runtime_error that names the file, what is wrong and what to do. */
  explicit RawlogStream(const std::string& path);
  ~RawlogStream();

  /** The next object, or nullptr at the end. Throws std::runtime_error naming the file and the byte
   * offset (after unpacking) at which the object begins. */
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
