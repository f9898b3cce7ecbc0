#include "picture_legend.h"

#include <talus/number_text.h>

#include <cmath>

namespace talus::io
{
namespace
{
const cv::Scalar kWayColour(bgr(palette::kPath.rgb)), kHalo(255, 255, 255);

void draw_start(Canvas& canvas, const cv::Point2d& p, double radius_px)
{
  canvas.ring(p, radius_px, kHalo, 0.7 * radius_px);  // the end may lie in it
  canvas.ring(p, radius_px, kWayColour, 0.3 * radius_px);
}

void draw_end(Canvas& canvas, const cv::Point2d& p, double radius_px)
{
  const double h = 0.5 * radius_px;
  canvas.polygon(
      {p + cv::Point2d(-h, -h), p + cv::Point2d(h, -h), p + cv::Point2d(h, h),
       p + cv::Point2d(-h, h)},
      kWayColour, kHalo, 0.2 * radius_px);
}
}  // namespace

void draw_robot(Canvas& canvas, cv::Point2d middle, double yaw_rad, double length_px)
{
  const cv::Point2d ahead(std::cos(yaw_rad), -std::sin(yaw_rad)), left(ahead.y, -ahead.x);
  const double l = length_px;
  canvas.polygon(
      {middle + ahead * (0.55 * l), middle - ahead * (0.45 * l) + left * (0.36 * l),
       middle - ahead * (0.25 * l), middle - ahead * (0.45 * l) - left * (0.36 * l)},
      cv::Scalar(255, 255, 255), cv::Scalar(0, 0, 0), std::max(1.5, l / 16));
}

void draw_way_line(Canvas& canvas, const std::vector<cv::Point2d>& way, double width_px)
{
  canvas.line(way, kHalo, width_px + 2);
  canvas.line(way, kWayColour, width_px);
}

void draw_ways(
    Canvas& canvas, const std::vector<std::vector<cv::Point2d>>& ways, double width_px,
    double mark_px)
{
  for (const auto& way : ways) canvas.line(way, kHalo, width_px + 2);
  for (const auto& way : ways) canvas.line(way, kWayColour, width_px);
  for (const auto& way : ways)
    if (!way.empty())
    {
      draw_end(canvas, way.back(), mark_px);
      draw_start(canvas, way.front(), mark_px);
    }
}

void draw_north(
    Canvas& canvas, cv::Point2d middle, double turn_rad, double length_px,
    const std::string& letter)
{
  const double l = length_px;
  const cv::Point2d up(-std::sin(turn_rad), -std::cos(turn_rad)), right(-up.y, up.x);
  const cv::Point2d tip = middle + up * (0.45 * l), notch = middle - up * (0.3 * l);
  canvas.polygon({tip, middle - up * (0.5 * l) + right * (0.28 * l), notch}, kInk, kInk, 0.5);
  canvas.polygon({tip, middle - up * (0.5 * l) - right * (0.28 * l), notch}, kPaper, kInk, 0.5);
  const cv::Point2d at = middle + up * (0.75 * l);
  canvas.text(letter, at.x, at.y, {0.26 * l, kInk, true, Anchor::Middle, Anchor::Middle, false});
}

void draw_scale_bar(Canvas& canvas, cv::Point corner, int length_px, int height_px)
{
  for (int i = 0; i < 4; ++i)
  {
    const int from = corner.x + i * length_px / 4, to = corner.x + (i + 1) * length_px / 4;
    canvas.fill({from, corner.y, to - from, height_px}, i % 2 == 0 ? kInk : kPaper);
  }
  canvas.frame({corner.x, corner.y, length_px, height_px}, kInk);
}

double round_length_m(double longest_m)
{
  const double ten = std::pow(10.0, std::floor(std::log10(longest_m)));
  for (const double part : {5.0, 2.0})
    if (part * ten <= longest_m) return part * ten;
  return ten;
}

std::string length_text(double length_m)
{
  if (length_m >= 1000) return fixed_text(length_m / 1000, 0) + " km";
  return fixed_text(length_m, length_m < 0.1 ? 2 : length_m < 1 ? 1 : 0) + " m";
}

}  // namespace talus::io
