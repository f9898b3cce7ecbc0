#include "picture_canvas.h"

#include "lettering.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace talus::io
{
namespace
{
constexpr int kFractionBits = 4;

LetterSize size_of(const TextStyle& style) { return {style.cap_height_px, style.bold}; }

double shift(Anchor anchor, double size)
{
  return anchor == Anchor::Start ? 0 : anchor == Anchor::Middle ? -size / 2 : -size;
}

std::vector<cv::Point> fixed_point(const std::vector<cv::Point2d>& corners)
{
  std::vector<cv::Point> fixed;
  fixed.reserve(corners.size());
  for (const auto& c : corners)
    fixed.emplace_back(
        static_cast<int>(std::lround(c.x * (1 << kFractionBits))),
        static_cast<int>(std::lround(c.y * (1 << kFractionBits))));
  return fixed;
}
}  // namespace

void Canvas::paste(const cv::Mat& bgr, int x, int y)
{
  bgr.copyTo(image_(cv::Rect(x, y, bgr.cols, bgr.rows)));
}

void Canvas::fill(const cv::Rect& area, const cv::Scalar& colour)
{
  cv::rectangle(image_, area, colour, cv::FILLED);
}

void Canvas::frame(const cv::Rect& area, const cv::Scalar& colour)
{
  cv::rectangle(
      image_, cv::Rect(area.x - 1, area.y - 1, area.width + 2, area.height + 2), colour, 1);
}

void Canvas::horizontal(int x0, int x1, int y, const cv::Scalar& colour)
{
  cv::line(image_, {x0, y}, {x1, y}, colour, 1);
}

void Canvas::vertical(int x, int y0, int y1, const cv::Scalar& colour)
{
  cv::line(image_, {x, y0}, {x, y1}, colour, 1);
}

void Canvas::polygon(
    const std::vector<cv::Point2d>& corners, const cv::Scalar& inside, const cv::Scalar& edge,
    double edge_px)
{
  const std::vector<std::vector<cv::Point>> outline{fixed_point(corners)};
  if (edge_px > 0)
    cv::polylines(
        image_, outline, true, edge, static_cast<int>(std::lround(2 * edge_px)), cv::LINE_AA,
        kFractionBits);
  cv::fillPoly(image_, outline, inside, cv::LINE_AA, kFractionBits);
}

void Canvas::line(const std::vector<cv::Point2d>& points, const cv::Scalar& colour, double width_px)
{
  const std::vector<std::vector<cv::Point>> lines{fixed_point(points)};
  cv::polylines(
      image_, lines, false, colour, std::max(1, static_cast<int>(std::lround(width_px))),
      cv::LINE_AA, kFractionBits);
}

void Canvas::ring(
    const cv::Point2d& middle, double radius_px, const cv::Scalar& colour, double width_px)
{
  cv::circle(
      image_, fixed_point({middle}).front(),
      static_cast<int>(std::lround(radius_px * (1 << kFractionBits))), colour,
      std::max(1, static_cast<int>(std::lround(width_px))), cv::LINE_AA, kFractionBits);
}

double Canvas::text_width(const std::string& text, const TextStyle& style)
{
  return lettering().width_px(text, size_of(style));
}

void Canvas::text(const std::string& text, double x, double y, const TextStyle& style)
{
  if (text.empty()) return;
  const double width = text_width(text, style), height = style.cap_height_px;
  const int border = static_cast<int>(std::ceil(height));
  cv::Mat1b mask = lettering().coverage(text, size_of(style), border);
  if (style.upwards) cv::rotate(mask, mask, cv::ROTATE_90_COUNTERCLOCKWISE);
  // Upwards, the text runs against y, and its capitals rise against x.
  const double left = x + (style.upwards ? shift(style.down, height) : shift(style.across, width));
  const double top = y + (style.upwards ? shift(style.across, width) : shift(style.down, height));
  blend(
      mask, static_cast<int>(std::lround(left)) - border,
      static_cast<int>(std::lround(top)) - border, style.colour);
}

void Canvas::blend(const cv::Mat& mask, int x, int y, const cv::Scalar& colour)
{
  for (int r = std::max(0, -y); r < mask.rows && y + r < image_.rows; ++r)
    for (int c = std::max(0, -x); c < mask.cols && x + c < image_.cols; ++c)
    {
      const double a = mask.at<uchar>(r, c) / 255.0;
      auto& pixel = image_.at<cv::Vec3b>(y + r, x + c);
      for (int k = 0; k < 3; ++k)
        pixel[k] = cv::saturate_cast<uchar>(a * colour[k] + (1 - a) * pixel[k]);
    }
}

}  // namespace talus::io
