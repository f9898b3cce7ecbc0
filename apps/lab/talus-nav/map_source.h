#pragma once
#include "simulated_robot.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>
#include <talus/mrpt/observation_points.h>
#include <talus/nav/route.h>
#include <talus/sim/scanner.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace talus::nav
{
/** A way from the base on. */
struct Ahead
{
  double known_m;  //!< so far the ground is known
  double dared_m;  //!< and so far a robot goes slowly that counts on slopes where ground may drop
};

/** A place that blocks, robot frame seen from above. */
struct BlockedPlace
{
  double x_m, y_m;
  bool is_edge;  //!< the ground may end there
};

/** What there is around a robot, in its frame seen from above. */
struct Around
{
  mrpt::maps::CSimplePointsMap obstacles;  //!< for a reactive navigator
  std::vector<BlockedPlace> blocked;  //!< all places that block within a distance of the robot
};

/** Where the obstacles of the planners come from. */
class MapSource
{
 public:
  virtual ~MapSource() = default;
  /** Takes a scan, its points in the sensor frame. */
  virtual void insert(
      const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
      const mrpt::poses::CPose3D& T_base_sensor, double stamp_s) = 0;
  /** Looks around a robot made of these prisms, or of one in the plane where there are none. */
  virtual Around look(
      const mrpt::poses::CPose3D& T_map_base, const std::vector<double>& prism_heights_m,
      double within_m) = 0;
  /** What the ground does with the robot at a pose, [0, 1]; 1: it must not stand there, NaN: that
   * is not known. */
  virtual double ground_cost(const Pose2&) const { return NAN; }
  /** Writes what is known around the robot into the costmap. */
  virtual void update_costmap(const mrpt::poses::CPose3D& T_map_base, Costmap& costmap) = 0;
  /** Blocks what must have been seen by now and was not: not for good, it may be seen yet. */
  virtual void block_unseen(const mrpt::poses::CPose3D&, Costmap&) {}
  /** How far the ground is known on the way of a command, from the base on, in a corridor of this
   * width. */
  virtual Ahead ahead(
      const mrpt::poses::CPose3D&, double /*v_mps*/, double /*w_radps*/, double /*width_m*/)
  {
    return {HUGE_VAL, HUGE_VAL};
  }
  /** The map behind it, or nullptr. */
  virtual const ElevationMapper* terrain() const { return nullptr; }
};

/** Of talus and of its baselines: a scan, which stays the caller's, with its points in the sensor
 * frame. */
Frame frame_of(
    const sim::Scan& scan, const mrpt::poses::CPose3D& T_map_base,
    const mrpt::poses::CPose3D& T_base_sensor, double stamp_s);

/** talus: the map of this project. */
std::unique_ptr<MapSource> make_terrain_source(
    const Parameters& parameters, Backend backend, int threads, const ObstacleOptions& options,
    const RobotBody& body);

/** Baseline: an OctoMap whose occupied voxels between two heights above the plane on which the
 * robot stands are obstacles. */
std::unique_ptr<MapSource> make_octomap_source();

/** Baseline: an elevation map with one surface (libs/lab/baselines, "highest"); what it does not
 * know is no obstacle. */
std::unique_ptr<MapSource> make_onesurface_source(
    const Parameters& parameters, const ObstacleOptions& options);

/** MapSource::look() on a map with layers. */
Around look_around(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& options,
    const std::vector<double>& prism_heights_m, double within_m);

}  // namespace talus::nav
