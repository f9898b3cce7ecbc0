#include <talus/io/map_picture.h>

#include <picture_canvas.h>
#include <picture_style.h>

#include <algorithm>
#include <cmath>

#include "report.h"

namespace talus::baselines
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::TextStyle;

constexpr int kSide_px = 340, kTop_px = 60, kLeft_px = 80, kStep_px = 460, kBelow_px = 110;
constexpr int kPoints = 20;  //!< of a curve
constexpr std::size_t kMinHeightCount = 100;  //!< of a kind in a world or log, or it has no say

const io::NamedColour& of_kind(int kind)
{
  return io::palette::kStates[static_cast<std::size_t>(kind) + 1];
}

cv::Point2d at(int x, double should, double does)
{
  return {x + should * kSide_px, kTop_px + (1 - does) * kSide_px};
}

void draw_axes(Canvas& canvas, int x, const std::string& title)
{
  const TextStyle below{9, io::kFaintInk, false, Anchor::Middle, Anchor::Start, false};
  const TextStyle left{9, io::kFaintInk, false, Anchor::End, Anchor::Middle, false};
  const TextStyle turned{9, io::kFaintInk, false, Anchor::Middle, Anchor::Middle, true};
  canvas.frame({x, kTop_px, kSide_px, kSide_px}, io::kInk);
  canvas.text(title, x, kTop_px - 20, {12, io::kInk, true, Anchor::Start, Anchor::Middle, false});
  for (int tenth = 0; tenth <= 10; tenth += 2)
  {
    const double share = tenth / 10.0;
    const std::string percent = std::to_string(10 * tenth) + " %";
    canvas.text(percent, at(x, share, 0).x, kTop_px + kSide_px + 8, below);
    canvas.text(percent, x - 8, at(x, 0, share).y, left);
  }
  canvas.text(
      "heights that should lie within the told deviations", x + kSide_px / 2.0,
      kTop_px + kSide_px + 30, below);
  canvas.text("heights that do", x - 58, kTop_px + kSide_px / 2.0, turned);
  canvas.line({at(x, 0, 0), at(x, 1, 1)}, io::kFaintInk, 1);
}

/** The mean of the curves of several worlds, or logs. */
std::vector<cv::Point2d> curve(int x, const std::vector<const HeightBars*>& of, int kind)
{
  std::vector<double> sum(kPoints - 1, 0);
  int count = 0;
  for (const HeightBars* bars : of)
  {
    const EstimateErrors errors = bars->all(kind);
    if (errors.count() < kMinHeightCount) continue;
    ++count;
    for (int i = 1; i < kPoints; ++i)
      sum[i - 1] += errors.share_within(static_cast<double>(i) / kPoints);
  }
  std::vector<cv::Point2d> points;
  for (int i = 1; i < kPoints && count > 0; ++i)
    points.push_back(at(x, static_cast<double>(i) / kPoints, sum[i - 1] / count));
  return points;
}

void draw_diagram(
    Canvas& canvas, int x, const std::string& title, const std::vector<const HeightBars*>& of)
{
  draw_axes(canvas, x, title);
  for (int kind = 0; kind < kHeightKinds; ++kind)
    if (const auto points = curve(x, of, kind); !points.empty())
      canvas.line(points, io::bgr(of_kind(kind).rgb), 2.5);
}

void draw_legend(Canvas& canvas)
{
  const TextStyle plain{11, io::kInk, false, Anchor::Start, Anchor::Middle, false};
  const double y = kTop_px + kSide_px + 75;
  double x = kLeft_px;
  for (int kind = 0; kind < kHeightKinds; ++kind)
  {
    canvas.line({{x, y}, {x + 24, y}}, io::bgr(of_kind(kind).rgb), 2.5);
    canvas.text(of_kind(kind).name, x + 30, y, plain);
    x += 50 + Canvas::text_width(of_kind(kind).name, plain);
  }
}
}  // namespace

void write_bars_picture(const std::string& path, const Comparison& c)
{
  std::vector<const HeightBars*> worlds, logs;
  for (const Evaluation& e : c.evaluations)
    for (const Score& s : e.maps)
      if (!s.bars.empty()) worlds.push_back(&s.bars);
  for (const HoldOut& h : c.holdouts)
    if (!h.bars.empty()) logs.push_back(&h.bars);
  const int diagrams = (worlds.empty() ? 0 : 1) + (logs.empty() ? 0 : 1);
  if (diagrams == 0) return;
  Canvas canvas(
      std::max(kLeft_px + diagrams * kStep_px - kLeft_px / 2, 740), kTop_px + kSide_px + kBelow_px);
  int x = kLeft_px;
  const auto draw = [&](const std::string& one, const std::vector<const HeightBars*>& of)
  {
    if (of.empty()) return;
    const std::string several = "mean of " + std::to_string(of.size()) + " " + one + "s";
    draw_diagram(canvas, x, of.size() > 1 ? several : "one " + one, of);
    x += kStep_px;
  };
  draw("world", worlds);
  draw("log", logs);
  draw_legend(canvas);
  io::write_png(path, canvas.image());
}

}  // namespace talus::baselines
