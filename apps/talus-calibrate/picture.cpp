#include "outputs.h"

#include <talus/io/map_picture.h>

#include <picture_canvas.h>
#include <picture_panel.h>
#include <picture_style.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace talus::calibrate
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::TextStyle;

constexpr int kPlotWidth = 520, kPlotHeight = 340, kTop = 130, kLeft = 90, kStep = 660;
const cv::Scalar kBeforeColour = io::kFaintInk, kAfterColour(io::bgr(io::palette::kPath.rgb));

/** One diagram: a quantity over the range. */
struct Plot
{
  int x, y;
  double low, high, far_m;

  double px(double range_m) const { return x + range_m / far_m * kPlotWidth; }
  double py(double value) const
  {
    return y + (1 - (std::clamp(value, low, high) - low) / (high - low)) * kPlotHeight;
  }
};

void draw_axes(Canvas& canvas, const Plot& p, const std::string& title)
{
  const TextStyle small{9, io::kFaintInk, false, Anchor::Middle, Anchor::Start, false};
  TextStyle left = small;
  left.across = Anchor::End;
  left.down = Anchor::Middle;
  canvas.frame({p.x, p.y, kPlotWidth, kPlotHeight}, io::kInk);
  canvas.text(title, p.x, p.y - 22, {12, io::kInk, true, Anchor::Start, Anchor::Middle, false});
  const auto heights = io::ticks_between(p.low, p.high, 6);
  for (const double v : heights)
  {
    const int y = static_cast<int>(std::lround(p.py(v)));
    canvas.horizontal(p.x, p.x + kPlotWidth - 1, y, io::kGridInk);
    canvas.text(io::tick_text(v, heights[1] - heights[0]), p.x - 8, y, left);
  }
  const auto ranges = io::ticks_between(0, p.far_m, 8);
  for (const double r : ranges)
    canvas.text(io::tick_text(r, ranges[1] - ranges[0]), p.px(r), p.y + kPlotHeight + 8, small);
  canvas.text("range [m]", p.x + kPlotWidth / 2.0, p.y + kPlotHeight + 30, small);
}

/** A line through the middles of the bins, with a square at each. */
void draw_line(
    Canvas& canvas, const Plot& p, const std::vector<RangeBin>& bins, double RangeBin::*value,
    const cv::Scalar& colour)
{
  std::vector<cv::Point2d> middles;
  for (const RangeBin& bin : bins)
  {
    const cv::Point2d at(p.px((bin.from_m + bin.to_m) / 2), p.py(1000 * (bin.*value)));
    middles.push_back(at);
    canvas.fill({cv::Point(at) - cv::Point(4, 4), cv::Size(9, 9)}, colour);
  }
  canvas.line(middles, colour, 2);
}

/** Least and greatest of a quantity over both estimates, in mm. */
std::pair<double, double> range_of(const BeforeAfter& f, double RangeBin::*value)
{
  double low = 0, high = 0;
  for (const auto* figures : {&f.before, &f.after})
    for (const auto& bin : figures->by_range)
    {
      low = std::min(low, 1000 * (bin.*value));
      high = std::max(high, 1000 * (bin.*value));
    }
  const double margin = std::max(1.0, 0.08 * (high - low));
  return {low < 0 ? low - margin : 0, high + margin};
}

void draw_diagram(
    Canvas& canvas, int column, const BeforeAfter& f, double RangeBin::*value,
    const std::string& title)
{
  const auto [low, high] = range_of(f, value);
  double far_m = 2;
  for (const auto& bin : f.after.by_range) far_m = std::max(far_m, bin.to_m);
  const Plot p{kLeft + column * kStep, kTop, low, high, far_m};
  draw_axes(canvas, p, title);
  draw_line(canvas, p, f.before.by_range, value, kBeforeColour);
  draw_line(canvas, p, f.after.by_range, value, kAfterColour);
}

std::string words(const char* when, const HeldOutFigures& f)
{
  char text[120];
  std::snprintf(
      text, sizeof text, "%s: ground %.1f mm thick, 95 %% within %.1f mm", when,
      1000 * f.thickness_m, 1000 * f.p95_m);
  return text;
}

void draw_legend(Canvas& canvas, const BeforeAfter& f)
{
  int x = kLeft;
  const TextStyle plain{11, io::kInk, false, Anchor::Start, Anchor::Middle, false};
  for (const auto& [text, colour] :
       {std::pair{words("before", f.before), kBeforeColour},
        {words("after", f.after), kAfterColour}})
  {
    canvas.fill({x, 62, 22, 12}, colour);
    canvas.text(text, x + 32, 68, plain);
    x += kStep;
  }
}
}  // namespace

void write_picture(const std::string& path, const std::string& title, const Result& result)
{
  Canvas canvas(2 * kStep + 20, kTop + kPlotHeight + 70);
  canvas.text(
      title + ", frames held out from the fit", kLeft, 30,
      {15, io::kInk, true, Anchor::Start, Anchor::Middle, false});
  draw_legend(canvas, result.held_out);
  draw_diagram(canvas, 0, result.held_out, &RangeBin::thickness_m, "thickness of the ground [mm]");
  draw_diagram(
      canvas, 1, result.held_out, &RangeBin::offset_m, "seen too high or too low [mm], median");
  io::write_png(path, canvas.image());
}

}  // namespace talus::calibrate
