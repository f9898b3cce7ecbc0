#include "picture_sheet.h"

#include <picture_panel.h>
#include <picture_style.h>
#include <talus/number_text.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace talus::site
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::kFaintInk;
using io::kInk;
using io::TextStyle;

constexpr int kLeft = 96, kTop = 124, kLeastWidth = 800, kBottom = 72, kColumn = 212, kEdge = 28;
constexpr int kTick = 6, kSwatch = 20, kRow = 32;
const cv::Scalar kWayColour(96, 0, 128), kHalo(255, 255, 255), kGrid(208, 204, 202);

const TextStyle kPlain{12, kInk, false, Anchor::Start, Anchor::Middle, false};
const TextStyle kBold{12, kInk, true, Anchor::Start, Anchor::Middle, false};

/** Whole metres. */
std::vector<double> ticks(double low, double high, int pixels)
{
  const int most = std::max(1, std::min(pixels / 90, static_cast<int>(high - low)));
  return io::ticks_between(low, high, most);
}

void draw_line(cv::Mat& on, const std::vector<cv::Point>& points, const cv::Scalar& c, int width)
{
  cv::polylines(on, points, false, c, width, cv::LINE_AA, 4);
}

cv::Point fixed_point(const cv::Point2d& p)
{
  return {static_cast<int>(std::lround(p.x * 16)), static_cast<int>(std::lround(p.y * 16))};
}

void draw_start(cv::Mat& on, const cv::Point& p)
{
  cv::circle(on, p, 10 * 16, kHalo, 7, cv::LINE_AA, 4);  // the end may lie in it
  cv::circle(on, p, 10 * 16, kWayColour, 3, cv::LINE_AA, 4);
}
void draw_end(cv::Mat& on, const cv::Point& p)
{
  const auto square = [&](int half, const cv::Scalar& c)
  {
    const cv::Point d(half * 16, half * 16);
    cv::rectangle(on, p - d, p + d, c, cv::FILLED, cv::LINE_AA, 4);
  };
  square(7, kHalo);
  square(5, kWayColour);
}
}  // namespace

cv::Vec3b mixed(const cv::Vec3b& a, const cv::Vec3b& b, float part_b)
{
  cv::Vec3b m;
  for (int k = 0; k < 3; ++k) m[k] = cv::saturate_cast<uchar>((1 - part_b) * a[k] + part_b * b[k]);
  return m;
}

cv::Vec3b lit(const cv::Vec3b& colour, float shade)
{
  constexpr float kDarkest = 0.4F, kLevel = 0.7071F;
  cv::Vec3b c;
  for (int k = 0; k < 3; ++k)
    c[k] = cv::saturate_cast<uchar>(colour[k] * (kDarkest + (1 - kDarkest) * shade / kLevel));
  return c;
}

PictureSheet::PictureSheet(const RasterPlace& place, int legend_px)
    : place_(place),
      plot_(cv::Point(kLeft, kTop), place.drawn_size()),
      canvas_(
          std::max(kLeft + plot_.width + kColumn + 2 * kEdge, kLeastWidth),
          kTop + std::max(plot_.height, legend_px) + kBottom),
      map_(plot_.size(), kNotSeen),
      next_y_(kTop)
{
  const double x1 = place.min_x_m + place.width * place.pixel_m;
  const double y0 = place.max_y_m - place.height * place.pixel_m;
  for (const double t : ticks(place.min_x_m, x1, plot_.width))
    cv::line(
        map_, cv::Point(cvRound(place.drawn(t, 0).x), 0),
        cv::Point(cvRound(place.drawn(t, 0).x), plot_.height), kGrid);
  for (const double t : ticks(y0, place.max_y_m, plot_.height))
    cv::line(
        map_, cv::Point(0, cvRound(place.drawn(0, t).y)),
        cv::Point(plot_.width, cvRound(place.drawn(0, t).y)), kGrid);
}

void PictureSheet::paint(const cv::Mat3b& cells, const cv::Mat1b& known)
{
  cv::Mat large, mask;
  cv::resize(cells, large, plot_.size(), 0, 0, cv::INTER_NEAREST);
  cv::resize(known, mask, plot_.size(), 0, 0, cv::INTER_NEAREST);
  large.copyTo(map_, mask);
}

void PictureSheet::draw_ways(const std::vector<std::vector<WayPoint>>& ways, int floor)
{
  std::vector<std::vector<cv::Point>> lines;
  for (const auto& way : ways)
  {
    auto& line = lines.emplace_back();
    for (const WayPoint& p : way)
      if (p.floor == floor) line.push_back(fixed_point(place_.drawn(p.x_m, p.y_m)));
  }
  constexpr double kFarAway_m = 0.25;  // the robot is narrower than the line then
  const int width = place_.pixel_m > kFarAway_m ? 2 : 3;
  for (const auto& line : lines) draw_line(map_, line, kHalo, width + 2);
  for (const auto& line : lines) draw_line(map_, line, kWayColour, width);
  for (const auto& line : lines)
    if (!line.empty())
    {
      draw_end(map_, line.back());
      draw_start(map_, line.front());
    }
}

void PictureSheet::draw_titles(const std::string& title, const std::vector<std::string>& lines)
{
  const TextStyle large{19, kInk, true, Anchor::Start, Anchor::Middle, false};
  const TextStyle small{12.5, kFaintInk, false, Anchor::Start, Anchor::Middle, false};
  canvas_.text(title, kLeft - 1, 36, large);
  int y = 68;
  for (const std::string& line : lines)
  {
    canvas_.text(line, kLeft - 1, y, small);
    y += 24;
  }
}

void PictureSheet::draw_axes()
{
  const double x1 = place_.min_x_m + place_.width * place_.pixel_m;
  const double y0 = place_.max_y_m - place_.height * place_.pixel_m;
  TextStyle style = kPlain;
  style.across = Anchor::Middle;
  style.down = Anchor::Start;
  const int bottom = plot_.y + plot_.height;
  for (const double t : ticks(place_.min_x_m, x1, plot_.width))
  {
    const int x = plot_.x + cvRound(place_.drawn(t, 0).x);
    canvas_.vertical(x, bottom, bottom + kTick, kInk);
    canvas_.text(io::tick_text(t, 1), x, bottom + kTick + 7, style);
  }
  TextStyle label = style;
  label.colour = kFaintInk;
  canvas_.text("x [m]", plot_.x + plot_.width / 2.0, bottom + kTick + 34, label);
  style.across = Anchor::End;
  style.down = Anchor::Middle;
  for (const double t : ticks(y0, place_.max_y_m, plot_.height))
  {
    const int y = plot_.y + cvRound(place_.drawn(0, t).y);
    canvas_.horizontal(plot_.x - 1 - kTick, plot_.x - 1, y, kInk);
    canvas_.text(io::tick_text(t, 1), plot_.x - kTick - 7, y, style);
  }
  label.upwards = true;
  canvas_.text("y [m]", 14, plot_.y + plot_.height / 2.0, label);
}

void PictureSheet::add_heading(const std::string& text)
{
  canvas_.text(text, plot_.x + plot_.width + kEdge, next_y_ + 8, kBold);
  next_y_ += kRow;
}

void PictureSheet::add_swatch(const cv::Vec3b& colour, const std::string& words)
{
  const cv::Rect swatch(plot_.x + plot_.width + kEdge, next_y_, kSwatch, kSwatch);
  canvas_.fill(swatch, cv::Scalar(colour[0], colour[1], colour[2]));
  canvas_.frame(swatch, kFaintInk);
  canvas_.text(words, swatch.x + kSwatch + 12, next_y_ + kSwatch / 2.0, kPlain);
  next_y_ += kRow;
}

void PictureSheet::add_scores()
{
  add_heading("Traversability");
  const cv::Rect bar(plot_.x + plot_.width + kEdge, next_y_, kSwatch, 150);
  cv::Mat scale;
  cv::flip(io::colours_of(io::Palette::Scores), scale, 0);
  cv::resize(scale, scale, bar.size(), 0, 0, cv::INTER_LINEAR);
  canvas_.paste(scale, bar.x, bar.y);
  canvas_.frame(bar, kFaintInk);
  const std::vector<std::string> words{"1 free", "0.5", "0 blocked"};
  for (std::size_t i = 0; i < words.size(); ++i)
  {
    const int y = bar.y + static_cast<int>(i) * (bar.height - 1) / 2;
    canvas_.horizontal(bar.x + bar.width, bar.x + bar.width + kTick, y, kInk);
    canvas_.text(words[i], bar.x + kSwatch + 12, y, kPlain);
  }
  next_y_ += bar.height + 22;
}

void PictureSheet::add_ways()
{
  const int x = plot_.x + plot_.width + kEdge;
  cv::Mat3b symbol(kSwatch + 8, 3 * kSwatch + 4, kWhite);
  const int y = (kSwatch / 2 + 4) * 16;
  draw_line(symbol, {{14 * 16, y}, {54 * 16, y}}, kWayColour, 3);
  draw_start(symbol, {14 * 16, y});
  draw_end(symbol, {54 * 16, y});
  canvas_.paste(symbol, x - 2, next_y_ - 4);
  canvas_.text("way: start, end", x + 3 * kSwatch + 8, next_y_ + kSwatch / 2.0, kPlain);
  next_y_ += kRow;
}

void PictureSheet::add_scale_bar()
{
  constexpr double kWidest = 170;
  const double px_per_m = place_.pixels_per_cell / place_.pixel_m;
  const auto steps = io::ticks_between(0, kWidest / px_per_m, 1);
  double length_m = steps.size() > 1 ? steps[1] : kWidest / px_per_m;
  for (const double part : {5.0, 2.0, 1.0})
  {
    const double ten = std::pow(10.0, std::floor(std::log10(kWidest / px_per_m)));
    if (part * ten * px_per_m > kWidest) continue;
    length_m = part * ten;
    break;
  }
  const int x = plot_.x + plot_.width + kEdge, width = cvRound(length_m * px_per_m);
  for (int i = 0; i < 4; ++i)
  {
    const int from = x + i * width / 4, to = x + (i + 1) * width / 4;
    canvas_.fill({from, next_y_, to - from, 8}, i % 2 == 0 ? kInk : io::kPaper);
  }
  canvas_.frame({x, next_y_, width, 8}, kInk);
  const int decimals = length_m < 1 ? 1 : 0;
  const bool far = length_m >= 1000;
  canvas_.text(
      far ? fixed_text(length_m / 1000, 0) + " km" : fixed_text(length_m, decimals) + " m", x,
      next_y_ + 24, kPlain);
  next_y_ += 54;
}

void PictureSheet::add_north(double heading_deg, const std::string& words)
{
  constexpr double kPi = 3.14159265358979323846;
  const double heading_rad = heading_deg * kPi / 180;
  const cv::Point2d middle(plot_.x + plot_.width + kEdge + 34, next_y_ + 42);
  const cv::Point2d north(std::sin(heading_rad), -std::cos(heading_rad)), east(-north.y, north.x);
  const cv::Point2d tip = middle + north * 30, notch = middle - north * 12;
  canvas_.polygon({tip, middle - north * 24 + east * 15, notch}, kInk, kInk, 0.5);
  canvas_.polygon({tip, middle - north * 24 - east * 15, notch}, io::kPaper, kInk, 0.5);
  const TextStyle letter{14, kInk, true, Anchor::Middle, Anchor::Middle, false};
  const cv::Point2d at = middle + north * 44;
  canvas_.text("N", at.x, at.y, letter);
  const TextStyle small{11, kFaintInk, false, Anchor::Start, Anchor::Middle, false};
  canvas_.text(words, middle.x + 36, middle.y, small);
  next_y_ += 96;
}

cv::Mat PictureSheet::finish()
{
  canvas_.paste(map_, plot_.x, plot_.y);
  canvas_.frame(plot_, kInk);
  const int used_px = std::max(plot_.y + plot_.height + kBottom, next_y_ + kEdge);
  return canvas_.image().rowRange(0, std::min(used_px, canvas_.image().rows)).clone();
}

double length_m(const std::vector<std::vector<WayPoint>>& ways, int floor)
{
  double length = 0;
  for (const auto& way : ways)
    for (std::size_t i = 1; i < way.size(); ++i)
      if (way[i].floor == floor && way[i - 1].floor == floor)
        length += std::hypot(
            static_cast<double>(way[i].x_m) - way[i - 1].x_m,
            static_cast<double>(way[i].y_m) - way[i - 1].y_m);
  return length;
}

std::string area_text(double area_m2)
{
  const int decimals = area_m2 < 10 ? 2 : area_m2 < 100 ? 1 : 0;
  if (area_m2 >= 1e6) return fixed_text(area_m2 / 1e6, 3) + " km2";
  return fixed_text(area_m2, decimals) + " m2";
}

std::string time_text(std::uint32_t seen_s)
{
  constexpr std::uint32_t kYear2000_s = 946'684'800;
  if (seen_s < kYear2000_s) return "";
  const auto t = static_cast<std::time_t>(seen_s);
  std::tm utc{};
  gmtime_r(&t, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

}  // namespace talus::site
