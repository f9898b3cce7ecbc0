#pragma once
#include <opencv2/core.hpp>
#include <talus/io/layer_stack.h>

#include <string>
#include <vector>

namespace talus::io
{
/** What is written and drawn beside the layers. */
struct PictureOptions
{
  std::string title;  //!< in UTF-8, e.g. the name of the log and the time
  /** The robot in the map frame; drawn as an arrow when has_robot. */
  bool has_robot = false;
  /** Where it is [m], and its heading counter-clockwise from x [rad]. */
  double robot_x_m = 0, robot_y_m = 0, robot_yaw_rad = 0;
  /** Where it came along, map frame [m]; what lies outside of the map is not drawn. */
  std::vector<cv::Point2d> way;
  double driven_m = 0;  //!< all of it, also what `way` leaves out
};

/** "2014-11-10 11:34:12 UTC" of seconds since 1970; empty where a clock counts from elsewhere. */
std::string date_text(double stamp_s);

/** The picture a person looks at: large, the traversability over the shaded ground with the robot,
 * its way and axes in metres; small beside it, the other layers with their colour scales (those
 * without any value are only named). Without traversability the first layer is large. 8-bit BGR.
 * Throws std::runtime_error as LayerStack::require_sound() does. */
cv::Mat draw_map(const LayerStack& stack, const PictureOptions& options = {});

/** Writes any picture, whole or not at all. Throws std::runtime_error naming the file, why, and
 * what to do. */
void write_png(const std::string& path, const cv::Mat& picture);

/** draw_map() into a PNG, whole or not at all. Throws std::runtime_error naming the file and the
 * reason. */
void write_map_picture(
    const std::string& path, const LayerStack& stack, const PictureOptions& options = {});

/** A style of QGIS beside a GeoTIFF (SITE.qml for SITE.tif): QGIS opens it with the traversability
 * in the colours of the pictures. Throws as write_file(). */
void write_qgis_style(const std::string& path);

/** True when a file is there and holds anything but what write_qgis_style() writes: a person made
 * it or changed it, and it stays. Throws std::runtime_error when it cannot be read. */
bool is_users_qgis_style(const std::string& path);

}  // namespace talus::io
