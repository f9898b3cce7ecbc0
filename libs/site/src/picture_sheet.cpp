#include "picture_sheet.h"

#include <picture_legend.h>
#include <picture_panel.h>
#include <talus/number_text.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::site
{
namespace
{
using io::Anchor;
using io::Canvas;
using io::kFaintInk;
using io::kInk;
using io::TextStyle;

/// @name Pixels of a small page
/// @{
constexpr double kEdge = 28, kLeft = 84, kTop = 112, kBelow = 62, kColumn = 230;
constexpr double kTick = 6, kText = 10;
constexpr int kMinWidth = 760;
/// @}
constexpr double kSmallPage_px = 1250;  //!< the long side of one that needs no larger text
const cv::Scalar kGrid(214, 210, 208);

double scale_of(const cv::Size& page)
{
  return std::clamp(std::max(page.width, page.height) / kSmallPage_px, 1.0, 2.0);
}

/** Whole metres. */
std::vector<double> ticks(double low, double high, double most_ticks)
{
  const int most =
      std::max(1, std::min(static_cast<int>(most_ticks), static_cast<int>(high - low)));
  return io::ticks_between(low, high, most);
}
}  // namespace

PictureSheet::PictureSheet(const RasterPlace& place)
    : place_(place),
      scale_(scale_of(place.page)),
      map_(place.page.width, place.page.height),
      legend_(scale_),
      least_x_m_(std::numeric_limits<double>::infinity()),
      most_x_m_(-least_x_m_),
      least_y_m_(least_x_m_),
      most_y_m_(-least_x_m_)
{
  const double w = place.page.width, h = place.page.height;
  for (const cv::Point2d& corner : {cv::Point2d(0, 0), {w, 0}, {0, h}, {w, h}})
  {
    const cv::Point2d p = place.place_of(corner);
    least_x_m_ = std::min(least_x_m_, p.x);
    most_x_m_ = std::max(most_x_m_, p.x);
    least_y_m_ = std::min(least_y_m_, p.y);
    most_y_m_ = std::max(most_y_m_, p.y);
  }
  map_.fill({{0, 0}, place.page}, io::bgr(io::palette::kNotSeen.rgb));
  draw_grid();
}

int PictureSheet::px(double unscaled) const { return cvRound(unscaled * scale_); }

std::vector<double> PictureSheet::x_ticks() const
{
  const double px_of_all = (most_x_m_ - least_x_m_) * place_.page_px_per_m();
  return ticks(least_x_m_, most_x_m_, px_of_all / (80 * scale_));
}

std::vector<double> PictureSheet::y_ticks() const
{
  const double px_of_all = (most_y_m_ - least_y_m_) * place_.page_px_per_m();
  return ticks(least_y_m_, most_y_m_, px_of_all / (45 * scale_));
}

void PictureSheet::draw_grid()
{
  for (const double t : x_ticks())
    map_.line({place_.drawn(t, least_y_m_), place_.drawn(t, most_y_m_)}, kGrid, 1);
  for (const double t : y_ticks())
    map_.line({place_.drawn(least_x_m_, t), place_.drawn(most_x_m_, t)}, kGrid, 1);
}

void PictureSheet::paint(const cv::Mat3b& cells, const cv::Mat1b& known)
{
  const cv::Mat1b whole = known > 0;
  const cv::Mat image = place_.on_page(cells, cv::INTER_LINEAR);
  const cv::Mat mask = place_.on_page(whole, cv::INTER_NEAREST);
  cv::Mat map = map_.image().clone();
  image.copyTo(map, mask);
  map_.paste(map, 0, 0);
}

void PictureSheet::draw_ways(const std::vector<std::vector<WayPoint>>& ways, int floor)
{
  std::vector<std::vector<cv::Point2d>> lines;
  for (const auto& way : ways)
  {
    auto& line = lines.emplace_back();
    for (const WayPoint& p : way)
      if (p.floor == floor) line.push_back(place_.drawn(p.x_m, p.y_m));
  }
  io::draw_ways(map_, lines, 3 * scale_, 9 * scale_);
}

double PictureSheet::on_edge(bool is_x, double t) const
{
  // Two points of the line on the page, and where it goes through the edge.
  const cv::Point2d a = is_x ? place_.drawn(t, least_y_m_) : place_.drawn(least_x_m_, t);
  const cv::Point2d b = is_x ? place_.drawn(t, most_y_m_) : place_.drawn(most_x_m_, t);
  const double w = place_.page.width, h = place_.page.height;
  const double part = is_x ? (h - a.y) / (b.y - a.y) : (0 - a.x) / (b.x - a.x);
  const double at = is_x ? a.x + part * (b.x - a.x) : a.y + part * (b.y - a.y);
  return at >= 0 && at <= (is_x ? w : h) ? at : std::numeric_limits<double>::quiet_NaN();
}

void PictureSheet::draw_axes(Canvas& page, const cv::Rect& plot) const
{
  TextStyle style{kText * scale_, kInk, false, Anchor::Middle, Anchor::Start, false};
  const int bottom = plot.br().y, tick = px(kTick);
  for (const double t : x_ticks())
  {
    const double at = on_edge(true, t);
    if (std::isnan(at)) continue;
    page.vertical(plot.x + cvRound(at), bottom, bottom + tick, kInk);
    page.text(io::tick_text(t, 1), plot.x + at, bottom + tick + px(7), style);
  }
  TextStyle label = style;
  label.colour = kFaintInk;
  page.text("x [m]", plot.x + plot.width / 2.0, bottom + tick + px(30), label);
  style.across = Anchor::End;
  style.down = Anchor::Middle;
  for (const double t : y_ticks())
  {
    const double at = on_edge(false, t);
    if (std::isnan(at)) continue;
    page.horizontal(plot.x - 1 - tick, plot.x - 1, plot.y + cvRound(at), kInk);
    page.text(io::tick_text(t, 1), plot.x - tick - px(7), plot.y + at, style);
  }
  label.upwards = true;
  page.text("y [m]", px(14), plot.y + plot.height / 2.0, label);
}

void PictureSheet::draw_titles(
    Canvas& page, const std::string& title, const std::vector<std::string>& lines) const
{
  const TextStyle large{17 * scale_, kInk, true, Anchor::Start, Anchor::Middle, false};
  const TextStyle small{11 * scale_, kFaintInk, false, Anchor::Start, Anchor::Middle, false};
  page.text(title, px(kLeft) - 1, px(34), large);
  int y = px(62);
  for (const std::string& line : lines)
  {
    page.text(line, px(kLeft) - 1, y, small);
    y += px(22);
  }
}

void PictureSheet::add_scale_and_north(const std::optional<GeoOrigin>& origin)
{
  constexpr double kDegree = 3.14159265358979323846 / 180;
  legend_.scale_bar(place_.page_px_per_m());
  if (!origin && place_.turn_rad == 0) return;  // the axes say it all
  // Of a map that nobody placed on Earth the y axis is all that can be shown.
  const double heading_rad = origin ? origin->heading_deg * kDegree : 0;
  legend_.north(
      place_.turn_rad - heading_rad, origin ? "N" : "y", origin ? "" : "y axis of the map");
}

cv::Mat PictureSheet::finish(const std::string& title, const std::vector<std::string>& lines)
{
  const cv::Rect plot({px(kLeft), px(kTop)}, map_.image().size());
  const bool is_wide = plot.width >= px(kMinWidth) && plot.width > 1.3 * plot.height;
  const int column = px(kColumn);
  const int room = is_wide ? plot.width : column, legend_px = legend_.height_px(room);
  const int width =
      std::max(plot.br().x + px(kEdge) + (is_wide ? 0 : column + px(kEdge)), px(kMinWidth));
  const int below = plot.br().y + px(kBelow);
  Canvas page(
      width,
      is_wide ? below + legend_px + px(kEdge) : std::max(below, plot.y + legend_px + px(kEdge)));
  page.paste(map_.image(), plot.x, plot.y);
  page.frame(plot, kInk);
  draw_titles(page, title, lines);
  draw_axes(page, plot);
  legend_.draw(
      page, is_wide ? cv::Point(plot.x, below) : cv::Point(plot.br().x + px(kEdge), plot.y), room);
  return page.image();
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
  if (area_m2 >= 1e6) return fixed_text(area_m2 / 1e6, 3) + " km\u00b2";
  return fixed_text(area_m2, decimals) + " m\u00b2";
}

}  // namespace talus::site
