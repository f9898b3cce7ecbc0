#pragma once
#include <talus/io/layer_stack.h>

#include <opencv2/core.hpp>

#include <vector>

namespace talus::pictures
{
/** From where a piece of ground is seen, map frame. */
struct Camera
{
  cv::Vec3d eye_m, target_m;
  double focal_px = 1000;
  cv::Size size;

  /** Where a place is seen, and how far ahead; nothing useful where that is not positive. */
  cv::Vec3d pixel(const cv::Vec3d& p_m) const;
};

/** A robot that is drawn as a box with an arrow on its roof. */
struct RobotBox
{
  cv::Point2d at_m;
  double yaw_rad = 0, length_m = 4, width_m = 1.8, height_m = 1.5;
};

/** The ground and what stands on it, coloured by traversability as on the other pictures, with the
 * way as a band and the robot at its end. Layers as of a map. */
cv::Mat draw_oblique(
    const io::LayerStack& map, const Camera& camera, const std::vector<cv::Point2d>& way,
    const RobotBox& robot);

}  // namespace talus::pictures
