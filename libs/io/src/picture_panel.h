#pragma once
#include <talus/io/map_picture.h>

#include "picture_canvas.h"
#include "picture_legend.h"
#include "picture_style.h"

#include <string>
#include <vector>

namespace talus::io
{
/** The area of a map on a picture. */
struct Plot
{
  cv::Rect area;
  double min_x_m = 0, min_y_m = 0, width_m = 0, height_m = 0;

  Plot(const cv::Rect& area_, const LayerStack& stack);
  /** Of a place of the map frame. */
  cv::Point2d pixel(double x_m, double y_m) const;
};

/** How large the cells of a stack are drawn so that their longer side has about `wanted_px`. */
cv::Size plot_size(const LayerStack& stack, double wanted_px);

/** Cells (a pixel each) in the size of the plot, with a frame. */
void draw_cells(Canvas& canvas, const Plot& plot, const cv::Mat& cells);
/** Ticks in metres, left and below. */
void draw_axes(Canvas& canvas, const Plot& plot);
/** The robot as `length_px` if it is on the plot. */
void draw_robot_on(
    Canvas& canvas, const Plot& plot, const PictureOptions& options, double length_px);
void say_when_empty(Canvas& canvas, const Plot& plot, const std::vector<float>& values);

constexpr int kScaleRoom_px = 134;  //!< right of a small panel, for what its colours mean

/** One layer with its title, robot and colour scale, small. `values` as shown_values(). */
void draw_panel(
    Canvas& canvas, const Plot& plot, const LayerStack& stack, const LayerStyle& style,
    const std::vector<float>& values, const ColourRange& range, const PictureOptions& options);

/** Round numbers (1, 2 or 5 times a power of ten apart) from low to high, at most `most` + 1. */
std::vector<double> ticks_between(double low, double high, int most);

/** The number with as many decimals as ticks `step` apart need. */
std::string tick_text(double value, double step);

}  // namespace talus::io
