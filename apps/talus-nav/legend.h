#pragma once
#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace talus::nav
{
/** How a thing is drawn in a picture. */
enum class Mark
{
  None,  //!< a word that heads a row
  Area,
  Ramp,  //!< from one colour to another
  Line,
  Dot,
  Cross,
  Robot,
  Bar  //!< of a length, as dark as the words
};

struct LegendItem
{
  Mark mark;
  std::string word;
  cv::Scalar colour = {}, colour_to = {};  //!< the second of Mark::Ramp
  int length_px = 26;
};

/** A white strip of this width with swatches and words: each group begins a row, and goes on in the
 * next where the width ends. */
cv::Mat draw_legend(int width_px, const std::vector<std::vector<LegendItem>>& groups);

/** A white strip with a line of text, made smaller where it would not fit. */
cv::Mat draw_title(int width_px, const std::string& text);

}  // namespace talus::nav
