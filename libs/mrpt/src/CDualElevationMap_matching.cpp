#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/observation_points.h>
#include <talus/point_filter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "surface_view.h"
#include "warn_once.h"

namespace talus
{
using nav::SurfaceView;

namespace
{
double log_likelihood_of_point(
    const SurfaceView& map, const mrpt::math::TPoint3D& p_map,
    const CDualElevationMap::TLikelihoodOptions& o)
{
  const auto cell = map.window.index_at(p_map.x, p_map.y);
  const double d = cell ? map.distance(*cell, p_map.z) : NAN;
  if (std::isnan(d)) return std::log(o.outlierRatio);
  const double cell_variance = map.variance[*cell] > 0 ? map.variance[*cell] : 0;
  const double variance = o.sigma_m * o.sigma_m + cell_variance;
  return std::log(o.outlierRatio + (1 - o.outlierRatio) * std::exp(-0.5 * d * d / variance));
}
}  // namespace

bool CDualElevationMap::internal_canComputeObservationLikelihood(
    const mrpt::obs::CObservation& obs) const
{
  using namespace mrpt::obs;
  return IS_DERIVED(obs, CObservationPointCloud) || IS_DERIVED(obs, CObservationVelodyneScan) ||
         IS_DERIVED(obs, CObservationRotatingScan) || IS_DERIVED(obs, CObservation3DRangeScan) ||
         IS_DERIVED(obs, CObservation2DRangeScan);
}

double CDualElevationMap::internal_computeObservationLikelihood(
    const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const
{
  if (isEmpty()) return 0;
  SensorPoints points;
  try
  {
    likelihoodOptions.validate();
    if (!points_from_observation(obs, points)) return 0;
  }
  catch (const std::exception& e)
  {
    detail::warn_once(
        std::string("no likelihood: ") + e.what(),
        std::string("no likelihood: ") + obs.GetRuntimeClass()->className);
    return 0;
  }
  const SurfaceView map(view());
  const auto T_map_sensor = takenFrom + points.T_base_sensor;
  const auto step = static_cast<std::size_t>(likelihoodOptions.decimation);
  const PointFilter filter(
      insertionOptions, pose_from(T_map_sensor), pose_from(points.T_base_sensor));
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.x_m.size(); i++)
  {
    const float x = points.x_m[i], y = points.y_m[i], z = points.z_m[i];
    if (!filter.accepts(x, y, z) || count++ % step != 0) continue;
    mrpt::math::TPoint3D p_map;
    T_map_sensor.composePoint(x, y, z, p_map.x, p_map.y, p_map.z);
    sum += log_likelihood_of_point(map, p_map, likelihoodOptions);
  }
  return sum;
}

float CDualElevationMap::compute3DMatchingRatio(
    const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
    const mrpt::maps::TMatchingRatioParams& params) const
{
  const auto* other = otherMap ? otherMap->getAsSimplePointsMap() : nullptr;
  if (isEmpty() || !other || other->size() == 0) return 0;
  const SurfaceView map(view());
  std::size_t matched = 0;
  for (std::size_t i = 0; i < other->size(); i++)
  {
    mrpt::math::TPoint3D p;
    other->getPoint(i, p.x, p.y, p.z);
    p = otherMapPose.composePoint(p);
    const auto cell = map.window.index_at(p.x, p.y);
    if (cell && map.distance(*cell, p.z) <= params.maxDistForCorr) matched++;
  }
  return static_cast<float>(matched) / static_cast<float>(other->size());
}

const mrpt::maps::CSimplePointsMap& CDualElevationMap::standingPoints() const
{
  if (m_standingCache) return *m_standingCache;
  m_standingCache = mrpt::maps::CSimplePointsMap::Create();
  if (isEmpty()) return *m_standingCache;
  const SurfaceView map(view());
  const auto min_m = static_cast<float>(map.window.resolution_m);
  for (int iy = 0; iy < map.window.cells; iy++)
    for (int ix = 0; ix < map.window.cells; ix++)
    {
      const std::size_t cell = map.index(ix, iy);
      const float top = map.elevation[cell];
      if (!(top - map.ground[cell] > min_m)) continue;
      m_standingCache->insertPoint(
          static_cast<float>(map.x_m(ix)), static_cast<float>(map.y_m(iy)), top);
    }
  return *m_standingCache;
}

void CDualElevationMap::determineMatching2D(
    const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
    mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
    mrpt::maps::TMatchingExtraResults& extraResults) const
{
  standingPoints().determineMatching2D(
      otherMap, otherMapPose, correspondences, params, extraResults);
}

float CDualElevationMap::squareDistanceToClosestCorrespondence(float x0, float y0) const
{
  const auto& points = standingPoints();
  if (points.empty()) return std::numeric_limits<float>::infinity();
  return points.squareDistanceToClosestCorrespondence(x0, y0);
}

void CDualElevationMap::determineMatching3D(
    const mrpt::maps::CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
    mrpt::tfest::TMatchingPairList& correspondences, const mrpt::maps::TMatchingParams& params,
    mrpt::maps::TMatchingExtraResults& extraResults) const
{
  getAsSimplePointsMap()->determineMatching3D(
      otherMap, otherMapPose, correspondences, params, extraResults);
}

const mrpt::maps::CSimplePointsMap* CDualElevationMap::getAsSimplePointsMap() const
{
  if (m_pointsCache) return m_pointsCache.get();
  m_pointsCache = mrpt::maps::CSimplePointsMap::Create();
  if (isEmpty()) return m_pointsCache.get();
  const SurfaceView map(view());
  const auto resolution = static_cast<float>(map.window.resolution_m);
  for (int iy = 0; iy < map.window.cells; iy++)
    for (int ix = 0; ix < map.window.cells; ix++)
    {
      const std::size_t cell = map.index(ix, iy);
      const auto x = static_cast<float>(map.x_m(ix)), y = static_cast<float>(map.y_m(iy));
      const float top = map.elevation[cell], ground = map.ground[cell];
      const bool measured = map.state[cell] == static_cast<float>(CellState::Measured);
      if (!std::isnan(top)) m_pointsCache->insertPoint(x, y, top);
      if (measured && !(top - ground <= resolution)) m_pointsCache->insertPoint(x, y, ground);
    }
  return m_pointsCache.get();
}

mrpt::math::TBoundingBoxf CDualElevationMap::boundingBox() const
{
  mrpt::math::TBoundingBoxf box;
  if (isEmpty()) return box;
  box = mrpt::math::TBoundingBoxf::PlusMinusInfinity();
  const SurfaceView map(view());
  const auto half = static_cast<float>(map.window.resolution_m / 2);
  bool any = false;
  for (int iy = 0; iy < map.window.cells; iy++)
    for (int ix = 0; ix < map.window.cells; ix++)
      for (const float z : {map.ground[map.index(ix, iy)], map.elevation[map.index(ix, iy)]})
      {
        if (std::isnan(z)) continue;
        const auto x = static_cast<float>(map.x_m(ix)), y = static_cast<float>(map.y_m(iy));
        box.updateWithPoint({x - half, y - half, z});
        box.updateWithPoint({x + half, y + half, z});
        any = true;
      }
  return any ? box : mrpt::math::TBoundingBoxf();
}

}  // namespace talus
