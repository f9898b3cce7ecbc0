#pragma once
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/mrpt/obstacles.h>
#include <talus/sim/scanner.h>

#include <memory>
#include <string>
#include <vector>

namespace talus::nav
{
/** Where the obstacles of the planners come from. */
class MapSource
{
 public:
  virtual ~MapSource() = default;
  /** Takes a scan, its points in the sensor frame. */
  virtual void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double stamp_s) = 0;
  /** Obstacles in the robot frame, seen from above; of a robot made of these prisms, or of one in
   * the plane where there are none. */
  virtual void obstacles(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      mrpt::maps::CSimplePointsMap& out) = 0;
  /** Writes what is known around the robot into the costmap. */
  virtual void update_costmap(
      const mrpt::poses::CPose3D& T_map_base, mrpt::maps::COccupancyGridMap2D& grid) = 0;
  /** The map behind it, or nullptr. */
  virtual const ElevationMapper* terrain() const { return nullptr; }
};

/** talus: the map of this project. */
std::unique_ptr<MapSource> make_terrain_source(
    const Parameters& parameters, Backend backend, int threads, const ObstacleOptions& options);

/** Baseline: an OctoMap whose occupied voxels between two heights above the plane on which the
 * robot stands are obstacles. */
struct OctomapOptions
{
  double voxel_m = 0.1;
  double range_m = 6.0;  //!< farther points are left out
  double lowest_m = 0.12, highest_m = 0.8;  //!< above that plane
  int decimation = 2;  //!< takes one point of this many
};
std::unique_ptr<MapSource> make_octomap_source(const OctomapOptions& options);

}  // namespace talus::nav
