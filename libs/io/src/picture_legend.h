#pragma once
#include "picture_canvas.h"
#include "picture_style.h"

#include <functional>
#include <string>
#include <vector>

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
  void swatch(const cv::Vec3b& colour, const std::string& words);
  void way(const std::string& words);  //!< with the marks of its start and its end
  void way_line(const std::string& words);
  void robot(const std::string& words);
  void scale_bar(double px_per_m);
  /** `turn_rad` as draw_north(). */
  void north(double turn_rad, const std::string& letter, const std::string& words);
  /** What follows begins a row. */
  void new_row();

  int height_px(int width_px) const;
  void draw(Canvas& canvas, cv::Point corner, int width_px) const;

 private:
  using Draw = std::function<void(Canvas&, cv::Point corner)>;
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
  /** A mark of a size with words to its right. */
  void add(cv::Size mark, const std::string& words, Draw draw);
  std::vector<Placed> placed(int width_px, int& height_px) const;

  double scale_;
  std::vector<Item> items_;
  bool begins_row_ = false;
};

}  // namespace talus::io
