// mrpt::slam::CICP finds a pose against the terrain map: in the plane against what stands, in space
// against both surfaces.
#include <gtest/gtest.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CICP.h>

#include <cmath>

#include "room_for_maps.h"

using namespace talus_test;
using mrpt::poses::CPose2D;
using mrpt::slam::CICP;

namespace
{
constexpr double kDegree = M_PI / 180;

CICP::TConfigParams settings(double farthest_m, double nearest_m)
{
  CICP::TConfigParams o;
  o.maxIterations = 200;
  o.thresholdDist = farthest_m;
  o.thresholdAng = 0;
  o.smallestThresholdDist = nearest_m;
  o.corresponding_points_decimation = 1;
  o.skip_cov_calculation = true;
  return o;
}

/** A pose found in the plane: what stands in a map of one scan against what stands in the map. */
CPose2D found_in_plane(
    const CDualElevationMap& map, const CDualElevationMap& scan, const CPose2D& guess)
{
  CICP icp(settings(0.6, 0.05));
  mrpt::slam::CMetricMapsAlignmentAlgorithm& align = icp;
  mrpt::poses::CPosePDFGaussian from(guess);
  const auto found = align.AlignPDF(&map, &scan.standingPoints(), from);
  return found->getMeanVal();
}

/** A pose found in space: the points of a scan against both surfaces. */
CPose3D found_in_space(
    const CDualElevationMap& map, const CSimplePointsMap& points_base, const CPose3D& guess)
{
  CICP icp(settings(0.6, 0.05));
  mrpt::slam::CMetricMapsAlignmentAlgorithm& align = icp;
  const auto found = align.Align3DPDF(&map, &points_base, mrpt::poses::CPose3DPDFGaussian(guess));
  return found->getMeanVal();
}

/** The map of one scan, in the frame of its base. */
CDualElevationMap map_of(const mrpt::obs::CObservation& scan, const CDualElevationMap& like)
{
  CDualElevationMap map(like.mapper().parameters(), talus::Backend::Cpu);
  EXPECT_TRUE(map.insertObservation(scan, CPose3D()));
  return map;
}
}  // namespace

TEST(Icp, finds_the_pose_in_the_plane_against_what_stands)
{
  const auto map = map_of_room();
  const CPose3D truth(0.2, 0.1, 0, 0.1, 0, 0);
  const auto scan = map_of(scan_of_room(truth), map);
  for (const double side : {-1.0, 1.0})
  {
    const CPose2D guess(
        truth.x() + 0.25 * side, truth.y() - 0.17 * side, truth.yaw() + 5 * side * kDegree);
    const CPose2D found = found_in_plane(map, scan, guess);
    EXPECT_LT(found.distance2DTo(truth.x(), truth.y()), 0.05) << side;
    EXPECT_LT(std::abs(found.phi() - truth.yaw()), 1 * kDegree) << side;
  }
}

TEST(Icp, finds_the_pose_in_space_against_both_surfaces)
{
  const auto map = map_of_room();
  const CPose3D truth(0.2, 0.1, 0, 0.1, 0, 0);
  CSimplePointsMap points_base;
  for (const auto& p : room())
  {
    const auto q = truth.inverseComposePoint(p);
    points_base.insertPoint(
        static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z));
  }
  for (const double side : {-1.0, 1.0})
  {
    const CPose3D off(0.25 * side, -0.17 * side, 0.05, 5 * side * kDegree, 0, 0);
    const CPose3D found = found_in_space(map, points_base, truth + off);
    EXPECT_LT(found.distanceTo(truth), 0.05) << side;
    EXPECT_LT(std::abs(found.yaw() - truth.yaw()), 0.5 * kDegree) << side;
  }
}
