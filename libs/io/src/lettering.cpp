#include "lettering.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace talus::io
{
namespace
{
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontCapHeight = 21;  // of a capital letter at scale 1
constexpr int kOversampling = 8;  // strokes are drawn this much larger, then averaged down

/** What the strokes can draw of it: ASCII, and a few signs that have a neighbour there. */
std::string as_ascii(const std::string& text)
{
  static constexpr std::array<std::pair<std::string_view, char>, 4> kNeighbours{
      {{"\u00b2", '2'}, {"\u00d7", 'x'}, {"\u2212", '-'}, {"\u2013", '-'}}};
  std::string ascii;
  for (std::size_t i = 0; i < text.size();)
  {
    const auto* same = std::find_if(
        kNeighbours.begin(), kNeighbours.end(),
        [&](const auto& n) { return text.compare(i, n.first.size(), n.first) == 0; });
    const bool is_known = same != kNeighbours.end();
    const char c = text[i];
    const bool is_plain = c >= ' ' && c <= '~';
    ascii += is_known ? same->second : is_plain ? c : '?';
    i += is_known ? same->first.size() : 1;
    while (!is_plain && i < text.size() && (text[i] & 0xc0) == 0x80) ++i;  // one '?' a letter
  }
  return ascii;
}

class Strokes : public Lettering
{
 public:
  double width_px(const std::string& text, const LetterSize& size) override
  {
    return static_cast<double>(
               cv::getTextSize(as_ascii(text), kFont, scale(size), thickness(size), nullptr)
                   .width) /
           kOversampling;
  }

  cv::Mat1b coverage(const std::string& text, const LetterSize& size, int border) override
  {
    const int wide = static_cast<int>(std::ceil(width_px(text, size))) + 2 * border;
    const int high = static_cast<int>(std::ceil(size.cap_height_px)) + 2 * border;
    cv::Mat1b large(high * kOversampling, wide * kOversampling, uchar{0}), mask;
    const cv::Point origin(
        border * kOversampling, static_cast<int>((border + size.cap_height_px) * kOversampling));
    cv::putText(
        large, as_ascii(text), origin, kFont, scale(size), cv::Scalar(255), thickness(size),
        cv::LINE_8);
    cv::resize(large, mask, {wide, high}, 0, 0, cv::INTER_AREA);
    return mask;
  }

 private:
  static double scale(const LetterSize& size)
  {
    return size.cap_height_px * kOversampling / kFontCapHeight;
  }
  static int thickness(const LetterSize& size)
  {
    const double stroke_px = size.cap_height_px * (size.bold ? 0.19 : 0.125);
    return std::max(1, static_cast<int>(std::lround(stroke_px * kOversampling)));
  }
};

/** Where Debian and Ubuntu, Fedora, and Arch put DejaVu. */
std::unique_ptr<Lettering> installed()
{
  for (const std::string folder :
       {"/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/dejavu-sans-fonts",
        "/usr/share/fonts/TTF"})
    if (auto found = typeface(folder + "/DejaVuSans.ttf", folder + "/DejaVuSans-Bold.ttf"))
      return found;
  return strokes();
}
}  // namespace

std::unique_ptr<Lettering> strokes() { return std::make_unique<Strokes>(); }

Lettering& lettering()
{
  thread_local const std::shared_ptr<Lettering> letters = installed();
  return *letters;
}

}  // namespace talus::io
