#pragma once
#include <talus/formats/map_strips.h>
#include <talus/io/layer_stack.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// Files of other programs. Each takes the layers of a window, or of a site by strips, and is
// written whole or not at all; all throw std::runtime_error that names the file, or the layer which
// is missing.
namespace talus::formats
{
/** Throws, naming the file, where a layer that is there has a value that no map has: heights beyond
 * 1000 km, scores beyond 0 and 1, states that are none. A stranger's file may. */
void require_sound_cells(const io::LayerStack& map, const std::string& path);

/** What is taken off all coordinates of a file [m, map frame]. */
struct FileOrigin
{
  double x_m = 0, y_m = 0, z_m = 0;
};

/** How a map of ROS tells what is free. */
enum class RosMode
{
  Trinary,  //!< free, occupied or unknown, a .pgm
  Scale  //!< also how well a free cell drives: a .png, transparent where it is unknown
};

/** What is free. */
struct Occupancy
{
  double blocked_at = 0;  //!< cells of this traversability or less are occupied
  /** Free cells that hang together are closed where a square of this size holds them [m]: what is
   * smaller than the robot. 0: none. */
  double close_islands_m = 0;
};

/** What such a map says of each cell, as nav_msgs/OccupancyGrid has it: 0 free, 100 occupied, -1
 * unknown; rows from the south. */
std::vector<std::int8_t> ros_cells(const MapStrips& map, const Occupancy& occupancy);

/** A map of ROS's map_server and of Nav2: `path` is its .yaml, the picture lies beside it under the
 * same name. */
void write_ros_map(
    const std::string& path, const MapStrips& map, RosMode mode, const Occupancy& occupancy);

/** mrpt::maps::COccupancyGridMap2D as MRPT's programs read it: .gridmap.gz, to_occupancy_grid();
 * its borders are floats. */
void write_occupancy_grid(
    const std::string& path, const MapStrips& map, const Occupancy& occupancy,
    const FileOrigin& origin = FileOrigin());

/** Whole kilometres where a map lies so far away, in UTM say, that coordinates of 32 bit move in
 * steps of a millimetre or more; else 0. `frame`: its layers are not looked at. */
FileOrigin origin_for(const io::LayerStack& frame);

/** OctoMap's binary tree, .bt, see to_octomap(); a comment in its head names an origin that is not
 * 0. Cells are joined, 2 x 2 and so on, until the tree reaches as far as the map does, 32768 voxels
 * from its origin. What to tell of that, else "". */
std::string write_octomap(
    const std::string& path, const MapStrips& map, double clearance_m,
    const FileOrigin& origin = FileOrigin());

/** A binary .ply: the ground as a mesh in the colours of the traversability, a vertex a cell, and
 * what stands on it as boxes, one a cell. Cells are joined, 2 x 2 and so on, until the mesh
 * has no more than `max_faces`. The origin is in a comment of it, and in a .json beside it. */
void write_mesh(
    const std::string& path, const MapStrips& map, std::size_t max_faces,
    const FileOrigin& origin = FileOrigin());

/** grid_map_msgs/GridMap of ROS 2 with these layers of a map, serialized. Throws for a layer that
 * is not there. */
std::string grid_map_message(
    double stamp_s, const std::string& frame, const io::LayerStack& map,
    const std::vector<std::string>& layers);

/** A bag of ROS 2, .mcap, with the map as one message of /grid_map, frame "map": the layers of
 * `map`. Cells are joined, 2 x 2 and so on, until it has no more than 100 MB. What to tell of that,
 * else "". */
std::string write_grid_map(const std::string& path, const MapStrips& map, double stamp_s);

/** Where the picture of write_heightmap() lies in the map frame [m]. */
struct HeightmapPlace
{
  int side_pixels = 0;  //!< 2^n + 1
  double size_m = 0, height_m = 0;  //!< of the square, and from black to white
  double center_x_m = 0, center_y_m = 0, lowest_m = 0;  //!< of its middle, and of black
};

/** The ground as the square picture of 16 bit and 2^n + 1 pixels that Gazebo and game engines take,
 * north up; what is not known goes on as what lies beside it. At most 4097 pixels: a larger map
 * gets coarser. `path` is the .png; a .json beside it tells what is returned. */
HeightmapPlace write_heightmap(const std::string& path, const MapStrips& map);

}  // namespace talus::formats
