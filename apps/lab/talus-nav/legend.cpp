#include "legend.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace talus::nav
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::TextStyle;

constexpr int kEdge_px = 12, kTitle_px = 40, kRow_px = 28, kGap_px = 24, kMark_px = 30;
constexpr int kHalf_px = 8;
const TextStyle kPlain{11, io::kInk, false, Anchor::Start, Anchor::Middle, false};
const TextStyle kHead{11, io::kInk, true, Anchor::Start, Anchor::Middle, false};

const TextStyle& style_of(const LegendItem& item)
{
  return item.mark == Mark::None ? kHead : kPlain;
}

int mark_px(const LegendItem& item) { return item.mark == Mark::None ? 0 : kMark_px + 8; }

int item_px(const LegendItem& item)
{
  return mark_px(item) + static_cast<int>(Canvas::text_width(item.word, style_of(item)));
}

cv::Mat swatch(const LegendItem& item)
{
  cv::Mat image(2 * kHalf_px, kMark_px, CV_8UC3, item.colour);
  if (item.mark == Mark::Ramp)
    cv::resize(item.ramp.t(), image, image.size(), 0, 0, cv::INTER_LINEAR);
  if (item.mark == Mark::Hatching)
    for (int y = 0; y < image.rows; y++)
      for (int x = 0; x < image.cols; x++)
        if (is_hatched(x, y)) image.at<cv::Vec3b>(y, x) *= 0.6;
  return image;
}

/** `left` is the middle of the left edge. */
void draw_mark(Canvas& canvas, const cv::Point& left, const LegendItem& item)
{
  const double x = left.x, y = left.y, right = x + kMark_px, middle = x + kMark_px / 2.0;
  switch (item.mark)
  {
    case Mark::Area:
    case Mark::Ramp:
    case Mark::Hatching:
      canvas.paste(swatch(item), left.x, left.y - kHalf_px);
      canvas.frame({left.x, left.y - kHalf_px, kMark_px, 2 * kHalf_px}, io::kFaintInk);
      return;
    case Mark::Line:
      return draw_way(
          canvas, {{x, y}, {right, y}}, item.colour,
          item.colour == io::kPaper ? io::kInk : io::kPaper);
    case Mark::Dot:
      return canvas.polygon(
          {{middle - 3, y - 3}, {middle + 3, y - 3}, {middle + 3, y + 3}, {middle - 3, y + 3}},
          item.colour, io::kInk, 0.5);
    case Mark::Cross:
      return draw_cross(canvas, {middle, y});
    case Mark::Robot:
      return canvas.polygon(
          {{x + 2, y - 7}, {right - 8, y - 7}, {right, y}, {right - 8, y + 7}, {x + 2, y + 7}},
          io::kPaper, io::kInk, 1.5);
    case Mark::None:
      return;
  }
}

struct Placed
{
  const LegendItem* item;
  cv::Point left;
};

/** Where each item goes, and the height of all. */
std::vector<Placed> place(
    int width_px, const std::vector<std::vector<LegendItem>>& groups, int& height_px)
{
  std::vector<Placed> placed;
  cv::Point at(kEdge_px, kEdge_px - kRow_px / 2);
  for (const auto& group : groups)
  {
    at = {kEdge_px, at.y + kRow_px};
    for (const auto& item : group)
    {
      if (at.x > kEdge_px && at.x + item_px(item) > width_px - kEdge_px)
        at = {kEdge_px, at.y + kRow_px};
      placed.push_back({&item, at});
      at.x += item_px(item) + kGap_px;
    }
  }
  height_px = at.y + kRow_px / 2 + kEdge_px;
  return placed;
}

/** A line of this width as one polygon a piece. */
void draw_line(
    Canvas& canvas, const std::vector<cv::Point2d>& way, const cv::Scalar& colour, double width_px)
{
  const double half = width_px / 2;
  for (std::size_t i = 1; i < way.size(); i++)
  {
    const cv::Point2d along = way[i] - way[i - 1];
    const double length = cv::norm(along);
    if (length == 0) continue;
    const cv::Point2d ahead = along * (half / length), side(-ahead.y, ahead.x);
    const auto from = way[i - 1] - ahead * 0.5, to = way[i] + ahead * 0.5;
    canvas.polygon({from + side, to + side, to - side, from - side}, colour, colour, 0);
  }
}
}  // namespace

bool is_hatched(int x, int y) { return (x + y) % 9 < 2; }

void draw_way(
    Canvas& canvas, const std::vector<cv::Point2d>& way, const cv::Scalar& colour,
    const cv::Scalar& edge)
{
  draw_line(canvas, way, edge, 6);
  draw_line(canvas, way, colour, 3);
}

void draw_cross(Canvas& canvas, const cv::Point2d& middle)
{
  const cv::Point2d d(9, 9), u(9, -9);
  for (const auto& [colour, width_px] : {std::pair{io::kPaper, 8.0}, {io::kInk, 4.0}})
    for (const auto& arm : {d, u})
      draw_line(canvas, {middle - arm, middle + arm}, colour, width_px);
}

cv::Mat draw_legend(int width_px, const std::vector<std::vector<LegendItem>>& groups)
{
  int height_px = 0;
  const auto placed = place(width_px, groups, height_px);
  Canvas strip(width_px, height_px);
  for (const auto& [item, left] : placed)
  {
    draw_mark(strip, left, *item);
    strip.text(item->word, left.x + mark_px(*item), left.y, style_of(*item));
  }
  return strip.image();
}

cv::Mat draw_title(int width_px, const std::string& text)
{
  TextStyle style{13, io::kInk, true, Anchor::Start, Anchor::Middle, false};
  const double room_px = width_px - 2 * kEdge_px;
  style.cap_height_px *= std::min(1.0, room_px / Canvas::text_width(text, style));
  Canvas strip(width_px, kTitle_px);
  strip.text(text, kEdge_px, kTitle_px / 2.0, style);
  return strip.image();
}

}  // namespace talus::nav
