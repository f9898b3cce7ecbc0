// For targets whose reader hands objects to MRPT, which does not stand damaged ones: it takes the
// memory that a count in the stream asks for, and some classes crash. That is not what these
// targets are after, and would end every run. So MRPT knows here only the few simple classes below,
// and an allocation that no small input needs fails as where memory is short. What is ours is all
// there: files, compression, the row of objects, frames, poses, what becomes of an exception.
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/rtti/CObject.h>

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>

/** Stands before the function of the library. */
const mrpt::rtti::TRuntimeClassId* mrpt::rtti::findRegisteredClass(
    const std::string& name, const bool /*allow_ignore_namespace*/)
{
  using namespace mrpt::obs;
  using namespace mrpt::poses;
  for (const auto* known :
       {CLASS_ID(CObservationOdometry), CLASS_ID(CObservationRobotPose),
        CLASS_ID(CObservationComment), CLASS_ID(CSensoryFrame), CLASS_ID(CActionCollection),
        CLASS_ID(CPose2D), CLASS_ID(CPose3D), CLASS_ID(mrpt::maps::CSimpleMap),
        CLASS_ID(CPose3DPDFGaussian)})
    if (name == known->className || name.substr(name.rfind(':') + 1) == known->className)
      return known;
  return nullptr;
}

namespace
{
// The sanitizer takes room of its own around each piece: many small ones cost several times their
// bytes.
constexpr std::size_t kMax = 64 << 20, kMaxTotal = 128 << 20, kAroundEach = 64;
std::atomic<std::size_t> in_use{0};
}  // namespace

/** The sanitizer's own would end the process. Many small pieces may be asked for as well. */
void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
  void* const memory = size <= kMax && in_use < kMaxTotal ? std::malloc(size) : nullptr;
  if (memory) in_use += malloc_usable_size(memory) + kAroundEach;
  return memory;
}
void* operator new(std::size_t size)
{
  void* const memory = operator new(size, std::nothrow);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept
{
  if (memory) in_use -= malloc_usable_size(memory) + kAroundEach;
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
