// The view of a map from above and aside: what is nearer hides what is behind it.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include <oblique.h>
#include <picture_style.h>

using namespace talus;
using namespace talus::pictures;

namespace
{
constexpr int kCells = 60;

/** Level ground, all of it free. */
io::LayerStack level()
{
  io::LayerStack s{kCells, kCells, 0.1, 0, 0, {}, {}};
  for (const auto& [name, value] :
       {std::pair<const char*, float>{"elevation", 0},
        {"ground_elevation", 0},
        {"state", 1},
        {"traversability", 1}})
  {
    s.names.emplace_back(name);
    s.layers.emplace_back(std::size_t{kCells} * kCells, value);
  }
  return s;
}

void set(io::LayerStack& s, int x, int y, float top_m, float score)
{
  s.layers[0][static_cast<std::size_t>(y) * kCells + x] = top_m;
  s.layers[3][static_cast<std::size_t>(y) * kCells + x] = score;
}

/** From the south, looking north. */
const Camera kFromSouth{{3, -4, 2}, {3, 3, 0}, 300, {400, 300}};

cv::Vec3b colour_at(const cv::Mat& image, const cv::Vec3d& place_m)
{
  const cv::Vec3d p = kFromSouth.pixel(place_m);
  return image.at<cv::Vec3b>(cvFloor(p[1]), cvFloor(p[0]));
}

/** BGR, in any light. */
bool is_like(const cv::Vec3b& c, const io::NamedColour& colour)
{
  const double light = cv::norm(c) / cv::norm(io::bgr(colour.rgb));
  return cv::norm(cv::Vec3d(c) - light * cv::Vec3d(io::bgr(colour.rgb))) < 15;
}
bool is_free(const cv::Vec3b& c) { return is_like(c, io::palette::kFree); }
}  // namespace

TEST(ObliqueView, sees_east_at_the_right_what_is_far_smaller_and_higher_up)
{
  const auto near_west = kFromSouth.pixel({2, 1, 0}), near_east = kFromSouth.pixel({4, 1, 0});
  const auto far_west = kFromSouth.pixel({2, 5, 0}), far_east = kFromSouth.pixel({4, 5, 0});
  EXPECT_LT(near_west[0], near_east[0]);
  EXPECT_LT(far_east[0] - far_west[0], near_east[0] - near_west[0]);
  EXPECT_LT(far_west[1], near_west[1]);
  EXPECT_LT(kFromSouth.pixel({2, 1, 0.5})[1], near_west[1]) << "up is up";
  const auto target = kFromSouth.pixel(kFromSouth.target_m);
  EXPECT_NEAR(target[0], 200, 1e-6);
  EXPECT_NEAR(target[1], 150, 1e-6);
}

TEST(ObliqueView, colours_the_ground_by_its_traversability)
{
  io::LayerStack map = level();
  for (int y = 25; y < 35; ++y)
    for (int x = 0; x < 30; ++x) set(map, x, y, 0, 0);
  const cv::Mat image = draw_oblique(map, kFromSouth, {}, {{-50, -50}});
  EXPECT_TRUE(is_like(colour_at(image, {1.5, 3, 0}), io::palette::kBlocked));
  EXPECT_TRUE(is_free(colour_at(image, {4.5, 3, 0})));
  EXPECT_EQ(image.at<cv::Vec3b>(2, 2), cv::Vec3b(255, 255, 255)) << "nothing is known there";
}

TEST(ObliqueView, a_wall_hides_the_ground_behind_it_and_not_that_before_it)
{
  io::LayerStack map = level();
  for (int x = 20; x < 40; ++x) set(map, x, 20, 1.5F, 0);
  const cv::Mat image = draw_oblique(map, kFromSouth, {}, {{-50, -50}});
  EXPECT_TRUE(is_free(colour_at(image, {3, 1, 0})));
  EXPECT_FALSE(is_free(colour_at(image, {3, 3, 0}))) << "hidden";
  EXPECT_TRUE(is_free(colour_at(image, {5, 3, 0}))) << "beside";
  for (int x = 20; x < 40; ++x) set(map, x, 20, 1.5F, 1);  // it hangs
  const cv::Mat hangs = draw_oblique(map, kFromSouth, {}, {{-50, -50}});
  EXPECT_TRUE(is_free(colour_at(hangs, {3, 3, 0})));
}

TEST(ObliqueView, draws_the_robot_on_its_way)
{
  const RobotBox robot{{3, 3}, 1.5707963, 1, 0.6, 0.5};
  const cv::Mat image = draw_oblique(level(), kFromSouth, {{3, 0.5}, {3, 3}}, robot);
  EXPECT_EQ(colour_at(image, {3, 1, 0.03}), io::bgr(io::palette::kPath.rgb));
  const cv::Vec3b back = colour_at(image, {3.2, 2.5, 0.35});
  EXPECT_EQ(back[0], back[2]) << "grey";
}
