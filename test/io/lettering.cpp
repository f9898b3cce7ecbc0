// Letters of pictures: of a typeface where there is one, else strokes.
#include <gtest/gtest.h>

#include <algorithm>

#include <lettering.h>

using namespace talus::io;

namespace
{
const std::string kDejaVu = "/usr/share/fonts/truetype/dejavu/DejaVuSans";

std::unique_ptr<Lettering> dejavu() { return typeface(kDejaVu + ".ttf", kDejaVu + "-Bold.ttf"); }

bool has_dejavu() { return dejavu() != nullptr; }

int ink(const cv::Mat1b& mask)
{
  return static_cast<int>(std::count_if(mask.begin(), mask.end(), [](uchar c) { return c > 127; }));
}
}  // namespace

TEST(Lettering, takes_the_typeface_that_is_installed)
{
  if (!has_dejavu()) GTEST_SKIP() << "fonts-dejavu-core is not installed";
  const LetterSize size{20, false};
  EXPECT_EQ(
      cv::norm(
          lettering().coverage("Talus", size, 20), dejavu()->coverage("Talus", size, 20),
          cv::NORM_INF),
      0);
}

TEST(Lettering, draws_strokes_where_there_is_no_typeface)
{
  EXPECT_EQ(typeface("/nowhere/a.ttf", "/nowhere/b.ttf"), nullptr);
  EXPECT_EQ(typeface(kDejaVu + ".ttf", "/etc/passwd"), nullptr);
  const LetterSize size{20, false};
  EXPECT_GT(ink(strokes()->coverage("Talus", size, 20)), 100);
  EXPECT_GT(strokes()->width_px("Talus", size), 50);
}

TEST(Lettering, has_capitals_of_the_wanted_height_on_the_same_line)
{
  const int border = 20;
  const auto drawn = strokes();
  for (Lettering* letters : {&lettering(), drawn.get()})
  {
    const cv::Mat1b mask = letters->coverage("HEH", {30, false}, border);
    int first = mask.rows, last = 0;
    for (int y = 0; y < mask.rows; ++y)
      if (ink(mask.row(y)) > 0)
      {
        first = std::min(first, y);
        last = std::max(last, y);
      }
    EXPECT_NEAR(first, border, 3);
    EXPECT_NEAR(last, border + 30, 3);
  }
}

TEST(Lettering, draws_every_letter_of_a_name_and_survives_bytes_that_are_none)
{
  const LetterSize size{20, true};
  for (const std::string text :
       {"Stra\u00dfe \u00e9 \u00b2", "\xff\xfe", "cut \xc3", "\xe2\x82", "tab\t\n",
        "\xf4\x90\x80\x80"})
  {
    EXPECT_GT(ink(lettering().coverage(text, size, 20)), 0) << text;
    EXPECT_GT(ink(strokes()->coverage(text, size, 20)), 0) << text;
  }
  EXPECT_EQ(strokes()->width_px("m\u00b2", size), strokes()->width_px("m2", size));
  EXPECT_EQ(strokes()->width_px("\u00e9", size), strokes()->width_px("?", size));
  if (!has_dejavu()) GTEST_SKIP() << "fonts-dejavu-core is not installed";
  EXPECT_NE(
      cv::countNonZero(dejavu()->coverage("\u00e9", size, 20) != dejavu()->coverage("e", size, 20)),
      0);
}

TEST(Lettering, bold_letters_have_more_ink)
{
  EXPECT_GT(
      ink(lettering().coverage("talus", {20, true}, 20)),
      1.2 * ink(lettering().coverage("talus", {20, false}, 20)));
  EXPECT_EQ(lettering().width_px("", {20, false}), 0);
}
