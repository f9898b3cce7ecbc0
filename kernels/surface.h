#pragma once
#include "kernels/math.h"

namespace talus::kernels
{
// What stage 6 tells stage 7 of a cell.

constexpr std::int32_t kNoHeight = -0x7fffffff - 1;

/** What else stage 7 wants to know of a cell. */
enum SurfaceFlag : std::int32_t
{
  kSurfaceMeasured = 1,  //!< its ground is measured
  kSurfaceSeen = 2,  //!< a ray met it or passed low over its ground, or the robot stood there
  kSurfaceMayDrop = 4,  //!< nobody saw its ground, which may lie far below that around it
  kSurfaceHitLately = 8,  //!< it was hit lately while rays passed, see hit_lately()
  kSurfaceDriven = 16,  //!< the robot drove over it, and nothing new stands there
  kSurfaceNear = 32  //!< its ground is filled from two sides and a ray passed near it
};

constexpr int kSurfaceFlags = 6;

/** The surfaces of one cell, quantised, for stage 8. */
struct alignas(8) Surface
{
  std::int32_t ground;  //!< kNoHeight: unknown
  /** Sixteen times the elevation, or the ground where nothing stands. */
  std::int32_t height_and_flags;

  TALUS_HD bool known() const { return ground != kNoHeight; }
  TALUS_HD std::int32_t height() const { return height_and_flags >> kSurfaceFlags; }
  TALUS_HD bool is(SurfaceFlag flag) const { return (height_and_flags & flag) != 0; }
};

/** Window order; columns padded by the feature radius. */
struct Surfaces
{
  Surface* cell;
  int pitch, pad;

  TALUS_HD int at(int ix, int iy) const { return iy * pitch + ix + pad; }
};

}  // namespace talus::kernels
