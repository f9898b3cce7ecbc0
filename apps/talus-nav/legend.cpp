#include "legend.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace talus::nav
{
namespace
{
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kScale = 0.45, kTitleScale = 0.5;
constexpr int kEdge_px = 6, kTitle_px = 26, kRow_px = 22, kGap_px = 18, kHalf_px = 6;
const cv::Scalar kInk(30, 30, 30), kPaper(255, 255, 255);

int text_px(const std::string& text, double scale)
{
  return cv::getTextSize(text, kFont, scale, 1, nullptr).width;
}

int mark_px(const LegendItem& item) { return item.mark == Mark::None ? 0 : item.length_px + 6; }

int item_px(const LegendItem& item) { return mark_px(item) + text_px(item.word, kScale); }

void draw_ramp(cv::Mat& image, const cv::Rect& area, const LegendItem& item)
{
  for (int i = 0; i < area.width; i++)
  {
    const double part = static_cast<double>(i) / (area.width - 1);
    image(cv::Rect(area.x + i, area.y, 1, area.height))
        .setTo((1 - part) * item.colour + part * item.colour_to);
  }
}

void draw_bar(cv::Mat& image, const cv::Point& left, const LegendItem& item)
{
  const cv::Point right(left.x + item.length_px, left.y), up(0, 4);
  cv::line(image, left, right, kInk, 2);
  cv::line(image, left - up, left + up, kInk, 1);
  cv::line(image, right - up, right + up, kInk, 1);
}

/** `left` is the middle of the left edge. */
void draw_mark(cv::Mat& image, const cv::Point& left, const LegendItem& item)
{
  const cv::Rect area(left.x, left.y - kHalf_px, item.length_px, 2 * kHalf_px);
  const cv::Point right(area.br().x, left.y), middle(left.x + item.length_px / 2, left.y);
  switch (item.mark)
  {
    case Mark::Area:
      return cv::rectangle(image, area, item.colour, cv::FILLED);
    case Mark::Ramp:
      return draw_ramp(image, area, item);
    case Mark::Line:
      return cv::line(image, left, right, item.colour, 2, cv::LINE_AA);
    case Mark::Dot:
      return cv::circle(image, middle, 2, item.colour, cv::FILLED);
    case Mark::Cross:
      return cv::drawMarker(image, middle, item.colour, cv::MARKER_TILTED_CROSS, 12, 3);
    case Mark::Robot:
      return cv::fillPoly(
          image,
          std::vector<std::vector<cv::Point>>{
              {area.tl(),
               {right.x - 6, area.y},
               right,
               {right.x - 6, area.br().y},
               {area.x, area.br().y}}},
          item.colour, cv::LINE_AA);
    case Mark::Bar:
      return draw_bar(image, left, item);
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
}  // namespace

cv::Mat draw_legend(int width_px, const std::vector<std::vector<LegendItem>>& groups)
{
  int height_px = 0;
  const auto placed = place(width_px, groups, height_px);
  cv::Mat strip(height_px, width_px, CV_8UC3, kPaper);
  for (const auto& [item, left] : placed)
  {
    draw_mark(strip, left, *item);
    const cv::Point text(left.x + mark_px(*item), left.y + 5);
    cv::putText(strip, item->word, text, kFont, kScale, kInk, 1, cv::LINE_AA);
  }
  return strip;
}

cv::Mat draw_title(int width_px, const std::string& text)
{
  const double room_px = width_px - 2 * kEdge_px;
  const double scale = kTitleScale * std::min(1.0, room_px / text_px(text, kTitleScale));
  cv::Mat strip(kTitle_px, width_px, CV_8UC3, kPaper);
  cv::putText(strip, text, {kEdge_px, 18}, kFont, scale, kInk, 1, cv::LINE_AA);
  return strip;
}

}  // namespace talus::nav
