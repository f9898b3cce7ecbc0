#include <gtest/gtest.h>
#include <talus/io/map_picture.h>
#include <talus/io/palette.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "log_files.h"

using namespace talus;
using namespace talus::io;
using talus::test::expect_error;
using talus::test::read_bytes;
using talus::test::ScratchDir;
using talus::test::write_bytes;

namespace
{
constexpr int kCells = 40;
const float kNan = std::numeric_limits<float>::quiet_NaN();

/** A stack of the named layers, each cell as `value(ix, iy)`. */
template <typename Value>
LayerStack stack_of(const std::vector<std::string>& names, Value value)
{
  LayerStack s;
  s.cells_x = s.cells_y = kCells;
  s.resolution_m = 0.1;
  s.min_x_m = s.min_y_m = -2;
  s.names = names;
  std::vector<float> layer;
  for (int iy = 0; iy < kCells; ++iy)
    for (int ix = 0; ix < kCells; ++ix) layer.push_back(value(ix, iy));
  s.layers.assign(names.size(), layer);
  return s;
}

std::vector<std::string> all_names()
{
  std::vector<std::string> names;
  for (int i = 0; i < kLayerCount; ++i) names.emplace_back(kLayerTable[i].name);
  return names;
}

/** Where the pixels of a colour (BGR) lie, and how many there are. */
struct Patch
{
  int count = 0;
  double x = 0, y = 0;  //!< mean
};

Patch patch_of(const cv::Mat& picture, const cv::Vec3b& bgr)
{
  Patch p;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (picture.at<cv::Vec3b>(y, x) == bgr)
      {
        ++p.count;
        p.x += x;
        p.y += y;
      }
  p.x /= std::max(1, p.count);
  p.y /= std::max(1, p.count);
  return p;
}

/// @name Colours of the large map, BGR
/// @{
cv::Vec3b bgr(const NamedColour& c) { return {c.rgb[2], c.rgb[1], c.rgb[0]}; }
const cv::Vec3b kBlocked = bgr(palette::kBlocked), kFree = bgr(palette::kFree),
                kUnknown = bgr(palette::kNotSeen), kNotJudged = bgr(palette::kNotJudged),
                kStands = bgr(palette::kStands), kWay = bgr(palette::kPath);
/// @}
constexpr int kLarge_px = 960 * 960, kSmall_px = 200 * 200;

bool same(const cv::Mat& a, const cv::Mat& b)
{
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}
}  // namespace

TEST(MapPicture, RedGreenAndBlueAreOnePanelOfTheirColours)
{
  LayerStack s = stack_of(all_names(), [](int, int) { return 0.5F; });
  const auto add = [&](const std::string& name, float value)
  {
    s.names.push_back(name);
    s.layers.emplace_back(std::size_t{kCells} * kCells, value);
  };
  add("red", 200);
  add("green", 100);
  const int width_without = draw_map(s).cols;
  add("blue", 50);
  const cv::Mat picture = draw_map(s);
  EXPECT_GT(patch_of(picture, {50, 100, 200}).count, kCells * kCells);
  EXPECT_LE(picture.cols, width_without);
  s.layers.back().assign(s.layers.back().size(), kNan);
  EXPECT_EQ(patch_of(draw_map(s), {50, 100, 200}).count, 0);
}

TEST(MapPicture, shows_north_above_south_and_east_right_of_west)
{
  const auto south_west = [](int ix, int iy) { return ix < 20 && iy < 20 ? 0.0F : 1.0F; };
  const cv::Mat picture = draw_map(stack_of({"traversability"}, south_west));
  const Patch blocked = patch_of(picture, kBlocked), free = patch_of(picture, kFree);
  EXPECT_NEAR(blocked.count, kLarge_px / 4, 100);
  EXPECT_NEAR(static_cast<double>(free.count) / blocked.count, 3.0, 0.1)
      << "three quarters are free";
  EXPECT_GT(blocked.y, free.y) << "south is below";
  EXPECT_LT(blocked.x, free.x) << "west is left";
}

TEST(MapPicture, shows_ground_that_was_not_judged_in_another_colour_than_what_is_unknown)
{
  LayerStack stack = stack_of({"state", "traversability"}, [](int, int) { return kNan; });
  for (std::size_t i = 0; i < stack.layers[0].size(); ++i)  // the southern half has ground
    stack.layers[0][i] = i < stack.layers[0].size() / 2 ? 1.0F : 0.0F;
  stack.layers[1].back() = 1;
  const cv::Mat picture = draw_map(stack);
  const Patch not_judged = patch_of(picture, kNotJudged), unknown = patch_of(picture, kUnknown);
  EXPECT_NEAR(not_judged.count, kLarge_px / 2, 1000);
  EXPECT_NEAR(unknown.count, kLarge_px / 2 + kSmall_px / 2, 4000) << "in both panels";
  EXPECT_GT(not_judged.y, unknown.y);
}

TEST(MapPicture, judges_a_free_guess_from_one_side_no_more_than_a_site_does)
{
  LayerStack stack = stack_of({"state", "traversability"}, [](int, int) { return 3.0F; });
  for (const bool is_site : {false, true})
  {
    if (is_site) stack.names.emplace_back("age"), stack.layers.push_back(stack.layers[0]);
    const int guessed = patch_of(draw_map(stack), bgr(palette::kGuessed)).count;
    EXPECT_EQ(guessed > kLarge_px / 2, !is_site) << "of a site rays have proved it";
  }
}

TEST(MapPicture, shows_the_traversability_large_and_every_other_layer_small_beside_it)
{
  const auto free = [](int, int) { return 1.0F; };
  const cv::Mat one = draw_map(stack_of({"traversability"}, free));
  const cv::Mat nine = draw_map(stack_of(all_names(), free));
  EXPECT_NEAR(patch_of(one, kFree).count, kLarge_px, 1000);
  EXPECT_NEAR(nine.rows, one.rows, 60) << "the others have room beside it";
  EXPECT_GT(nine.cols, one.cols + 2 * 200);
  LayerStack late = stack_of({"elevation", "traversability"}, free);
  EXPECT_GT(patch_of(draw_map(late), kFree).count, 0.9 * kLarge_px) << "whatever their order";
  const cv::Mat other = draw_map(stack_of({"ground", "label"}, free));
  EXPECT_GT(other.cols, one.cols) << "layers of other files are drawn too";
}

TEST(MapPicture, shades_the_ground_under_the_traversability)
{
  LayerStack stack = stack_of({"ground_elevation", "traversability"}, [](int, int) { return 1; });
  const auto shaded_px = [&](float rise)
  {
    for (int i = 0; i < kCells * kCells; ++i)  // a ramp that falls to the east in its middle
      stack.layers[0][static_cast<std::size_t>(i)] =
          i % kCells < 15 || i % kCells > 25 ? 0 : rise * static_cast<float>(25 - i % kCells);
    return kLarge_px - patch_of(draw_map(stack), kFree).count;
  };
  EXPECT_LT(shaded_px(0), 1000);
  EXPECT_GT(shaded_px(0.03F), kLarge_px / 8);
}

TEST(MapPicture, shows_in_dark_what_stands_in_the_way_and_not_what_hangs)
{
  LayerStack stack =
      stack_of({"elevation", "ground_elevation", "traversability"}, [](int, int) { return 0; });
  const auto dark = [&](float top_m, float score)
  {
    stack.layers[0][0] = top_m;
    stack.layers[2][0] = score;
    return patch_of(draw_map(stack), kStands).count;
  };
  const int legend = dark(0, 0);
  EXPECT_EQ(dark(0.5F, 0), legend + 24 * 24) << "a cell";
  EXPECT_EQ(dark(0.5F, 1), legend) << "passable";
}

TEST(MapPicture, draws_the_way_of_the_robot_inside_of_the_map_only)
{
  const LayerStack stack = stack_of({"traversability"}, [](int, int) { return 1.0F; });
  PictureOptions options;
  options.way = {{-1.5, -1.0}, {1.0, -1.0}, {1.0, -30.0}};
  const cv::Mat picture = draw_map(stack, options);
  const Patch way = patch_of(picture, kWay);
  EXPECT_GT(way.count, (2.5 + 1.0) * 240 * 2) << "240 pixels a metre, 3 wide";
  for (int y = 28 + 88 + 960 + 2; y < picture.rows - 70; ++y)
    for (int x = 0; x < picture.cols; ++x)
      ASSERT_NE(picture.at<cv::Vec3b>(y, x), kWay) << "below the map";
}

TEST(MapPicture, has_no_panel_for_a_layer_without_a_value)
{
  LayerStack stack = stack_of({"elevation", "sparsity"}, [](int, int) { return 1.0F; });
  const cv::Mat two = draw_map(stack);
  std::fill(stack.layers[1].begin(), stack.layers[1].end(), kNan);
  EXPECT_LT(draw_map(stack).cols, two.cols);
  std::fill(stack.layers[0].begin(), stack.layers[0].end(), kNan);
  EXPECT_EQ(draw_map(stack).cols, two.cols) << "nothing has a value";
}

TEST(MapPicture, says_how_far_values_lie_beyond_the_scale)
{
  const auto with_peak = [](float peak)
  {
    return draw_map(stack_of(
        {"elevation"}, [peak](int ix, int iy) { return ix == 0 && iy == 0 ? peak : 0.01F * ix; }));
  };
  EXPECT_FALSE(same(with_peak(2), with_peak(3)));
}

TEST(MapPicture, points_the_arrow_of_the_robot_along_its_yaw)
{
  const auto unknown = [](int, int) { return kNan; };
  const LayerStack stack = stack_of({"traversability"}, unknown);
  PictureOptions options;
  options.has_robot = true;
  const cv::Mat east = draw_map(stack, options);
  options.robot_yaw_rad = 1.5707963;
  const cv::Mat north = draw_map(stack, options);
  EXPECT_FALSE(same(east, north));
  options.robot_x_m = 100;
  const cv::Mat outside = draw_map(stack, options);
  options.robot_y_m = -100;
  EXPECT_TRUE(same(outside, draw_map(stack, options))) << "a robot outside is not drawn";
}

TEST(MapPicture, stays_of_a_size_for_a_screen_whatever_the_number_of_cells)
{
  for (const int cells : {4, 160, 500, 2000})
  {
    LayerStack s;
    s.cells_x = s.cells_y = cells;
    s.resolution_m = 0.05;
    s.names = {"elevation"};
    s.layers = {std::vector<float>(static_cast<std::size_t>(cells) * cells, 0.5F)};
    const cv::Mat picture = draw_map(s);
    EXPECT_GT(picture.rows, 400) << cells;
    EXPECT_LT(picture.rows, 1300) << cells;
  }
}

TEST(MapPicture, copes_with_layers_that_are_empty_level_infinite_or_far_away)
{
  const float infinite = std::numeric_limits<float>::infinity();
  for (const float v : {kNan, 0.0F, infinite, -infinite, 1e6F})
    EXPECT_NO_THROW(draw_map(stack_of(all_names(), [v](int, int) { return v; }))) << v;
  LayerStack far = stack_of(all_names(), [](int, int) { return 1.0F; });
  far.min_x_m = -4.5e6;
  PictureOptions options;
  options.title = std::string(500, 'x') + "\xc3\xa9";
  EXPECT_NO_THROW(draw_map(far, options));
}

TEST(MapPicture, is_not_drawn_of_layers_that_do_not_fit_or_lie_nowhere)
{
  const auto sound = stack_of({"elevation", "slope"}, [](int, int) { return 1.0F; });
  LayerStack bad = sound;
  bad.layers[1].pop_back();
  expect_error([&] { draw_map(bad); }, {"'slope'"});
  bad = sound;
  bad.layers.pop_back();
  expect_error([&] { draw_map(bad); }, {"no cells or layers"});
  for (const double m : {0.0, std::nan("")})
  {
    bad = sound;
    bad.resolution_m = m;
    expect_error([&] { draw_map(bad); }, {"no place"});
  }
  LayerStack far = sound;
  far.min_x_m = 1e15;  // neighbouring cells are one number there
  EXPECT_NO_THROW(draw_map(far));
}

TEST(MapPicture, writes_a_png_whole_or_not_at_all)
{
  const ScratchDir dir;
  const LayerStack stack = stack_of({"elevation"}, [](int ix, int) { return 0.1F * ix; });
  write_map_picture(dir / "map.png", stack);
  EXPECT_TRUE(same(cv::imread(dir / "map.png"), draw_map(stack)));
  write_bytes(dir / "old.png", "precious");
  expect_error([&] { write_map_picture(dir / "old.png", LayerStack{}); }, {"old.png", "no cells"});
  EXPECT_EQ(read_bytes(dir / "old.png"), "precious");
  expect_error([&] { write_map_picture(dir / "none/map.png", stack); }, {"none/map.png"});
}

TEST(MapPicture, a_png_has_colours_and_greys_of_8_and_16_bits)
{
  const ScratchDir dir;
  for (const int type : {CV_8UC4, CV_8UC3, CV_8UC1, CV_16UC1})
  {
    cv::Mat picture(123, 457, type);
    cv::RNG(7).fill(picture, cv::RNG::UNIFORM, 0, 65536);
    picture.rowRange(40, 80).setTo(cv::Scalar(1, 2, 3, 4));
    write_png(dir / "a.png", picture);
    const cv::Mat read = cv::imread(dir / "a.png", cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), type);
    EXPECT_EQ(cv::norm(read, picture, cv::NORM_INF), 0);
  }
}
