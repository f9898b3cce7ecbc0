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
constexpr int kBarGap = 16, kBarWidth = 18, kSwatchRow = 26;

const TextStyle kTickText{10, kInk, false, Anchor::Middle, Anchor::Start, false};
const TextStyle kTitleText{13, kInk, true, Anchor::Start, Anchor::End, false};

double step_of(const std::vector<double>& ticks)
{
  return ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
}

void draw_x_axis(Canvas& canvas, const cv::Rect& plot, const LayerStack& s)
{
  const double width_m = s.cells_x * s.resolution_m;
  const auto ticks = ticks_between(s.min_x_m, s.min_x_m + width_m, plot.width / 70);
  for (const double t : ticks)
  {
    const int x = plot.x + static_cast<int>(std::lround((t - s.min_x_m) / width_m * plot.width));
    canvas.vertical(x, plot.y + plot.height, plot.y + plot.height + kTick, kInk);
    canvas.text(tick_text(t, step_of(ticks)), x, plot.y + plot.height + kTick + 6, kTickText);
  }
  TextStyle label = kTickText;
  label.colour = kFaintInk;
  canvas.text("x [m]", plot.x + plot.width / 2.0, plot.y + plot.height + kTick + 27, label);
}

void draw_y_axis(Canvas& canvas, const cv::Rect& plot, const LayerStack& s)
{
  const double height_m = s.cells_y * s.resolution_m;
  const auto ticks = ticks_between(s.min_y_m, s.min_y_m + height_m, plot.height / 70);
  TextStyle style = kTickText;
  style.across = Anchor::End;
  style.down = Anchor::Middle;
  double widest = 0;
  for (const double t : ticks)
  {
    const std::string text = tick_text(t, step_of(ticks));
    const double part = (t - s.min_y_m) / height_m;
    const int y = plot.y + plot.height - 1 - static_cast<int>(std::lround(part * plot.height));
    canvas.horizontal(plot.x - 1 - kTick, plot.x - 1, y, kInk);
    canvas.text(text, plot.x - kTick - 6, y, style);
    widest = std::max(widest, Canvas::text_width(text, style));
  }
  style = kTickText;
  style.colour = kFaintInk;
  style.upwards = true;
  style.down = Anchor::End;
  canvas.text("y [m]", plot.x - kTick - 14 - widest, plot.y + plot.height / 2.0, style);
}

/** A tip beyond an end of the scale says that some values lie beyond it, and how far. */
void draw_tip(
    Canvas& canvas, const cv::Rect& bar, bool above, const cv::Vec3b& colour,
    const std::string& words)
{
  const double y = above ? bar.y - 1 : bar.y + bar.height, tip = above ? y - 11 : y + 11;
  const cv::Scalar c(colour[0], colour[1], colour[2]);
  canvas.polygon(
      {{bar.x - 0.5, y}, {bar.x + bar.width - 0.5, y}, {bar.x + bar.width / 2.0 - 0.5, tip}}, c,
      kInk, 0.5);
  const TextStyle text{10, kInk, false, Anchor::Start, Anchor::Middle, false};
  // Clear of a tick at the end of the scale.
  canvas.text(words, bar.x + bar.width + kTick + 6, above ? y - 17 : y + 17, text);
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
  const int spare = 12;  // for the tips
  const int below = style.palette == Palette::Scores ? 2 * kSwatchRow : 0;  // for what has none
  const cv::Rect bar(
      plot.x + plot.width + kBarGap, plot.y + spare, kBarWidth, plot.height - 2 * spare - below);
  const cv::Mat colours = colours_of(style.palette);
  cv::Mat scale;
  cv::flip(colours, scale, 0);
  cv::resize(scale, scale, bar.size(), 0, 0, cv::INTER_LINEAR);
  canvas.paste(scale, bar.x, bar.y);
  canvas.frame(bar, kInk);
  const auto ticks = ticks_between(range.low, range.high, std::max(4, bar.height / 60));
  draw_tips(canvas, bar, colours, range, step_of(ticks));
  TextStyle text = kTickText;
  text.across = Anchor::Start;
  text.down = Anchor::Middle;
  for (const double t : ticks)
  {
    const double part = (t - range.low) / (range.high - range.low);
    const int y = bar.y + bar.height - 1 - static_cast<int>(std::lround(part * (bar.height - 1)));
    canvas.horizontal(bar.x + bar.width, bar.x + bar.width + kTick - 1, y, kInk);
    std::string words = tick_text(t, step_of(ticks));
    if (t == ticks.back() && !style.high_word.empty()) words += " " + style.high_word;
    if (t == ticks.front() && !style.low_word.empty()) words += " " + style.low_word;
    canvas.text(words, bar.x + bar.width + kTick + 6, y, text);
  }
}

void draw_swatch(
    Canvas& canvas, const cv::Point& corner, const cv::Vec3b& colour, const std::string& words)
{
  const cv::Rect swatch(corner, cv::Size(kBarWidth, kBarWidth));
  canvas.fill(swatch, cv::Scalar(colour[0], colour[1], colour[2]));
  canvas.frame(swatch, kInk);
  TextStyle word = kTickText;
  word.across = Anchor::Start;
  word.down = Anchor::Middle;
  canvas.text(words, swatch.x + kBarWidth + kTick + 4, corner.y + kBarWidth / 2.0, word);
}

/** Cells without a score: of two kinds. */
void draw_no_score_legend(Canvas& canvas, const cv::Rect& plot)
{
  const cv::Point below(plot.x + plot.width + kBarGap, plot.y + plot.height - kBarWidth);
  draw_swatch(canvas, below, state_styles()[0].colour, "no data");
  draw_swatch(canvas, below - cv::Point(0, kSwatchRow), not_judged_colour(), "not judged");
}

void draw_state_legend(Canvas& canvas, const cv::Rect& plot, const std::vector<float>& states)
{
  std::array<std::size_t, kCellStates> count{};
  for (const float s : states)
    ++count[s >= 1 && s < kCellStates ? static_cast<std::size_t>(s) : std::size_t{0}];
  TextStyle percent = kTickText;
  percent.across = Anchor::Start;
  percent.down = Anchor::Middle;
  percent.colour = kFaintInk;
  int y = plot.y + 1;
  for (const std::size_t i : {1, 2, 3, 4, 0})
  {
    const auto& style = state_styles()[i];
    const int left = plot.x + plot.width + kBarGap, x = left + kBarWidth + kTick + 4;
    draw_swatch(canvas, {left, y}, style.colour, style.word);
    const double part = static_cast<double>(count[i]) / static_cast<double>(states.size());
    canvas.text(fixed_text(100 * part, 1) + " %", x, y + kBarWidth / 2.0 + 20, percent);
    y += 54;
  }
}

void say_when_empty(Canvas& canvas, const cv::Rect& plot, const std::vector<float>& values)
{
  const auto known = [](float v) { return std::isfinite(v); };
  if (std::any_of(values.begin(), values.end(), known)) return;
  const TextStyle style{10, kFaintInk, false, Anchor::Middle, Anchor::Middle, false};
  canvas.text("no cell has a value", plot.x + plot.width / 2.0, plot.y + plot.height / 4.0, style);
}
}  // namespace

cv::Size plot_size(const LayerStack& stack)
{
  constexpr double kWanted = 480, kMost = 720;
  const int longest = std::max(stack.cells_x, stack.cells_y);
  const double whole = std::max(1.0, std::round(kWanted / longest));
  const double scale = longest * whole > kMost ? kMost / longest : whole;
  const auto pixels = [&](int cells) { return std::max(120, static_cast<int>(cells * scale)); };
  return {pixels(stack.cells_x), pixels(stack.cells_y)};
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

void draw_robot(Canvas& canvas, cv::Point2d middle, double yaw_rad, double length_px)
{
  const cv::Point2d ahead(std::cos(yaw_rad), -std::sin(yaw_rad)), left(ahead.y, -ahead.x);
  const double l = length_px;
  canvas.polygon(
      {middle + ahead * (0.55 * l), middle - ahead * (0.45 * l) + left * (0.36 * l),
       middle - ahead * (0.25 * l), middle - ahead * (0.45 * l) - left * (0.36 * l)},
      cv::Scalar(255, 255, 255), cv::Scalar(0, 0, 0), 1.5);
}

void draw_panel(
    Canvas& canvas, cv::Point corner, const LayerStack& stack, const LayerStyle& style,
    const std::vector<float>& values, const ColourRange& range, const PictureOptions& options)
{
  const PanelMargins margins;
  const cv::Rect plot(corner + cv::Point(margins.left, margins.top), plot_size(stack));
  cv::Mat cells = paint_cells(values, stack.cells_x, stack.cells_y, style.palette, range);
  const bool has_scores = style.palette == Palette::Scores;
  const auto* states = stack.find(layer_name(Layer::State));
  if (has_scores && states) paint_not_judged(cells, values, *states);
  cv::resize(cells, cells, plot.size(), 0, 0, cv::INTER_NEAREST);
  canvas.paste(cells, plot.x, plot.y);
  canvas.frame(plot, kInk);
  say_when_empty(canvas, plot, values);
  canvas.text(style.title, plot.x - 1, plot.y - 12, kTitleText);
  draw_x_axis(canvas, plot, stack);
  draw_y_axis(canvas, plot, stack);
  if (style.palette == Palette::States)
    draw_state_legend(canvas, plot, values);
  else
    draw_colour_scale(canvas, plot, style, range);
  if (has_scores) draw_no_score_legend(canvas, plot);

  // Not the same both ways where a long and narrow map is drawn wider.
  const double px_per_m_x = plot.width / (stack.cells_x * stack.resolution_m);
  const double px_per_m_y = plot.height / (stack.cells_y * stack.resolution_m);
  const cv::Point2d robot(
      plot.x + (options.robot_x_m - stack.min_x_m) * px_per_m_x,
      plot.y + plot.height - (options.robot_y_m - stack.min_y_m) * px_per_m_y);
  if (options.has_robot && cv::Rect2d(plot).contains(robot))
    draw_robot(canvas, robot, options.robot_yaw_rad, 20);
}

}  // namespace talus::io
