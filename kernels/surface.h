#pragma once
#include "kernels/math.h"

namespace talus::kernels
{
// What stage 6 hands to stage 7.

constexpr std::int32_t kNoHeight = -0x7fffffff - 1;

/** Flags of a Surface. The lowest bit is free, as in CellFlag. */
enum SurfaceFlag : std::int32_t
{
  kSurfaceSeen = 2,  //!< a ray hit it or passed low over its ground, or the robot stood there
  kSurfacePossibleDropOff = 4,  //!< its ground was not seen and may lie far below that around it
  kSurfaceDriven = 8  //!< the robot drove over it, and no new object stands there
};

constexpr int kSurfaceFlags = 4;

/** The surfaces of one cell, quantised, for stage 7. */
struct alignas(8) Surface
{
  std::int32_t ground;  //!< kNoHeight: unknown
  /** The elevation (the ground without an object) above the bits of the flags. */
  std::int32_t height_and_flags;

  TALUS_HD bool known() const { return ground != kNoHeight; }
  TALUS_HD std::int32_t height() const { return height_and_flags >> kSurfaceFlags; }
  TALUS_HD bool is(SurfaceFlag flag) const { return (height_and_flags & flag) != 0; }
};

}  // namespace talus::kernels
