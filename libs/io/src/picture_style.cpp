#include "picture_style.h"

#include <talus/io/quantile.h>
#include <talus/layers.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace talus::io
{
namespace
{
/** By LayerKind. */
constexpr Palette kPalettes[] = {
    Palette::Heights, Palette::Amounts, Palette::States, Palette::Scores, Palette::Amounts};

LayerStyle style_of(const std::string& name)
{
  const LayerInfo* known = find_layer(name);
  if (!known) return {name, name, Palette::Amounts, "", "", false};
  const LayerInfo& l = *known;
  return {
      name,        l.title ? l.title : name,     kPalettes[static_cast<int>(l.kind)], l.low_word,
      l.high_word, l.kind == LayerKind::Variance};
}

/** Those of channels come last, amounts before them. */
std::pair<int, std::ptrdiff_t> rank_of(const LayerStyle& style)
{
  const LayerInfo* known = find_layer(style.layer);
  if (!known) return {2, 0};
  return {style.palette == Palette::Amounts ? 1 : 0, known - kLayerTable};
}

cv::Mat score_colours()
{
  cv::Mat colours(256, 1, CV_8UC3);
  for (int i = 0; i < 256; ++i)
    colours.at<cv::Vec3b>(i) = bgr(score_colour(static_cast<float>(i) / 255));
  return colours;
}

cv::Mat opencv_colours(int map)
{
  cv::Mat grey(256, 1, CV_8U), colours;
  for (int i = 0; i < 256; ++i) grey.at<uchar>(i) = static_cast<uchar>(i);
  cv::applyColorMap(grey, colours, map);
  return colours;
}
constexpr std::array<const char*, 3> kColours{"red", "green", "blue"};

/** The layers of red, green and blue become one. */
void join_colours(std::vector<LayerStyle>& styles)
{
  for (const auto& [ending, title] :
       {std::pair{"", "colour"}, std::pair{"_standing", "colour of what stands"}})
  {
    const auto place_of = [&, end = std::string(ending)](const char* colour)
    {
      return std::find_if(
          styles.begin(), styles.end(),
          [&](const LayerStyle& s) { return s.layer == colour + end; });
    };
    const auto is_there = [&](const char* colour) { return place_of(colour) != styles.end(); };
    if (!std::all_of(kColours.begin(), kColours.end(), is_there)) continue;
    for (const char* joined : {kColours[1], kColours[2]}) styles.erase(place_of(joined));
    LayerStyle& red = *place_of(kColours[0]);
    red.title = title;
    red.palette = Palette::Colours;
  }
}
}  // namespace

std::vector<LayerStyle> styles_of(const LayerStack& stack)
{
  std::vector<LayerStyle> styles;
  for (const auto& name : stack.names) styles.push_back(style_of(name));
  std::stable_sort(
      styles.begin(), styles.end(),
      [](const LayerStyle& a, const LayerStyle& b) { return rank_of(a) < rank_of(b); });
  join_colours(styles);
  return styles;
}

std::vector<float> shown_values(const LayerStack& stack, const LayerStyle& style)
{
  std::vector<float> values = *stack.find(style.layer);
  if (style.square_root)
    for (float& v : values) v = std::sqrt(v);
  return values;
}

ColourRange robust_range(std::vector<float> values, float least_span)
{
  const auto unknown = [](float v) { return !std::isfinite(v); };
  values.erase(std::remove_if(values.begin(), values.end(), unknown), values.end());
  if (values.empty()) return {};
  ColourRange range;
  range.low = quantile(values, 0.01);
  range.high = quantile(values, 0.99);
  const float missing = least_span - (range.high - range.low);
  if (missing > 0)
  {
    range.low -= missing / 2;
    range.high += missing / 2;
  }
  return range_for(range, values);
}

ColourRange range_for(ColourRange range, const std::vector<float>& values)
{
  range.least = range.high;
  range.greatest = range.low;
  for (const float v : values)
    if (std::isfinite(v))
    {
      range.least = std::min(range.least, v);
      range.greatest = std::max(range.greatest, v);
    }
  range.values_below = range.least < range.low;
  range.values_above = range.greatest > range.high;
  return range;
}

cv::Mat colours_of(Palette palette)
{
  switch (palette)
  {
    case Palette::Scores:
      return score_colours();
    default:
      return opencv_colours(cv::COLORMAP_VIRIDIS);
  }
}

cv::Mat paint_cells(
    const std::vector<float>& values, int cells_x, int cells_y, Palette palette,
    const ColourRange& range, int colour_count)
{
  const cv::Mat colours = colours_of(palette);
  const float last = static_cast<float>(colour_count - 1);
  cv::Mat image(cells_y, cells_x, CV_8UC3, bgr(palette::kNotSeen.rgb));
  for (int iy = 0; iy < cells_y; ++iy)
    for (int ix = 0; ix < cells_x; ++ix)
    {
      const float v = values[static_cast<std::size_t>(iy) * cells_x + ix];
      if (!std::isfinite(v)) continue;
      auto& pixel = image.at<cv::Vec3b>(cells_y - 1 - iy, ix);
      if (palette == Palette::States)
      {
        pixel =
            bgr(palette::kStates[v >= 1 && v < kCellStates ? static_cast<std::size_t>(v) : 0].rgb);
        continue;
      }
      const float part = (v - range.low) / (range.high - range.low);
      const float step = std::round(last * std::min(1.0F, std::max(0.0F, part)));
      pixel = colours.at<cv::Vec3b>(static_cast<int>(std::lround(255 * (step / last))));
    }
  return image;
}

cv::Mat paint_colours(const LayerStack& stack, const std::string& red)
{
  const std::string ending = red.substr(std::string(kColours[0]).size());
  cv::Mat image(stack.cells_y, stack.cells_x, CV_8UC3, bgr(palette::kNotSeen.rgb));
  for (int i = 0; i < image.rows * image.cols; ++i)
  {
    cv::Vec3b colour;
    bool is_known = true;
    for (std::size_t k = 0; k < kColours.size(); ++k)
    {
      const float v = (*stack.find(kColours[k] + ending))[static_cast<std::size_t>(i)];
      is_known = is_known && std::isfinite(v);
      if (is_known)
        colour[static_cast<int>(2 - k)] =
            static_cast<uchar>(std::lround(std::clamp(v, 0.0F, 255.0F)));
    }
    if (is_known) image.at<cv::Vec3b>(image.rows - 1 - i / image.cols, i % image.cols) = colour;
  }
  return image;
}

void paint_not_judged(
    cv::Mat& image, const std::vector<float>& values, const std::vector<float>& states)
{
  for (int i = 0; i < image.rows * image.cols; ++i)
    if (const auto k = static_cast<std::size_t>(i); std::isnan(values[k]) && states[k] >= 1)
      image.at<cv::Vec3b>(image.rows - 1 - i / image.cols, i % image.cols) =
          bgr(palette::kNotJudged.rgb);
}

}  // namespace talus::io
