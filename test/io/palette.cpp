// Colours of maps: told apart also by who confuses red and green.
#include <gtest/gtest.h>
#include <talus/io/palette.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

using namespace talus;
using namespace talus::io;

namespace
{
/** What eyes make of linear red, green, blue: Machado et al. 2009, severity 1. */
const cv::Matx33d kAllCones = cv::Matx33d::eye(),
                  kProtanopia(
                      0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882,
                      -0.048116, 1.051998),
                  kDeuteranopia(
                      0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820,
                      0.042940, 0.968881);

/** CIE L*a*b* as these eyes see a colour. */
cv::Vec3d lab_of(const Rgb& c, const cv::Matx33d& eyes)
{
  const auto linear = [](double v)
  { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  const cv::Matx33d xyz_of_rgb(
      0.4339, 0.3762, 0.1899, 0.2126, 0.7152, 0.0722, 0.0177, 0.1095, 0.8730);  // white: 1, 1, 1
  cv::Vec3d rgb =
      eyes * cv::Vec3d(linear(c[0] / 255.0), linear(c[1] / 255.0), linear(c[2] / 255.0));
  for (int k = 0; k < 3; ++k) rgb[k] = std::min(1.0, std::max(0.0, rgb[k]));
  const cv::Vec3d xyz = xyz_of_rgb * rgb;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(xyz[1]) - 16, 500 * (f(xyz[0]) - f(xyz[1])), 200 * (f(xyz[1]) - f(xyz[2]))};
}

/** CIE76 for the eyes that tell the two apart worst. */
double distance(const Rgb& a, const Rgb& b)
{
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& eyes : {kAllCones, kProtanopia, kDeuteranopia})
    smallest = std::min(smallest, cv::norm(lab_of(a, eyes) - lab_of(b, eyes)));
  return smallest;
}

/** A just noticeable difference is 2.3; patches of a map are small and apart. */
constexpr double kApart = 12, kShadesApart = 8;

template <class Colours>
void expect_apart(const Colours& colours)
{
  for (auto a = colours.begin(); a != colours.end(); ++a)
    for (auto b = std::next(a); b != colours.end(); ++b)
      EXPECT_GT(distance(a->rgb, b->rgb), kApart) << a->name << " and " << b->name;
}
}  // namespace

TEST(Palette, colours_of_one_legend_are_apart_for_all_eyes)
{
  namespace p = palette;
  expect_apart(std::vector<NamedColour>{
      p::kBlocked, p::kHard, p::kUneven, p::kFree, p::kStands, p::kNotJudged, p::kNotSeen,
      p::kMayDrop, p::kPath, p::kKnownBlocked, p::kGiven});
  for (const Rgb& shade : {pale(p::kFree.rgb), pale(p::kNotJudged.rgb)})
    EXPECT_GT(distance(shade, p::kNotSeen.rgb), kShadesApart);
  EXPECT_GT(distance(pale(p::kFree.rgb), p::kFree.rgb), kShadesApart);
  EXPECT_GT(distance(pale(p::kFree.rgb), pale(p::kNotJudged.rgb)), kApart);
  expect_apart(p::kStates);
  expect_apart(p::kChanges);
  expect_apart(p::kLabels);
}

TEST(Palette, orange_is_ground_that_is_hard_to_drive_and_nothing_else)
{
  namespace p = palette;
  const auto is_orange = [](const Rgb& c)
  { return c[0] > 190 && c[1] > 70 && c[1] < c[0] - 40 && c[2] < c[1] - 30; };
  EXPECT_TRUE(is_orange(p::kHard.rgb));
  const auto expect_none = [&](const auto& colours)
  {
    for (const NamedColour& c : colours) EXPECT_FALSE(is_orange(c.rgb)) << c.name;
  };
  expect_none(std::vector<NamedColour>{
      p::kBlocked, p::kFree, p::kStands, p::kNotJudged, p::kMayDrop, p::kPath, p::kKnownBlocked,
      p::kGiven});
  expect_none(p::kStates);
  expect_none(p::kChanges);
  expect_none(p::kLabels);
}

TEST(Palette, a_score_gets_lighter_from_blocked_to_free)
{
  EXPECT_EQ(score_colour(-1), palette::kBlocked.rgb);
  EXPECT_EQ(score_colour(0.9F), palette::kFree.rgb);
  EXPECT_EQ(score_colour(7), palette::kFree.rgb);
  EXPECT_EQ(score_colour(std::numeric_limits<float>::quiet_NaN()), palette::kNotJudged.rgb);
  for (const auto& eyes : {kAllCones, kProtanopia, kDeuteranopia})
    for (int tenth = 1; tenth <= 9; ++tenth)
    {
      const float score = 0.1F * static_cast<float>(tenth);
      EXPECT_GT(lab_of(score_colour(score), eyes)[0], lab_of(score_colour(score - 0.1F), eyes)[0]);
    }
}
