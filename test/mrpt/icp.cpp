// mrpt::slam::CICP finds a pose in the plane against what stands in the terrain map; in space does
// apps/examples/07_localize.cpp.
#include <gtest/gtest.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CICP.h>

#include <cmath>

#include "room_for_maps.h"

using namespace talus_test;
using mrpt::poses::CPose2D;
using mrpt::slam::CICP;

TEST(Icp, finds_the_pose_in_the_plane_against_what_stands)
{
  constexpr double kDegree = M_PI / 180;
  const auto map = map_of_room();
  const CPose3D truth(0.2, 0.1, 0, 0.1, 0, 0);
  CDualElevationMap scan(map.mapper().parameters(), talus::Backend::Cpu);
  ASSERT_TRUE(scan.insertObservation(scan_of_room(truth), CPose3D()));
  CICP::TConfigParams o;
  o.maxIterations = 200;
  o.thresholdDist = 0.6;
  o.thresholdAng = 0;
  o.smallestThresholdDist = 0.05;
  o.corresponding_points_decimation = 1;
  o.skip_cov_calculation = true;
  CICP icp(o);
  mrpt::slam::CMetricMapsAlignmentAlgorithm& align = icp;
  for (const double side : {-1.0, 1.0})
  {
    const CPose2D guess(
        truth.x() + 0.25 * side, truth.y() - 0.17 * side, truth.yaw() + 5 * side * kDegree);
    const CPose2D found =
        align.AlignPDF(&map, &scan.standingPoints(), mrpt::poses::CPosePDFGaussian(guess))
            ->getMeanVal();
    EXPECT_LT(found.distance2DTo(truth.x(), truth.y()), 0.05) << side;
    EXPECT_LT(std::abs(found.phi() - truth.yaw()), 1 * kDegree) << side;
  }
}
