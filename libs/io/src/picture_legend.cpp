#include "picture_legend.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace talus::io
{
namespace
{
/// @name Pixels at scale 1
/// @{
constexpr double kText = 10, kSwatch = 18, kStrip = 130, kWords = 9, kGap = 26, kRowGap = 12;
constexpr double kWidestBar = 160;
/// @}
}  // namespace

int Legend::px(double unscaled) const { return static_cast<int>(std::lround(unscaled * scale_)); }

TextStyle Legend::words_style(bool bold) const
{
  return {kText * scale_, kInk, bold, Anchor::Start, Anchor::Middle, false};
}

void Legend::mark(cv::Size mark, const std::string& words, Draw draw)
{
  const TextStyle style = words_style();
  const int gap = words.empty() ? 0 : px(kWords);
  const cv::Size size(
      mark.width + gap + static_cast<int>(std::ceil(Canvas::text_width(words, style))),
      std::max(mark.height, px(kSwatch)));
  const auto both = [=, draw = std::move(draw)](Canvas& canvas, cv::Point corner)
  {
    draw(canvas, corner + cv::Point(0, (size.height - mark.height) / 2));
    canvas.text(words, corner.x + mark.width + gap, corner.y + size.height / 2.0, style);
  };
  items_.push_back({size, both, begins_row_});
  begins_row_ = false;
}

void Legend::new_row() { begins_row_ = true; }

void Legend::heading(const std::string& words)
{
  const TextStyle style = words_style(true);
  const int width = static_cast<int>(std::ceil(Canvas::text_width(words, style)));
  const int height = px(kSwatch);
  mark(
      {width, height}, "",
      [=](Canvas& canvas, cv::Point corner)
      { canvas.text(words, corner.x, corner.y + height / 2.0, style); });
}

void Legend::colours(const std::string& low, const cv::Mat& strip, const std::string& high)
{
  const TextStyle style = words_style();
  const int words = static_cast<int>(std::ceil(Canvas::text_width(low, style))) + px(kWords);
  const cv::Size bar(px(kStrip), px(kSwatch));
  cv::Mat image;
  cv::resize(strip.t(), image, bar, 0, 0, cv::INTER_LINEAR);
  mark(
      {words + bar.width, bar.height}, high,
      [=](Canvas& canvas, cv::Point corner)
      {
        canvas.text(low, corner.x, corner.y + bar.height / 2.0, style);
        canvas.paste(image, corner.x + words, corner.y);
        canvas.frame({corner + cv::Point(words, 0), bar}, kFaintInk);
      });
}

void Legend::swatch(const cv::Vec3b& colour, const std::string& words)
{
  const cv::Size size(px(kSwatch), px(kSwatch));
  mark(
      size, words,
      [=](Canvas& canvas, cv::Point corner)
      {
        canvas.fill({corner, size}, cv::Scalar(colour));
        canvas.frame({corner, size}, kFaintInk);
      });
}

void Legend::way(const std::string& words)
{
  const double s = scale_;
  mark(
      {px(64), px(26)}, words,
      [s](Canvas& canvas, cv::Point corner)
      {
        const cv::Point2d left(corner.x + 13 * s, corner.y + 13 * s);
        draw_ways(canvas, {{left, left + cv::Point2d(40 * s, 0)}}, 3 * s, 9 * s);
      });
}

void Legend::way_line(const std::string& words)
{
  const double s = scale_;
  mark(
      {px(40), px(kSwatch)}, words,
      [s](Canvas& canvas, cv::Point corner)
      {
        const cv::Point2d left(corner.x, corner.y + kSwatch * s / 2);
        draw_way_line(canvas, {left, left + cv::Point2d(40 * s, 0)}, 3 * s);
      });
}

void Legend::robot(const std::string& words)
{
  const double s = scale_;
  mark(
      {px(26), px(kSwatch)}, words,
      [s](Canvas& canvas, cv::Point corner) {
        draw_robot(canvas, {corner.x + 12 * s, corner.y + kSwatch * s / 2}, 0, 24 * s);
      });
}

void Legend::scale_bar(double px_per_m)
{
  const double length_m = round_length_m(kWidestBar * scale_ / px_per_m);
  const cv::Size bar(static_cast<int>(std::lround(length_m * px_per_m)), px(8));
  mark(
      bar, length_text(length_m),
      [=](Canvas& canvas, cv::Point corner)
      { draw_scale_bar(canvas, corner, bar.width, bar.height); });
}

void Legend::north(double turn_rad, const std::string& letter, const std::string& words)
{
  const double s = scale_;
  mark(
      {px(40), px(60)}, words,
      [=](Canvas& canvas, cv::Point corner) {
        draw_north(canvas, {corner.x + 20 * s, corner.y + 34 * s}, turn_rad, 38 * s, letter);
      });
}

std::vector<Legend::Placed> Legend::placed(int width_px, int& height_px) const
{
  std::vector<Placed> all;
  cv::Point at(0, 0);
  int row_height = 0;
  std::size_t row_begin = 0;
  const auto end_row = [&]
  {
    for (std::size_t i = row_begin; i < all.size(); ++i)  // on one middle line
      all[i].corner.y += (row_height - all[i].item->size.height) / 2;
    row_begin = all.size();
  };
  for (const Item& item : items_)
  {
    if (at.x > 0 && (item.begins_row || at.x + item.size.width > width_px))
    {
      end_row();
      at = {0, at.y + row_height + px(kRowGap)};
      row_height = 0;
    }
    all.push_back({&item, at});
    at.x += item.size.width + px(kGap);
    row_height = std::max(row_height, item.size.height);
  }
  end_row();
  height_px = at.y + row_height;
  return all;
}

void add_terrain(Legend& legend, const std::string& heading)
{
  if (!heading.empty()) legend.heading(heading);
  legend.colours(palette::kBlocked.name, colours_of(Palette::Scores), palette::kFree.name);
  for (const NamedColour& c :
       {palette::kStands, palette::kInferred, palette::kGuessed, palette::kNotSeen})
    legend.swatch(c);
}

int Legend::height_px(int width_px) const
{
  int height = 0;
  placed(width_px, height);
  return height;
}

void Legend::draw(Canvas& canvas, cv::Point corner, int width_px) const
{
  int height = 0;
  for (const Placed& p : placed(width_px, height)) p.item->draw(canvas, corner + p.corner);
}

}  // namespace talus::io
