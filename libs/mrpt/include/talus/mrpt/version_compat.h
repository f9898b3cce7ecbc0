#pragma once
// Every switch between versions of MRPT lives here, those of mrpt-nav in version_compat_nav.h.
// Developed against 2.5.8 (Debian bookworm). MRPT_VERSION is 0xMmp up to 2.9 and 0xMMmmpp from 2.10
// on, so only >= comparisons with the long form are safe.
#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/img/TColor.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/version.h>
#if MRPT_VERSION >= 0x030000
#include <mrpt/maps/CGenericPointsMap.h>
#else
#include <mrpt/maps/CColouredPointsMap.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

// What is drawn: mrpt::opengl, from 3.0 on mrpt::viz, here talus::mrpt_scene.
// #include TALUS_SCENE_HEADER(CSetOfObjects.h)
#if MRPT_VERSION >= 0x030000
#define TALUS_SCENE_HEADER(name) <mrpt/viz/name>
#define TALUS_MRPT_SCENE_HEADER <mrpt/viz/Scene.h>
namespace mrpt::viz
{
class CSetOfObjects;
class CVisualObject;
class Scene;
}  // namespace mrpt::viz
namespace talus
{
namespace mrpt_scene = mrpt::viz;
using MrptScene = mrpt::viz::Scene;
using MrptSceneObject = mrpt::viz::CVisualObject;
}  // namespace talus
#else
#define TALUS_SCENE_HEADER(name) <mrpt/opengl/name>
namespace mrpt::opengl
{
class CRenderizable;
class CSetOfObjects;
#if MRPT_VERSION >= 0x020700
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/Scene.h>
#define TALUS_MRPT_SCENE Scene
#else
#define TALUS_MRPT_SCENE_HEADER <mrpt/opengl/COpenGLScene.h>
#define TALUS_MRPT_SCENE COpenGLScene
#endif
class TALUS_MRPT_SCENE;
}  // namespace mrpt::opengl
namespace talus
{
namespace mrpt_scene = mrpt::opengl;
using MrptScene = mrpt::opengl::TALUS_MRPT_SCENE;
using MrptSceneObject = mrpt::opengl::CRenderizable;
}  // namespace talus
#undef TALUS_MRPT_SCENE
#endif

// A member of an observation: where its sensor is, from 3.0 on by value.
#if MRPT_VERSION >= 0x030000
#define TALUS_GET_SENSOR_POSE(pose) \
  mrpt::poses::CPose3D getSensorPose() const override { return pose; }
#else
#define TALUS_GET_SENSOR_POSE(pose) \
  void getSensorPose(mrpt::poses::CPose3D& out) const override { out = pose; }
#endif

// Options by their names, for programs that know no class: in MRPT after 3.1.2.
#if __has_include(<mrpt/config/OptionsCapable.h>)
#include <mrpt/config/OptionsCapable.h>
namespace talus
{
using OptionsCapable = mrpt::config::OptionsCapable;
}
#else
namespace talus
{
/** The same, until MRPT has it. */
class OptionsCapable
{
 public:
  virtual ~OptionsCapable() = default;
  /** The options of an object: valid as long as it lives. */
  virtual std::map<std::string, mrpt::config::CLoadableOptions*> optionsByName() = 0;
};
}  // namespace talus
#endif

// CMetricMap::boundingBox() is virtual from 2.11.3 on.
#if MRPT_VERSION >= 0x020b03
#define TALUS_OVERRIDE_SINCE_2_11_3 override
#else
#define TALUS_OVERRIDE_SINCE_2_11_3
#endif

namespace talus::detail
{
/** A fault of MRPT's own programs, which specifications leave out (doc/mrpt.md). */
constexpr bool kRawlogEditFiltersWork = MRPT_VERSION < 0x020c01 || MRPT_VERSION >= 0x030102;

/** CHolonomicFullEval weighs so many factors, and refuses any other number. */
#if MRPT_VERSION >= 0x020e03
constexpr std::size_t kHolonomicFactors = 8;
#else
constexpr std::size_t kHolonomicFactors = 7;
#endif

/** What mrpt::img::colormap() gives, from 3.0 on in floats. */
inline mrpt::img::TColor color_of(const mrpt::img::TColor& c) { return c; }
inline mrpt::img::TColor color_of(const mrpt::img::TColorf& c) { return c.asTColor(); }

/** One time a point [s, relative to the stamp], or nullptr when the cloud has none. */
inline const mrpt::aligned_std_vector<float>* point_times(
    [[maybe_unused]] const mrpt::maps::CPointsMap& points)
{
#if MRPT_VERSION >= 0x020f00
  return points.getPointsBufferRef_float_field("t");
#elif MRPT_VERSION >= 0x020b04
  return points.getPointsBufferRef_timestamp();
#else
  return nullptr;
#endif
}

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

// 2.15 calls CPointsMapXYZI deprecated; yet older versions cannot read what replaces it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
#if MRPT_VERSION >= 0x030000
using CloudWithIntensity = mrpt::maps::CGenericPointsMap;
#else
using CloudWithIntensity = mrpt::maps::CPointsMapXYZI;
#endif

/** For setPointFast() and set_intensity(): points that are inserted one by one get no intensity
 * from 2.14.0 on, and cannot be written then. */
inline auto make_cloud_with_intensity(std::size_t points)
{
  auto cloud = CloudWithIntensity::Create();
#if MRPT_VERSION >= 0x030000
  cloud->registerField_float(mrpt::maps::CPointsMap::POINT_FIELD_INTENSITY);
#endif
  cloud->resize(points);
  return cloud;
}

inline void set_intensity(CloudWithIntensity& points, std::size_t i, float intensity)
{
#if MRPT_VERSION >= 0x030000
  points.setPointField_float(i, mrpt::maps::CPointsMap::POINT_FIELD_INTENSITY, intensity);
#else
  points.setPointIntensity(i, intensity);
#endif
}

inline float intensity_of(const CloudWithIntensity& points, std::size_t i)
{
#if MRPT_VERSION >= 0x030000
  return points.getPointField_float(i, mrpt::maps::CPointsMap::POINT_FIELD_INTENSITY);
#else
  return points.getPointIntensity(i);
#endif
}

#if MRPT_VERSION >= 0x030000
using CloudWithColours = mrpt::maps::CGenericPointsMap;
#else
using CloudWithColours = mrpt::maps::CColouredPointsMap;
#endif

/** For setPointFast() and set_colour(). */
inline auto make_cloud_with_colours(std::size_t points)
{
  auto cloud = CloudWithColours::Create();
#if MRPT_VERSION >= 0x030000
  for (const char* colour : {"red", "green", "blue"}) cloud->registerField_float(colour);
#endif
  cloud->resize(points);
  return cloud;
}

/** `rgb`: 0x00RRGGBB. */
inline void set_colour(CloudWithColours& points, std::size_t i, std::uint32_t rgb)
{
  const auto red = static_cast<float>(rgb >> 16 & 0xff),
             green = static_cast<float>(rgb >> 8 & 0xff), blue = static_cast<float>(rgb & 0xff);
#if MRPT_VERSION >= 0x030000
  points.setPointField_float(i, "red", red);
  points.setPointField_float(i, "green", green);
  points.setPointField_float(i, "blue", blue);
#else
  points.setPointColor(i, red / 255, green / 255, blue / 255);
#endif
}

/** The values of a field of a cloud, a float a point; nothing where it has none: `intensity`,
 * `red`, `green` and `blue` from 0 to 255, from 2.15 on any. */
inline void read_point_field(
    const mrpt::maps::CPointsMap& points, const std::string& name, std::vector<float>& to)
{
  const std::size_t size = points.size();
  if (const auto* cloud = dynamic_cast<const CloudWithIntensity*>(&points);
      cloud && name == "intensity")
  {
    to.resize(size);
    for (std::size_t i = 0; i < size; ++i) to[i] = intensity_of(*cloud, i);
    return;
  }
#if MRPT_VERSION < 0x030000
  const int colour = name == "red" ? 0 : name == "green" ? 1 : name == "blue" ? 2 : -1;
  if (const auto* cloud = dynamic_cast<const mrpt::maps::CColouredPointsMap*>(&points);
      cloud && colour >= 0)
  {
    constexpr float kParts = 65536;  // whole numbers that were divided by 255 come back
    to.resize(size);
    for (std::size_t i = 0; i < size; ++i)
    {
      float rgb[3];
      cloud->getPointColor(i, rgb[0], rgb[1], rgb[2]);
      to[i] = std::round(255 * rgb[colour] * kParts) / kParts;
    }
    return;
  }
#endif
#if MRPT_VERSION >= 0x020f00
  if (const auto* field = points.getPointsBufferRef_float_field(name);
      field && field->size() == size)
    to.assign(field->begin(), field->end());
#endif
}

inline bool is_cloud_with_intensity(const mrpt::maps::CPointsMap& points)
{
  return dynamic_cast<const CloudWithIntensity*>(&points) != nullptr;
}
#pragma GCC diagnostic pop

}  // namespace talus::detail
