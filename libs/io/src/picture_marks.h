#pragma once
#include "picture_canvas.h"

#include <vector>

namespace talus::io
{
/** The arrow that stands for the robot, `length_px` long, with its middle at a point; `yaw_rad`
 * counter-clockwise from the right. */
void draw_robot(Canvas& canvas, cv::Point2d middle, double yaw_rad, double length_px);

/** Ways with a bright edge, a ring where each begins and a square where it ends. */
void draw_ways(
    Canvas& canvas, const std::vector<std::vector<cv::Point2d>>& ways, double width_px,
    double mark_px);
/** The line alone. */
void draw_way_line(Canvas& canvas, const std::vector<cv::Point2d>& way, double width_px);

/** An arrow with the letter at its tip; `turn_rad` counter-clockwise from upwards. */
void draw_north(
    Canvas& canvas, cv::Point2d middle, double turn_rad, double length_px,
    const std::string& letter);

/** Black and white, `length_px` long. */
void draw_scale_bar(Canvas& canvas, cv::Point corner, int length_px, int height_px);

/** A round length (1, 2 or 5 times a power of ten) that is at most `longest_m`. */
double round_length_m(double longest_m);
/** "20 m", "5 km". */
std::string length_text(double length_m);

}  // namespace talus::io
