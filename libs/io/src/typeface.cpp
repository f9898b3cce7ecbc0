#include "lettering.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H
#include FT_TRUETYPE_TABLES_H

#include <algorithm>
#include <cmath>
#include <vector>

namespace talus::io
{
namespace
{
constexpr char32_t kReplacement = 0xfffd;  //!< for bytes that are no UTF-8
constexpr double kUnit = 64;  //!< of FreeType's lengths, per pixel

/** The letter that begins at text[i], which moves behind it. */
char32_t next_letter(const std::string& text, std::size_t& i)
{
  const auto first = static_cast<unsigned char>(text[i++]);
  if (first < 0x80) return first < 0x20 ? kReplacement : first;
  const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
  if (first < 0xc2 || first > 0xf4) return kReplacement;
  char32_t letter = first & (0x3f >> more);
  for (int k = 0; k < more; ++k)
  {
    if (i >= text.size() || (text[i] & 0xc0) != 0x80) return kReplacement;
    letter = letter << 6 | (static_cast<unsigned char>(text[i++]) & 0x3f);
  }
  return letter;
}

/** A file of a typeface, opened. */
class Face
{
 public:
  Face(FT_Library library, const std::string& file)
  {
    if (FT_New_Face(library, file.c_str(), 0, &face_) != 0) face_ = nullptr;
  }
  ~Face()
  {
    if (face_) FT_Done_Face(face_);
  }
  Face(const Face&) = delete;
  Face& operator=(const Face&) = delete;

  bool is_open() const { return face_ && FT_IS_SCALABLE(face_); }

  void set_cap_height(double px)
  {
    constexpr double kUsualPart = 0.72;  // of the em
    const auto* os2 = static_cast<const TT_OS2*>(FT_Get_Sfnt_Table(face_, FT_SFNT_OS2));
    const bool tells = os2 && os2->version >= 2 && os2->sCapHeight > 0;
    const double part =
        tells ? static_cast<double>(os2->sCapHeight) / face_->units_per_EM : kUsualPart;
    FT_Set_Char_Size(face_, 0, std::lround(px / part * kUnit), 72, 72);
  }

  /** Calls draw(glyph, x) with the outline of each letter and where it begins, pixels; returns
   * where the text ends. */
  template <class F>
  double for_each_glyph(const std::string& text, const F& draw)
  {
    double x_px = 0;
    FT_UInt last = 0;
    for (std::size_t i = 0; i < text.size();)
    {
      const FT_UInt glyph = FT_Get_Char_Index(face_, next_letter(text, i));
      FT_Vector kern{0, 0};
      if (last && glyph) FT_Get_Kerning(face_, last, glyph, FT_KERNING_UNFITTED, &kern);
      x_px += static_cast<double>(kern.x) / kUnit;
      if (FT_Load_Glyph(face_, glyph, FT_LOAD_NO_BITMAP | FT_LOAD_TARGET_LIGHT) == 0)
      {
        constexpr double kFixed = 65536;
        const double advance_px = static_cast<double>(face_->glyph->linearHoriAdvance) / kFixed;
        draw(face_->glyph, x_px);
        x_px += advance_px;
      }
      last = glyph;
    }
    return x_px;
  }

 private:
  FT_Face face_ = nullptr;
};

/** Lays the pixels of a rendered letter over those that are there. */
void lay(const FT_Bitmap& bitmap, int left, int top, cv::Mat1b& onto)
{
  for (int y = 0; y < static_cast<int>(bitmap.rows); ++y)
    for (int x = 0; x < static_cast<int>(bitmap.width); ++x)
      if (cv::Rect(0, 0, onto.cols, onto.rows).contains({left + x, top + y}))
      {
        uchar& pixel = onto(top + y, left + x);
        pixel = std::max(pixel, bitmap.buffer[y * bitmap.pitch + x]);
      }
}

class Typeface : public Lettering
{
 public:
  Typeface(FT_Library library, const std::string& plain, const std::string& bold)
      : plain_(library, plain), bold_(library, bold)
  {
  }

  bool is_open() const { return plain_.is_open() && bold_.is_open(); }

  double width_px(const std::string& text, const LetterSize& size) override
  {
    return sized(size).for_each_glyph(text, [](FT_GlyphSlot, double) {});
  }

  cv::Mat1b coverage(const std::string& text, const LetterSize& size, int border) override
  {
    const int wide = static_cast<int>(std::ceil(width_px(text, size))) + 2 * border;
    const int high = static_cast<int>(std::ceil(size.cap_height_px)) + 2 * border;
    const int base = border + static_cast<int>(std::lround(size.cap_height_px));
    cv::Mat1b mask(high, wide, uchar{0});
    sized(size).for_each_glyph(
        text,
        [&](FT_GlyphSlot glyph, double x_px)
        {
          const double whole = std::floor(x_px);
          FT_Outline_Translate(&glyph->outline, std::lround((x_px - whole) * kUnit), 0);
          if (FT_Render_Glyph(glyph, FT_RENDER_MODE_NORMAL) == 0)
            lay(glyph->bitmap, border + static_cast<int>(whole) + glyph->bitmap_left,
                base - glyph->bitmap_top, mask);
        });
    return mask;
  }

 private:
  Face& sized(const LetterSize& size)
  {
    Face& face = size.bold ? bold_ : plain_;
    face.set_cap_height(size.cap_height_px);
    return face;
  }

  Face plain_, bold_;
};

/** FreeType, of which each thread needs one of its own. */
struct Library
{
  FT_Library ft = nullptr;
  Library()
  {
    if (FT_Init_FreeType(&ft) != 0) ft = nullptr;
  }
  ~Library()
  {
    if (ft) FT_Done_FreeType(ft);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

/** A typeface that outlives its library by no means. */
struct OwnTypeface : private Library, public Typeface
{
  OwnTypeface(const std::string& plain, const std::string& bold) : Typeface(ft, plain, bold) {}
};
}  // namespace

std::unique_ptr<Lettering> typeface(const std::string& plain, const std::string& bold)
{
  auto letters = std::make_unique<OwnTypeface>(plain, bold);
  if (!letters->is_open()) return nullptr;
  return letters;
}

}  // namespace talus::io
