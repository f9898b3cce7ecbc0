#pragma once
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <talus/io/layer_stack.h>

namespace octomap
{
class OcTree;
}

// A map of terrain as maps of other kinds. All take the layers of a window (io::snapshot()) or of a
// file (io::read_geotiff()), in the map frame, and throw std::runtime_error that names the layer
// which is missing.
namespace talus::formats
{
/** Replaces `out` by the cells of the map: occupied where the traversability is `blocked_at` [0,1]
 * or less, free where it is more, and 0.5 where it was not judged. */
void to_occupancy_grid(
    const io::LayerStack& map, double blocked_at, mrpt::maps::COccupancyGridMap2D& out);

/** What becomes points. */
enum class Surface
{
  Ground,  //!< the ground, measured cells only
  Standing  //!< what stands on the ground, as columns of points, one a cell's side
};

/** Appends a point in the middle of each cell [m]. */
void to_points(const io::LayerStack& map, Surface what, mrpt::maps::CPointsMap& out);

/** Adds the map to a tree whose voxels have the size of the cells: occupied where the ground or
 * something on it is, free from measured ground, on which nothing stands, up to `clearance_m` [m]:
 * what was hit lower than that above it would stand. Ground that is guessed from one side and was
 * not judged is unknown. What hangs higher is not kept by the map. For
 * an mrpt::maps::COctoMap give its getOctomap<octomap::OcTree>(). */
void to_octomap(const io::LayerStack& map, double clearance_m, octomap::OcTree& out);

}  // namespace talus::formats
