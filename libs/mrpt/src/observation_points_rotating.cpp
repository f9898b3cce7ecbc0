#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/VelodyneCalibration.h>
#include <talus/mrpt/version_compat.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>
#include <vector>

#include "observation_points_detail.h"

using mrpt::obs::CObservationRotatingScan;

namespace talus::detail
{
namespace
{
using RangeImage = mrpt::math::CMatrix_u16;

/** How the rows and columns of a scan become directions and times. */
struct ScanGeometry
{
  std::vector<double> sin_elevation, cos_elevation;  //!< one a row
  std::vector<double> row_delay;  //!< of a row's laser, in columns
  double columns = 1;  //!< over which azimuth span and sweep duration extend, one a firing
  double azimuth_sign = 1;
  bool returns_alternate = false;  //!< columns 2i and 2i+1 hold the returns of firing 2i
};

/** "HDL-32E" -> "HDL32E" */
std::string plain_name(std::string name)
{
  const auto drop = [](unsigned char c) { return !std::isalnum(c); };
  name.erase(std::remove_if(name.begin(), name.end(), drop), name.end());
  std::transform(
      name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
  return name;
}

/** fromVelodyne() of MRPT 2.5 makes the image `rows` times wider than its firings: the columns
 * beyond are empty. */
int used_columns(const CObservationRotatingScan& scan)
{
  const auto& image = scan.rangeImage;
  const int first = image.cols() / image.rows();
  if (image.cols() % image.rows() != 0) return image.cols();
  for (int row = 0; row < image.rows(); ++row)
    for (int column = first; column < image.cols(); ++column)
      if (image(row, column) != 0) return image.cols();
  return first;
}

/** One row: a planar scan, whose first and last rays lie at both ends of the span. */
ScanGeometry planar_geometry(const CObservationRotatingScan& scan)
{
  ScanGeometry g;
  g.sin_elevation = {0};
  g.cos_elevation = {1};
  g.row_delay = {0};
  g.columns = std::max(1, static_cast<int>(scan.rangeImage.cols()) - 1);
  return g;
}

/** Rows in the order in which the lasers fire. A Velodyne turns clockwise: a positive span is its
 * raw azimuth, a negative one is MRPT's convention. */
ScanGeometry velodyne_geometry(
    const CObservationRotatingScan& scan, const std::string& model, const FiringTimes& times)
{
  ScanGeometry g;
  const auto& calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration(model);
  for (std::size_t laser = 0; laser < calibration.laser_corrections.size(); ++laser)
  {
    g.sin_elevation.push_back(calibration.laser_corrections[laser].sinVertCorrection);
    g.cos_elevation.push_back(calibration.laser_corrections[laser].cosVertCorrection);
    g.row_delay.push_back(times.of(static_cast<int>(laser)) / times.cycle_us);
  }
  const int used = used_columns(scan);
  // With two returns a ray fromVelodyne() fills half of these columns.
  const bool is_dual = !scan.rangeOtherLayers.empty() && used < scan.rangeImage.cols();
  g.columns = is_dual ? used / 2 : used;
  g.returns_alternate = is_dual && scan.rangeImage.rows() == 16;
  g.azimuth_sign = scan.azimuthSpan > 0 ? -1 : 1;
  return g;
}

std::optional<ScanGeometry> geometry_of(const CObservationRotatingScan& scan)
{
  const auto rows = scan.rangeImage.rows();
  const auto name = plain_name(scan.lidarModel);
  if (rows == 0 || scan.rangeImage.cols() == 0) return std::nullopt;
  if (rows == 1) return planar_geometry(scan);
  if (rows == 16 && name.find("VLP16") == 0) return velodyne_geometry(scan, "VLP16", kFiringVlp16);
  if (rows == 32 && name.find("HDL32") == 0) return velodyne_geometry(scan, "HDL32", kFiringHdl32);
  return std::nullopt;
}

/** The returns of one image; `skip`: an image whose equal returns were taken already. */
void read_image(
    const CObservationRotatingScan& scan, const ScanGeometry& g, const RangeImage& image,
    const RangeImage* skip, SensorPoints& out)
{
  const auto& intensities = scan.intensityImage;
  const bool has_any = intensities.rows() == image.rows() && intensities.cols() == image.cols();
  std::vector<float>* const intensity = has_any ? channel_of(out, kIntensity) : nullptr;
  for (int row = 0; row < image.rows(); ++row)
    for (int column = 0; column < image.cols(); ++column)
    {
      const auto units = image(row, column);
      if (units == 0 || (skip && (*skip)(row, column) == units)) continue;
      const double range_m = units * scan.rangeResolution;
      if (range_m < scan.minRange || range_m > scan.maxRange) continue;
      const auto r = static_cast<std::size_t>(row);
      const int firing = g.returns_alternate ? column - column % 2 : column;
      const double part = (firing + g.row_delay[r]) / g.columns;
      const double azimuth = g.azimuth_sign * (scan.startAzimuth + scan.azimuthSpan * part);
      const double xy = range_m * g.cos_elevation[r];
      add_point(out, xy * std::cos(azimuth), xy * std::sin(azimuth), range_m * g.sin_elevation[r]);
      if (scan.sweepDuration > 0)
        out.time_s.push_back(static_cast<float>(scan.sweepDuration * part));
      // The image is that of the first return.
      if (intensity)
        intensity->push_back(
            skip ? std::numeric_limits<float>::quiet_NaN()
                 : static_cast<float>(intensities(row, column)));
    }
}

/** False where the scan holds no points in XYZ. */
bool read_organized_points(const CObservationRotatingScan& scan, SensorPoints& out)
{
  const double column_s = scan.columnCount > 0 ? scan.sweepDuration / scan.columnCount : 0.0;
  return for_each_organized_point(
      scan,
      [&](double x, double y, double z, int column)
      {
        add_point(out, x, y, z);
        if (column_s > 0) out.time_s.push_back(static_cast<float>(column_s * column));
      });
}

[[noreturn]] void fail_without_points(const CObservationRotatingScan& scan)
{
  if (scan.rangeImage.rows() == 0 || scan.rangeImage.cols() == 0)
    fail(scan, "its range image is empty. Record it again");
  fail(
      scan, "the elevation angles of lidarModel '" + scan.lidarModel + "' with " +
                std::to_string(scan.rangeImage.rows()) +
                " rows are not in the observation and not known (VLP-16, HDL-32E and single rows "
                "are). Record CObservationVelodyneScan or CObservationPointCloud instead");
}

}  // namespace

/** The image comes first where it says all: MRPT's own conversions fill the points in units of the
 * image (fromScan2D() from 2.11.4 on), and in the frame of the robot instead of the sensor. */
void read_points(const CObservationRotatingScan& obs, SensorPoints& out)
{
  const auto geometry = geometry_of(obs);
  if (!geometry)
  {
    if (!read_organized_points(obs, out)) fail_without_points(obs);
    return;
  }
  read_image(obs, *geometry, obs.rangeImage, nullptr, out);
  for (const auto& [name, layer] : obs.rangeOtherLayers)  // further returns of the same ray
    if (layer.rows() == obs.rangeImage.rows() && layer.cols() == obs.rangeImage.cols())
      read_image(obs, *geometry, layer, &obs.rangeImage, out);
}

}  // namespace talus::detail
