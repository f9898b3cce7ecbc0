#pragma once
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "packed_file.h"

namespace talus::io
{
/** What MRPT reads objects from: a file that may be packed. */
class PackedArchive : public mrpt::serialization::CArchive
{
 public:
  explicit PackedArchive(PackedFile& file) : file_(file) {}
  std::string getArchiveDescription() const override { return "file"; }

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
