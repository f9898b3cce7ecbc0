#pragma once
#include <opencv2/core.hpp>

#include <memory>
#include <string>

namespace talus::io
{
/** How large and how heavy letters are. */
struct LetterSize
{
  double cap_height_px = 10;  //!< height of a capital letter
  bool bold = false;
};

/** Turns text (UTF-8) into pixels. */
class Lettering
{
 public:
  virtual ~Lettering() = default;

  /** How far the text runs, pixels. */
  virtual double width_px(const std::string& text, const LetterSize& size) = 0;
  /** Coverage of the text, 0 to 255: `border` pixels, the box of its capitals, `border` pixels. */
  virtual cv::Mat1b coverage(const std::string& text, const LetterSize& size, int border) = 0;
};

/** FreeType with the two files of a typeface; null where one of them cannot be read. */
std::unique_ptr<Lettering> typeface(const std::string& plain, const std::string& bold);

/** The strokes of OpenCV, which are always there; they know ASCII only. */
std::unique_ptr<Lettering> strokes();

/** DejaVu Sans where it is installed, else the strokes: the same picture has the same letters
 * whatever other typefaces a machine has. One for each thread. */
Lettering& lettering();

}  // namespace talus::io
