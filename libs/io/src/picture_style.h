#pragma once
#include <talus/io/layer_stack.h>
#include <talus/io/palette.h>

#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace talus::io
{
enum class Palette
{
  Heights,  //!< viridis, one scale for all heights: higher is lighter, also for the colour-blind
  Amounts,  //!< viridis: more is lighter
  Scores,  //!< score_colour()
  States,  //!< one colour for each CellState
  Colours  //!< those of three layers, of which the style names the red one
};

/** How one layer is shown. */
struct LayerStyle
{
  std::string layer;  //!< name in the stack
  std::string title;  //!< with the unit
  Palette palette = Palette::Amounts;
  std::string low_word, high_word;  //!< meaning of 0 and of 1, of scores
  bool square_root = false;  //!< a variance, shown as a standard deviation
};

/** Values that the ends of a colour scale stand for. */
struct ColourRange
{
  float low = 0, high = 1;
  bool values_below = false, values_above = false;  //!< some lie beyond the ends
  float least = 0, greatest = 1;  //!< of the values shown
};

/** As OpenCV orders it. */
inline cv::Vec3b bgr(const Rgb& c) { return {c[2], c[1], c[0]}; }

/** The layers of a stack in the order in which they are shown; red, green and blue are one. */
std::vector<LayerStyle> styles_of(const LayerStack& stack);

/** The values to show: those of the layer, or their square roots. */
std::vector<float> shown_values(const LayerStack& stack, const LayerStyle& style);

/** From the smallest to the largest value, but for the outermost 1 % of them, and at least
 * `least_span` wide. NaN is ignored. */
ColourRange robust_range(std::vector<float> values, float least_span);

/** The same scale with what is said of the values set for these. NaN is ignored. */
ColourRange range_for(ColourRange range, const std::vector<float>& values);

/** 256 colours from low to high, a column of one pixel each (256 x 1, BGR). */
cv::Mat colours_of(Palette palette);

/** Colours of a scale in sheets of many small maps: noise of a millimetre shows no more, and the
 * file is a third as large. */
inline constexpr int kFewColours = 12;

/** One pixel a cell, north up, cells without a value as palette::kNotSeen. */
cv::Mat paint_cells(
    const std::vector<float>& values, int cells_x, int cells_y, Palette palette,
    const ColourRange& range, int colour_count = 256);

/** The same of the colours of three layers, from 0 to 255, of which `red` is the first. */
cv::Mat paint_colours(const LayerStack& stack, const std::string& red);

/** Those cells of paint_cells() that have a state and no score become palette::kNotJudged. */
void paint_not_judged(
    cv::Mat& image, const std::vector<float>& values, const std::vector<float>& states);

}  // namespace talus::io
