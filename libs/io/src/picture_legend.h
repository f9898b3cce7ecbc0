#pragma once
#include <functional>
#include <string>
#include <vector>

#include "picture_canvas.h"
#include "picture_style.h"

namespace talus::io
{
/** What the colours and marks of a picture mean: in rows as wide as there is room, so that a narrow
 * one is a column. */
class Legend
{
 public:
  /** Everything is drawn `scale` times as large as on a small picture. */
  explicit Legend(double scale = 1) : scale_(scale) {}

  void heading(const std::string& words);
  /** A strip of colours (N x 1) from the first to the last between two words. */
  void colours(const std::string& low, const cv::Mat& strip, const std::string& high);
  void swatch(const NamedColour& colour) { swatch(bgr(colour.rgb), colour.name); }
  void swatch(const cv::Vec3b& colour, const std::string& words);
  void way(const std::string& words);  //!< with the marks of its start and its end
  void way_line(const std::string& words);
  void robot(const std::string& words);
  void scale_bar(double px_per_m);
  /** `turn_rad` as draw_north(). */
  void north(double turn_rad, const std::string& letter, const std::string& words);
  using Draw = std::function<void(Canvas&, cv::Point corner)>;
  /** A mark of a size with words to its right. */
  void mark(cv::Size size, const std::string& words, Draw draw);
  /** What follows begins a row. */
  void new_row();

  int height_px(int width_px) const;
  void draw(Canvas& canvas, cv::Point corner, int width_px) const;

 private:
  struct Item
  {
    cv::Size size;
    Draw draw;
    bool begins_row = false;
  };
  struct Placed
  {
    const Item* item;
    cv::Point corner;
  };

  int px(double unscaled) const;
  TextStyle words_style(bool bold = false) const;
  std::vector<Placed> placed(int width_px, int& height_px) const;

  double scale_;
  std::vector<Item> items_;
  bool begins_row_ = false;
};

/** What the colours of paint_terrain() mean; `heading` first, unless it is empty. */
void add_terrain(Legend& legend, const std::string& heading = "Traversability");

/** The arrow that stands for the robot, `length_px` long, with its middle at a point; `yaw_rad`
 * counter-clockwise from the right. */
void draw_robot(Canvas& canvas, cv::Point2d middle, double yaw_rad, double length_px);

/** Ways with a bright edge, a ring where each begins and a square where it ends. */
void draw_ways(
    Canvas& canvas, const std::vector<std::vector<cv::Point2d>>& ways, double width_px,
    double mark_px);
/** The line alone. */
void draw_way_line(Canvas& canvas, const std::vector<cv::Point2d>& way, double width_px);

/** An arrow with the letter at its tip; `turn_rad` counter-clockwise from upwards. */
void draw_north(
    Canvas& canvas, cv::Point2d middle, double turn_rad, double length_px,
    const std::string& letter);

/** Black and white, `length_px` long. */
void draw_scale_bar(Canvas& canvas, cv::Point corner, int length_px, int height_px);

/** A round length (1, 2 or 5 times a power of ten) that is at most `longest_m`. */
double round_length_m(double longest_m);
/** "20 m", "5 km". */
std::string length_text(double length_m);

}  // namespace talus::io
