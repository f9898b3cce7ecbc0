#pragma once
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "key_frames.h"
#include "packed_file.h"

namespace talus::io
{
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
