#pragma once
#include <talus/io/map_picture.h>

#include "picture_canvas.h"
#include "picture_style.h"

#include <string>
#include <vector>

namespace talus::io
{
/** Room around the cells of a panel, pixels. */
struct PanelMargins
{
  int left = 84, right = 176, top = 44, bottom = 60;
};

/** How large the cells of every panel are drawn, pixels. */
cv::Size plot_size(const LayerStack& stack);

/** One layer with its title, axes, robot and colour scale; `corner` is the upper left corner of the
 * margins. `values` as shown_values(). */
void draw_panel(
    Canvas& canvas, cv::Point corner, const LayerStack& stack, const LayerStyle& style,
    const std::vector<float>& values, const ColourRange& range, const PictureOptions& options);

/** The arrow that stands for the robot, `length_px` long, with its middle at a point; `yaw_rad`
 * counter-clockwise from the right. */
void draw_robot(Canvas& canvas, cv::Point2d middle, double yaw_rad, double length_px);

/** Round numbers (1, 2 or 5 times a power of ten apart) from low to high, at most `most` + 1. */
std::vector<double> ticks_between(double low, double high, int most);

/** The number with as many decimals as ticks `step` apart need. */
std::string tick_text(double value, double step);

}  // namespace talus::io
