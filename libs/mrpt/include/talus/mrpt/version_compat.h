#pragma once
// Every switch between versions of MRPT lives here. Developed against 2.5.8 (Debian bookworm).
// MRPT_VERSION is 0xMmp up to 2.9 and 0xMMmmpp from 2.10 on, so only >= comparisons with the long
// form are safe.
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/version.h>

#include <cstddef>

#if MRPT_VERSION >= 0x020700
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/Scene.h>
namespace mrpt::opengl
{
class Scene;
}
namespace talus
{
using MrptScene = mrpt::opengl::Scene;
}
#else
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/COpenGLScene.h>
namespace mrpt::opengl
{
class COpenGLScene;
}
namespace talus
{
using MrptScene = mrpt::opengl::COpenGLScene;
}
#endif

// CMetricMap::boundingBox() is virtual from 2.11.3 on.
#if MRPT_VERSION >= 0x020b03
#define TALUS_OVERRIDE_SINCE_2_11_3 override
#else
#define TALUS_OVERRIDE_SINCE_2_11_3
#endif

namespace talus::detail
{
#if MRPT_VERSION >= 0x020b04 && MRPT_VERSION < 0x030000
/** One time a point [s, relative to the stamp], or nullptr when the cloud has none. */
inline const mrpt::aligned_std_vector<float>* point_times(const mrpt::maps::CPointsMap& points)
{
  return points.getPointsBufferRef_timestamp();
}
#else
inline const mrpt::aligned_std_vector<float>* point_times(const mrpt::maps::CPointsMap&)
{
  return nullptr;
}
#endif

#if MRPT_VERSION >= 0x020b04
/** Calls add(x, y, z, column) [m, sensor frame] for each return when the scan holds its points in
 * XYZ; false when it does not (no version before 2.11.4 can). */
template <class Add>
bool for_each_organized_point(const mrpt::obs::CObservationRotatingScan& scan, Add&& add)
{
  const auto& points = scan.organizedPoints;
  if (points.rows() == 0 || points.cols() == 0) return false;
  for (int row = 0; row < points.rows(); ++row)
    for (int column = 0; column < points.cols(); ++column)
      if (const auto& p = points(row, column); p.x != 0 || p.y != 0 || p.z != 0)
        add(p.x, p.y, p.z, column);
  return true;
}
#else
template <class Add>
bool for_each_organized_point(const mrpt::obs::CObservationRotatingScan&, Add&&)
{
  return false;
}
#endif

}  // namespace talus::detail
