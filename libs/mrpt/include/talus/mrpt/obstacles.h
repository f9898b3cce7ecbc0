#pragma once
#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <talus/mrpt/observation_points.h>
#include <talus/nav/obstacles.h>

#include <string>
#include <vector>

namespace talus
{
using nav::Drops, nav::Passage, nav::Unseen;
using nav::find_doubtful, nav::stopping_speed_mps;

/** nav::ObstacleOptions of an INI file. */
struct ObstacleOptions : public nav::ObstacleOptions, public mrpt::config::CLoadableOptions
{
  /** Reads those keys that are there. Throws std::runtime_error naming key, value and section. */
  void loadFromConfigFile(
      const mrpt::config::CConfigFileBase& source, const std::string& section) override;
  /** Writes each with its meaning as comment. */
  void saveToConfigFile(
      mrpt::config::CConfigFileBase& target, const std::string& section) const override;
};

/** nav::classify_cells() for a pose of MRPT. */
inline std::vector<Passage> classify_cells(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const ObstacleOptions& o)
{
  return nav::classify_cells(map, pose_from(T_map_base), o);
}

/** nav::find_edges() for a pose of MRPT. */
inline std::vector<bool> find_edges(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const std::vector<Passage>& cells)
{
  return nav::find_edges(map, pose_from(T_map_base), cells);
}

/** nav::known_ahead_m() for a pose of MRPT. */
inline double known_ahead_m(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, double v_mps, double w_radps,
    double width_m, const ObstacleOptions& o)
{
  return nav::known_ahead_m(map, pose_from(T_map_base), v_mps, w_radps, width_m, o);
}

/** Replaces `out` by the obstacles of the map for CReactiveNavigationSystem: nav::find_obstacles()
 * of a robot in the plane. */
void obstacles_2d(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    mrpt::maps::CSimplePointsMap& out);
/** The same of cells that classify_cells() judged already. */
void obstacles_2d(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<Passage>& cells, mrpt::maps::CSimplePointsMap& out);

/** The same for CReactiveNavigationSystem3D, whose robot is a pile of prisms of these heights [m],
 * the lowest first. */
void obstacles_3d(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<double>& prism_heights_m, mrpt::maps::CSimplePointsMap& out);
/** The same of cells that classify_cells() judged already. */
void obstacles_3d(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    const std::vector<Passage>& cells, const std::vector<double>& prism_heights_m,
    mrpt::maps::CSimplePointsMap& out);

/** Makes `out` a costmap of the window in the map frame, for mrpt::nav::PlannerSimple2D: with
 * the probabilities of nav::free_probabilities(), 0.5 where nothing is known (which that planner
 * takes for an obstacle). Throws
 * std::invalid_argument where the window lies so far from the origin (8 km for cells of 0.05 m)
 * that the borders of a costmap, which are floats, cannot be those of its cells.
 */
void costmap_from_map(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    mrpt::maps::COccupancyGridMap2D& out);

/** nav::update_costmap(). Throws std::invalid_argument when the cells do not match. */
void update_costmap(
    const MapView& map, const mrpt::poses::CPose3D& T_map_base, const nav::ObstacleOptions& o,
    mrpt::maps::COccupancyGridMap2D& grid);

/** nav::admit_doubtful(). */
void admit_doubtful(mrpt::maps::COccupancyGridMap2D& grid);

}  // namespace talus
