#pragma once
#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace talus::io
{
/// @name Colours of a picture, BGR
/// @{
inline const cv::Scalar kPaper(255, 255, 255);
inline const cv::Scalar kInk(40, 34, 30);
inline const cv::Scalar kFaintInk(118, 110, 104);
inline const cv::Scalar kGridInk(224, 221, 219);  //!< lines behind what is drawn
/// @}

enum class Anchor
{
  Start,  //!< left, or top
  Middle,
  End  //!< right, or bottom
};

struct TextStyle
{
  double cap_height_px = 10;  //!< height of a capital letter
  cv::Scalar colour = kInk;
  bool bold = false;
  Anchor across = Anchor::Start;  //!< which part of the text lies at x
  Anchor down = Anchor::Middle;  //!< which part of its capital letters lies at y
  bool upwards = false;  //!< turned by 90 degrees, read from below
};

/** Drawing with smooth edges on an 8-bit BGR image; coordinates in pixels from the upper left
 * corner. */
class Canvas
{
 public:
  Canvas(int width, int height) : image_(height, width, CV_8UC3, kPaper) {}

  const cv::Mat& image() const { return image_; }
  void paste(const cv::Mat& bgr, int x, int y);
  void fill(const cv::Rect& area, const cv::Scalar& colour);
  /** One pixel wide, just outside of `area`. */
  void frame(const cv::Rect& area, const cv::Scalar& colour);
  void horizontal(int x0, int x1, int y, const cv::Scalar& colour);
  void vertical(int x, int y0, int y1, const cv::Scalar& colour);
  void polygon(
      const std::vector<cv::Point2d>& corners, const cv::Scalar& inside, const cv::Scalar& edge,
      double edge_px);
  /** An open line through the points. */
  void line(const std::vector<cv::Point2d>& points, const cv::Scalar& colour, double width_px);
  void ring(const cv::Point2d& middle, double radius_px, const cv::Scalar& colour, double width_px);
  /** In UTF-8. */
  void text(const std::string& text, double x, double y, const TextStyle& style);
  static double text_width(const std::string& text, const TextStyle& style);

 private:
  /** Blends `colour` over the image where the 8-bit mask, laid at (x, y), is not 0. */
  void blend(const cv::Mat& mask, int x, int y, const cv::Scalar& colour);

  cv::Mat image_;
};

}  // namespace talus::io
