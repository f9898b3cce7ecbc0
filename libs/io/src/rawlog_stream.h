#pragma once
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string>

namespace talus::io
{
/** The objects of a rawlog one after the other, whatever their class. */
class RawlogStream
{
 public:
  /** Checks the whole file first (see verified_size()). Throws std::runtime_error. */
  explicit RawlogStream(const std::string& path);

  /** The next object, or nullptr at the end. Throws std::runtime_error naming the file and the byte
   * offset at which the object begins. */
  mrpt::serialization::CSerializable::Ptr next();

  /** Throws std::runtime_error: `what` is wrong with the object that next() returned last. */
  [[noreturn]] void fail(const std::string& what) const;

  /** Fraction of the data read so far, 0..1. */
  double progress() const;

 private:
  std::string path_;
  std::uint64_t size_ = 0;  //!< bytes after decompression
  std::uint64_t object_begin_ = 0;
  mrpt::io::CFileGZInputStream file_;
  mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileGZInputStream> archive_;
};

}  // namespace talus::io
