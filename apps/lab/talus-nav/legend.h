#pragma once
#include <picture_canvas.h>

#include <string>
#include <vector>

namespace talus::nav
{
/** How a thing is drawn in a picture. */
enum class Mark
{
  None,  //!< a word that heads a row
  Area,
  Ramp,
  Line,
  Hatching,
  Dot,
  Cross,
  Robot
};

struct LegendItem
{
  Mark mark;
  std::string word;
  cv::Scalar colour = {};
  cv::Mat ramp = {};  //!< of Mark::Ramp: its colours from low to high, a column of one pixel each
};

/** A way: a line with an edge, so that it shows on every ground. */
void draw_way(
    io::Canvas& canvas, const std::vector<cv::Point2d>& way, const cv::Scalar& colour,
    const cv::Scalar& edge);

/** A cross with an edge. */
void draw_cross(io::Canvas& canvas, const cv::Point2d& middle);

/** Every fourth diagonal of the pixels, which are then darker. */
bool is_hatched(int x, int y);

/** A white strip of this width with swatches and words: each group begins a row, and goes on in the
 * next where the width ends. */
cv::Mat draw_legend(int width_px, const std::vector<std::vector<LegendItem>>& groups);

/** A white strip with a line of text, made smaller where it would not fit. */
cv::Mat draw_title(int width_px, const std::string& text);

}  // namespace talus::nav
