#pragma once
#include <talus/io/layer_stack.h>

#include "picture_canvas.h"

namespace talus::io
{
/** Of two colours. */
cv::Vec3b mixed(const cv::Vec3b& a, const cv::Vec3b& b, float part_b);
/** A colour in a light as hill_shade() tells it: level ground keeps its colour. */
cv::Vec3b lit(const cv::Vec3b& colour, float shade);

/** Light from the upper left on a ground, 0..1, as a level ground has it where the ground is
 * unknown. Small roughness is smoothed away. */
cv::Mat1f hill_shade(const cv::Mat1f& ground_m, double pixel_m);
/** From how far the ground changes the light of a pixel [pixels]. */
int reach_of_shade(double pixel_m);

/** A piece of ground as pictures show it; row 0 is its north. Unknown is NaN and 0. */
struct Terrain
{
  cv::Mat1f ground_m;
  cv::Mat1f score;  //!< traversability
  cv::Mat1b obstacle;  //!< whether something stands there
  cv::Mat1b measured;  //!< 0: unknown, 1: only filled, or not reached, 2: measured
};

/** Of a map with a traversability; without one of the other layers, as on level, measured ground
 * without objects. `is_part`: of a map of which some cell is reached, even if none of these is. */
Terrain terrain_of(const LayerStack& stack, bool is_part = false);

constexpr double kMinObstacle_m = 0.05;  //!< lower than that it is a rough ground

/** The shaded ground in the colours of its traversability, pale where it was not measured or is
 * not reached, dark where something stands in the way; see add_terrain() for a legend. */
cv::Mat3b paint_terrain(const Terrain& terrain, double pixel_m);

}  // namespace talus::io
