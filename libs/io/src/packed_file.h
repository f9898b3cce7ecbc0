#pragma once
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "key_frames.h"

namespace talus::io
{
/** Bytes still to be read. */
struct Bytes
{
  const char* begin = nullptr;
  std::size_t size = 0;
};
/** Memory still to be filled. */
struct Room
{
  char* begin = nullptr;
  std::size_t size = 0;
};

/** One way to pack a file. */
class Unpacker
{
 public:
  virtual ~Unpacker() = default;

  /** For messages: "gz" or "zstd", empty for a file that is not packed. */
  virtual const char* name() const = 0;

  /** Unpacks from one to the other, and leaves in both what is left. Throws std::runtime_error with
   * the reason when the data is damaged. */
  virtual void unpack(Bytes& from, Room& to) = 0;

  /** Whether the data before is whole, so that the file may end here. */
  virtual bool may_end() const = 0;

  /** Whether data could go on so; asked where may_end() and some data came before. */
  virtual bool may_go_on_with(std::string_view begin) const = 0;
};

/** By the first bytes of a file. */
std::unique_ptr<Unpacker> make_unpacker(std::string_view begin);

/** Bytes that one packed byte may become. Logs of sensors hardly reach 20; files that are made to
 * fill a disk or a memory reach 1,000 (gz) and 30,000 (zstd). */
constexpr std::uint64_t kMaxPerByte = 250;

/** The bytes of a file: as they are, or unpacked where it begins as gz (of one or more members) or
 * zstd (of one or more frames) does. Takes little memory, whatever is in the file. */
class PackedFile
{
 public:
  /** Throws std::runtime_error if it cannot be opened. */
  explicit PackedFile(const std::string& path);

  /** Reads `count` bytes, fewer at the end only. Throws std::runtime_error where packed data is cut
   * short, damaged, followed by something else, or unpacks to far more than any log does. */
  std::size_t read(void* to, std::size_t count);

  /** Whether it begins as gz or zstd does. */
  bool is_packed() const { return unpacker_->name()[0] != '\0'; }

  /** Whether all is read. At the end it has compared the checksum of what was packed. Throws
   * std::runtime_error as read() does. */
  bool at_end() { return next_ == end_ && !unpack_more(); }

  /** Bytes read so far, unpacked. */
  std::uint64_t position() const { return position_; }

  /** Fraction of the file that is read, 0..1. */
  double progress() const;

 private:
  bool unpack_more();
  std::size_t unpack(Room room);
  void refill();
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::ifstream file_;
  std::unique_ptr<Unpacker> unpacker_;
  std::vector<char> packed_, unpacked_;
  Bytes rest_;  //!< of packed_
  std::size_t next_ = 0, end_ = 0;  //!< what is still to be read of unpacked_
  std::uint64_t position_ = 0;
  std::uint64_t file_bytes_ = 0, fetched_bytes_ = 0;  //!< of the file, and read of it
  std::uint64_t before_last_bytes_ = 0;  //!< of the file, before what was unpacked last
  std::uint64_t unpacked_bytes_ = 0;
};

/** Reads a file to its end, which compares the checksums of packed data, and returns the number of
 * bytes after unpacking. Throws std::runtime_error as PackedFile does. */
std::uint64_t verified_size(const std::string& path);

/** What MRPT reads objects from: a file that may be packed. */
class PackedArchive : public mrpt::serialization::CArchive
{
 public:
  explicit PackedArchive(PackedFile& file) : file_(file) {}
  std::string getArchiveDescription() const override { return "file"; }

  /** The next object; of a simplemap its header alone, and `key_frames` gets what follows. */
  mrpt::serialization::CSerializable::Ptr next_object(std::optional<KeyFrames>& key_frames)
  {
    std::string name;
    bool is_old = false;
    std::int8_t version = -1;
    internal_ReadObjectHeader(name, is_old, version);
    const auto* known = mrpt::rtti::findRegisteredClass(name);  // also by a name that it had
    if (known == CLASS_ID(mrpt::maps::CSimpleMap))
      return key_frames.emplace(*this, version, !is_old), nullptr;
    if (!known && name != "nullptr")
      throw std::runtime_error("Stored object has class '" + name + "' which is not registered!");
    mrpt::serialization::CSerializable::Ptr object;
    if (known)
      object = mrpt::ptr_cast<mrpt::serialization::CSerializable>::from(known->createObject());
    internal_ReadObject(object.get(), name, is_old, version);
    return object;
  }

 protected:
  /** All of it: not every reader of MRPT looks whether it got what it asked for. */
  std::size_t read(void* to, std::size_t count) override
  {
    if (file_.read(to, count) < count)
      throw std::runtime_error("the data ends in the middle of it");
    return count;
  }
  std::size_t write(const void*, std::size_t) override
  {
    throw std::logic_error("an archive for reading");
  }

 private:
  PackedFile& file_;
};

inline bool is_finite(const mrpt::poses::CPose3D& pose)
{
  const auto T = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
  return std::all_of(T.begin(), T.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace talus::io
