#include "picture_panel.h"
#include <talus/number_text.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace talus::io
{
namespace
{
constexpr int kTick = 5;  // length
constexpr int kBarGap = 10, kBarWidth = 12, kSwatchRow = 20;

const TextStyle kTickText{10, kInk, false, Anchor::Middle, Anchor::Start, false};
const TextStyle kSmallText{8, kInk, false, Anchor::Start, Anchor::Middle, false};
const TextStyle kPanelTitle{9, kInk, true, Anchor::Start, Anchor::End, false};

double step_of(const std::vector<double>& ticks)
{
  return ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
}

void draw_x_axis(Canvas& canvas, const Plot& plot)
{
  const cv::Rect& a = plot.area;
  const auto ticks = ticks_between(plot.min_x_m, plot.min_x_m + plot.width_m, a.width / 90);
  for (const double t : ticks)
  {
    const int x = cvRound(plot.pixel(t, 0).x);
    canvas.vertical(x, a.y + a.height, a.y + a.height + kTick, kInk);
    canvas.text(tick_text(t, step_of(ticks)), x, a.y + a.height + kTick + 6, kTickText);
  }
  TextStyle label = kTickText;
  label.colour = kFaintInk;
  canvas.text("x [m]", a.x + a.width / 2.0, a.y + a.height + kTick + 27, label);
}

void draw_y_axis(Canvas& canvas, const Plot& plot)
{
  const cv::Rect& a = plot.area;
  const auto ticks = ticks_between(plot.min_y_m, plot.min_y_m + plot.height_m, a.height / 90);
  TextStyle style = kTickText;
  style.across = Anchor::End;
  style.down = Anchor::Middle;
  double widest = 0;
  for (const double t : ticks)
  {
    const std::string text = tick_text(t, step_of(ticks));
    const int y = cvRound(plot.pixel(0, t).y) - 1;
    canvas.horizontal(a.x - 1 - kTick, a.x - 1, y, kInk);
    canvas.text(text, a.x - kTick - 6, y, style);
    widest = std::max(widest, Canvas::text_width(text, style));
  }
  style = kTickText;
  style.colour = kFaintInk;
  style.upwards = true;
  style.down = Anchor::End;
  canvas.text("y [m]", a.x - kTick - 14 - widest, a.y + a.height / 2.0, style);
}

/** A tip beyond an end of the scale says that some values lie beyond it, and how far. */
void draw_tip(
    Canvas& canvas, const cv::Rect& bar, bool above, const cv::Vec3b& colour,
    const std::string& words)
{
  const double y = above ? bar.y - 1 : bar.y + bar.height, tip = above ? y - 7 : y + 7;
  const cv::Scalar c(colour[0], colour[1], colour[2]);
  canvas.polygon(
      {{bar.x - 0.5, y}, {bar.x + bar.width - 0.5, y}, {bar.x + bar.width / 2.0 - 0.5, tip}}, c,
      kInk, 0.5);
  // Clear of a tick at the end of the scale.
  canvas.text(words, bar.x + bar.width + kTick + 4, above ? y - 9 : y + 9, kSmallText);
}

void draw_tips(
    Canvas& canvas, const cv::Rect& bar, const cv::Mat& colours, const ColourRange& range,
    double step)
{
  if (range.values_above)
    draw_tip(
        canvas, bar, true, colours.at<cv::Vec3b>(255), "up to " + tick_text(range.greatest, step));
  if (range.values_below)
    draw_tip(
        canvas, bar, false, colours.at<cv::Vec3b>(0), "down to " + tick_text(range.least, step));
}

void draw_colour_scale(
    Canvas& canvas, const cv::Rect& plot, const LayerStyle& style, const ColourRange& range)
{
  const int spare = 14;  // for the tips
  const int below = style.palette == Palette::Scores ? 2 * kSwatchRow : 0;  // for what has none
  const cv::Rect bar(
      plot.x + plot.width + kBarGap, plot.y + spare, kBarWidth, plot.height - 2 * spare - below);
  const cv::Mat colours = colours_of(style.palette);
  cv::Mat scale;
  cv::flip(colours, scale, 0);
  cv::resize(scale, scale, bar.size(), 0, 0, cv::INTER_LINEAR);
  canvas.paste(scale, bar.x, bar.y);
  canvas.frame(bar, kInk);
  const auto ticks = ticks_between(range.low, range.high, 4);
  draw_tips(canvas, bar, colours, range, step_of(ticks));
  for (const double t : ticks)
  {
    const double part = (t - range.low) / (range.high - range.low);
    const int y = bar.y + bar.height - 1 - static_cast<int>(std::lround(part * (bar.height - 1)));
    canvas.horizontal(bar.x + bar.width, bar.x + bar.width + kTick - 1, y, kInk);
    std::string words = tick_text(t, step_of(ticks));
    if (t == ticks.back() && !style.high_word.empty()) words += " " + style.high_word;
    if (t == ticks.front() && !style.low_word.empty()) words += " " + style.low_word;
    canvas.text(words, bar.x + bar.width + kTick + 4, y, kSmallText);
  }
}

void draw_swatch(Canvas& canvas, const cv::Point& corner, const NamedColour& colour)
{
  const cv::Rect swatch(corner, cv::Size(kBarWidth, kBarWidth));
  canvas.fill(swatch, bgr(colour.rgb));
  canvas.frame(swatch, kInk);
  canvas.text(
      colour.name, swatch.x + kBarWidth + kTick + 4, corner.y + kBarWidth / 2.0, kSmallText);
}

/** Cells without a score: of two kinds. */
void draw_no_score_legend(Canvas& canvas, const cv::Rect& plot)
{
  const cv::Point below(plot.x + plot.width + kBarGap, plot.y + plot.height - kBarWidth);
  draw_swatch(canvas, below, palette::kNotSeen);
  draw_swatch(canvas, below - cv::Point(0, kSwatchRow), palette::kNotJudged);
}

void draw_state_legend(Canvas& canvas, const cv::Rect& plot, const std::vector<float>& states)
{
  std::array<std::size_t, kCellStates> count{};
  for (const float s : states)
    ++count[s >= 1 && s < kCellStates ? static_cast<std::size_t>(s) : std::size_t{0}];
  TextStyle percent = kSmallText;
  percent.colour = kFaintInk;
  int y = plot.y + 1;
  for (const std::size_t i : {1, 2, 3, 4, 0})
  {
    const int left = plot.x + plot.width + kBarGap, x = left + kBarWidth + kTick + 4;
    draw_swatch(canvas, {left, y}, palette::kStates[i]);
    const double part = static_cast<double>(count[i]) / static_cast<double>(states.size());
    canvas.text(fixed_text(100 * part, 1) + " %", x, y + kBarWidth / 2.0 + 16, percent);
    y += 40;
  }
}

/** Cells in another size: none is dropped, and none gets twice the area of its neighbour. */
cv::Mat resized(const cv::Mat& cells, const cv::Size& size)
{
  const int whole = std::max(1, (size.width + cells.cols - 1) / cells.cols);
  cv::Mat large;
  cv::resize(cells, large, {}, whole, whole, cv::INTER_NEAREST);
  if (large.size() != size) cv::resize(large, large, size, 0, 0, cv::INTER_AREA);
  return large;
}
}  // namespace

Plot::Plot(const cv::Rect& area_, const LayerStack& stack)
    : area(area_),
      min_x_m(stack.min_x_m),
      min_y_m(stack.min_y_m),
      width_m(stack.cells_x * stack.resolution_m),
      height_m(stack.cells_y * stack.resolution_m)
{
}

cv::Point2d Plot::pixel(double x_m, double y_m) const
{
  return {
      area.x + (x_m - min_x_m) / width_m * area.width,
      area.y + area.height - (y_m - min_y_m) / height_m * area.height};
}

cv::Size plot_size(const LayerStack& stack, double wanted_px)
{
  const int longest = std::max(stack.cells_x, stack.cells_y);
  const double whole = std::floor(wanted_px / longest);  // pixels per cell
  const double scale = whole >= 3 ? whole : wanted_px / longest;
  const auto pixels = [&](int cells) {
    return std::max(static_cast<int>(wanted_px / 4), static_cast<int>(std::lround(cells * scale)));
  };
  return {pixels(stack.cells_x), pixels(stack.cells_y)};
}

void draw_cells(Canvas& canvas, const Plot& plot, const cv::Mat& cells)
{
  canvas.paste(resized(cells, plot.area.size()), plot.area.x, plot.area.y);
  canvas.frame(plot.area, kInk);
}

void draw_axes(Canvas& canvas, const Plot& plot)
{
  draw_x_axis(canvas, plot);
  draw_y_axis(canvas, plot);
}

void draw_robot_on(
    Canvas& canvas, const Plot& plot, const PictureOptions& options, double length_px)
{
  const cv::Point2d at = plot.pixel(options.robot_x_m, options.robot_y_m);
  if (options.has_robot && cv::Rect2d(plot.area).contains(at))
    draw_robot(canvas, at, options.robot_yaw_rad, length_px);
}

void say_when_empty(Canvas& canvas, const Plot& plot, const std::vector<float>& values)
{
  const auto known = [](float v) { return std::isfinite(v); };
  if (std::any_of(values.begin(), values.end(), known)) return;
  const TextStyle style{9, kFaintInk, false, Anchor::Middle, Anchor::Middle, false};
  const cv::Rect& a = plot.area;
  canvas.text("no cell has a value", a.x + a.width / 2.0, a.y + a.height / 4.0, style);
}

std::vector<double> ticks_between(double low, double high, int most)
{
  const double rough = (high - low) / std::max(1, most);
  const double ten = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = rough <= ten       ? ten
                      : rough <= 2 * ten ? 2 * ten
                      : rough <= 5 * ten ? 5 * ten
                                         : 10 * ten;
  std::vector<double> ticks;
  const double slack = 1e-6 * step;
  const double first = std::ceil((low - slack) / step);
  for (int i = 0; i <= std::max(1, most); ++i)
  {
    const double tick = (first + i) * step;
    if (!(tick <= high + slack)) break;
    if (!ticks.empty() && tick <= ticks.back()) break;  // numbers too large to tell apart
    ticks.push_back(tick);
  }
  return ticks;
}

std::string tick_text(double value, double step)
{
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  if (std::abs(value) < 1e-6 * step) value = 0;  // no "-0.0"
  return fixed_text(value, decimals);
}

void draw_panel(
    Canvas& canvas, const Plot& plot, const LayerStack& stack, const LayerStyle& style,
    const std::vector<float>& values, const ColourRange& range, const PictureOptions& options)
{
  constexpr double kRobot_px = 13;
  const bool has_colours = style.palette == Palette::Colours;
  cv::Mat cells = has_colours
                      ? paint_colours(stack, style.layer)
                      : paint_cells(values, stack.cells_x, stack.cells_y, style.palette, range);
  const bool has_scores = style.palette == Palette::Scores;
  const auto* states = stack.find(layer_name(Layer::State));
  if (has_scores && states) paint_not_judged(cells, values, *states);
  draw_cells(canvas, plot, cells);
  say_when_empty(canvas, plot, values);
  canvas.text(style.title, plot.area.x - 1, plot.area.y - 8, kPanelTitle);
  if (style.palette == Palette::States)
    draw_state_legend(canvas, plot.area, values);
  else if (!has_colours)
    draw_colour_scale(canvas, plot.area, style, range);
  if (has_scores) draw_no_score_legend(canvas, plot.area);
  draw_robot_on(canvas, plot, options, kRobot_px);
}

}  // namespace talus::io
