// Where a robot is on the map of an earlier drive: the ICP of MRPT lays a scan onto the points of a
// site map. Each twentieth scan of a log begins 0.3 m and 5 degrees from where its trajectory says
// that it was taken.
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/slam/CICP.h>
#include <talus/formats/convert.h>
#include <talus/io/geotiff.h>
#include <talus/io/rawlog_reader.h>
#include <talus/io/trajectory.h>
#include <talus/mrpt/observation_points.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <set>
#include <tuple>

using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;

namespace
{
constexpr double kRange_m = 12, kHighest_m = 1.5;

/** Ground and what stands on it. */
CSimplePointsMap points_of(const talus::io::LayerStack& site)
{
  CSimplePointsMap points;
  for (const auto what : {talus::formats::Surface::Ground, talus::formats::Surface::Standing})
    talus::formats::to_points(site, what, points);
  return points;
}

/** In the frame of the base: one point of each cube, since rings near the sensor would outweigh all
 * else. */
CSimplePointsMap thinned(const talus::SensorPoints& scan, double cube_m)
{
  CSimplePointsMap points;
  std::set<std::tuple<double, double, double>> taken;
  for (std::size_t i = 0; i < scan.x_m.size(); i++)
  {
    if (!(std::hypot(scan.x_m[i], scan.y_m[i]) < kRange_m)) continue;
    double x, y, z;
    scan.T_base_sensor.composePoint(scan.x_m[i], scan.y_m[i], scan.z_m[i], x, y, z);
    const auto index = [cube_m](double at_m) { return std::floor(at_m / cube_m); };
    if (z < kHighest_m && taken.insert({index(x), index(y), index(z)}).second)
      points.insertPoint(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  }
  return points;
}

CPose3D align(const CSimplePointsMap& map, const CSimplePointsMap& scan, const CPose3D& guess)
{
  mrpt::slam::CICP::TConfigParams settings;
  settings.maxIterations = 300;
  settings.thresholdDist = 0.8;  // how far apart a pair may be, at first and in the end [m]
  settings.smallestThresholdDist = 0.05;
  settings.thresholdAng = 0;
  settings.corresponding_points_decimation = 1;
  settings.onlyUniqueRobust = true;
  settings.skip_cov_calculation = true;
  mrpt::slam::CICP icp(settings);
  mrpt::slam::CMetricMapsAlignmentAlgorithm& algorithm = icp;  // its names are hidden in CICP
  return algorithm.Align3DPDF(&map, &scan, mrpt::poses::CPose3DPDFGaussian(guess))->getMeanVal();
}

void localize(const char* site_file, const char* log_file, const char* trajectory_file)
{
  const auto site = talus::io::read_geotiff(site_file);
  const auto map = points_of(site);
  const auto trajectory = talus::io::Trajectory::load(trajectory_file);
  talus::io::RawlogReader log(log_file);
  talus::SensorPoints scan;
  int count = 0;
  while (const auto observation = log.next())
  {
    if (!talus::points_from_observation(*observation, scan) || count++ % 20 != 0) continue;
    const auto truth = trajectory.at(mrpt::Clock::toDouble(observation->timestamp), 0.5);
    if (!truth) continue;
    const CPose3D guess = *truth + CPose3D(0.25, -0.17, 0, 5 * M_PI / 180, 0, 0);
    const auto off = align(map, thinned(scan, 4 * site.resolution_m), guess) - *truth;
    std::printf(
        "scan %d: %.2f m and %.1f degrees off\n", count - 1, off.norm(),
        std::abs(off.yaw()) * 180 / M_PI);
  }
}
}  // namespace

int main(int argc, char** argv)
{
  if (argc != 4)
  {
    std::fprintf(stderr, "usage: %s SITE.tif LOG.rawlog TRAJECTORY.tum\n", argv[0]);
    return 2;
  }
  try
  {
    localize(argv[1], argv[2], argv[3]);
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
