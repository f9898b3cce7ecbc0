#include <mrpt/obs/CObservation3DRangeScan.h>

#include "observation_points_detail.h"

using mrpt::obs::CObservation3DRangeScan;

namespace talus::detail
{
namespace
{
using RangeImage = mrpt::math::CMatrix_u16;

/** The points of the pixels with a return; `skip`: an image whose equal returns were taken. */
void unproject(
    const CObservation3DRangeScan& obs, const CObservation3DRangeScan::unproject_LUT_t& rays,
    const RangeImage& ranges, const RangeImage* skip, SensorPoints& out)
{
  const auto columns = static_cast<std::size_t>(ranges.cols());
  for (int row = 0; row < ranges.rows(); ++row)
    for (int column = 0; column < ranges.cols(); ++column)
    {
      const auto units = ranges(row, column);
      if (units == 0 || (skip && (*skip)(row, column) == units)) continue;
      const float range_m = static_cast<float>(units) * obs.rangeUnits;
      const auto i = static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column);
      add_point(out, rays.Kxs[i] * range_m, rays.Kys[i] * range_m, rays.Kzs[i] * range_m);
    }
}

bool same_size(const RangeImage& a, const RangeImage& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols();
}

}  // namespace

/** The range image is the measurement: every pixel with a return gives a point (x forward, z up).
 * Points stored beside it may have been thinned and are used only without an image. */
void read_points(const CObservation3DRangeScan& obs, SensorPoints& out)
{
  if (!obs.hasRangeImage)
  {
    if (!obs.hasPoints3D) fail(obs, "it has neither a range image nor points. Record it again");
    out.x_m.assign(obs.points3D_x.begin(), obs.points3D_x.end());
    out.y_m.assign(obs.points3D_y.begin(), obs.points3D_y.end());
    out.z_m.assign(obs.points3D_z.begin(), obs.points3D_z.end());
    return;
  }
  const auto& image = obs.rangeImage;
  if (image.rows() == 0 || image.cols() == 0)
    fail(obs, "its range image is empty. Record it again");
  const auto& camera = obs.cameraParams;
  if (!(camera.fx() > 0) || !(camera.fy() > 0))
    fail(obs, "its depth camera has no focal length. Set cameraParams");
  if (camera.ncols != static_cast<std::uint32_t>(image.cols()) ||
      camera.nrows != static_cast<std::uint32_t>(image.rows()))
    fail(obs, "the camera's resolution is not that of its range image. Correct cameraParams");

  const auto& rays = obs.get_unproj_lut();
  unproject(obs, rays, image, nullptr, out);
  for (const auto& [name, layer] : obs.rangeImageOtherLayers)  // further returns of the same ray
    if (same_size(layer, image)) unproject(obs, rays, layer, &image, out);
}

}  // namespace talus::detail
