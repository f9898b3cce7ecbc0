// What a person sees of a site and of what changed in it.
#include <gtest/gtest.h>
#include <talus/io/palette.h>
#include <talus/site/changes.h>
#include <talus/site/site_files.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include "log_files.h"
#include "sites.h"

using namespace talus;
using namespace talus::site;
using namespace talus::test;

namespace
{
using Colour = cv::Vec3b;
Colour bgr(const io::NamedColour& c) { return {c.rgb[2], c.rgb[1], c.rgb[0]}; }
const Colour kObstacle = bgr(io::palette::kStands), kDug = bgr(io::palette::kChanges[2]),
             kGone = bgr(io::palette::kChanges[3]), kAppeared = bgr(io::palette::kChanges[4]);

class SitePicture : public testing::Test
{
 protected:
  std::unique_ptr<Site> ground(int width_cells, int height_cells, float height_m = 0) const
  {
    auto s = std::make_unique<Site>(0.05, std::size_t{64} << 20, dir_ / "tiles");
    for (int x = 0; x < width_cells; ++x)
      for (int y = 0; y < height_cells; ++y) cell_at(*s, x, y) = measured(height_m, 1'760'000'000);
    return s;
  }
  cv::Mat3b picture(Site& s, int floor = 0) const
  {
    write_site_picture(dir_ / "site.png", s, floor);
    return cv::imread(dir_ / "site.png");
  }
  static int count(const cv::Mat3b& image, const Colour& colour)
  {
    return static_cast<int>(std::count(image.begin(), image.end(), colour));
  }
  ScratchDir dir_;
};
constexpr int kSwatch_px = 18 * 18;  //!< in the legend of a small page
const Colour kNotSeen = bgr(io::palette::kNotSeen), kPaper(255, 255, 255);

/** A strip of ground along a line from the origin. */
void drive(Site& s, double length_m, double width_m, double angle_rad)
{
  const double c = std::cos(angle_rad), n = std::sin(angle_rad), step_m = 0.03;
  for (double along = 0; along < length_m; along += step_m)
    for (double across = -width_m / 2; across < width_m / 2; across += step_m)
      cell_at(
          s, static_cast<std::int64_t>(std::floor((c * along - n * across) / 0.05)),
          static_cast<std::int64_t>(std::floor((n * along + c * across) / 0.05))) = measured(0);
}
}  // namespace

TEST_F(SitePicture, is_about_as_large_as_a_page_for_any_site)
{
  for (const int cells : {20, 300, 1500, 5000})
  {
    const cv::Mat3b image = picture(*ground(cells, cells / 10 + 1));
    EXPECT_GE(image.cols, 700) << cells;
    EXPECT_LE(image.cols, 3300) << cells;
    EXPECT_LE(image.rows, 1000) << cells;
  }
  const cv::Mat3b narrow = picture(*ground(200, 3000));
  EXPECT_LE(narrow.rows, 1900);
  EXPECT_GE(narrow.cols, 700);
}

TEST_F(SitePicture, has_a_pixel_for_every_cell_up_to_a_large_page)
{
  const auto s = ground(2800, 100);
  const int legend = count(picture(*s), kObstacle);
  for (int x = 0; x < 10; ++x) cell_at(*s, 2000 + x, 50) = with_obstacle(measured(0), 0.5F);
  EXPECT_EQ(count(picture(*s), kObstacle), legend + 10);
}

TEST_F(SitePicture, turns_the_page_to_a_drive_that_would_leave_most_of_it_empty)
{
  for (const double angle_rad : {0.0, 0.7, 1.5707963, 2.3, -0.6})
  {
    auto s = ground(0, 0);
    drive(*s, 40, 4, angle_rad);
    const cv::Mat3b image = picture(*s);
    const int empty = count(image, kNotSeen), paper = count(image, kPaper);
    const int map = static_cast<int>(image.total()) - empty - paper;
    EXPECT_LT(empty, 0.45 * map) << angle_rad;
  }
}

TEST_F(SitePicture, keeps_north_up_where_turning_wins_little)
{
  const auto yard = ground(0, 0);
  drive(*yard, 20, 20, 0.5);
  EXPECT_GT(count(picture(*yard), kNotSeen), 300'000) << "the corners stay empty";
}

TEST_F(SitePicture, shows_an_obstacle_of_one_cell_also_where_a_pixel_stands_for_many)
{
  const auto s = ground(8000, 300);
  const int legend = count(picture(*s), kObstacle);
  cell_at(*s, 4001, 150) = with_obstacle(measured(0), 0.5F);
  EXPECT_EQ(count(picture(*s), kObstacle), legend + 1);
  cell_at(*s, 4001, 150).cell.traversability = 1;  // it hangs high
  EXPECT_EQ(count(picture(*s), kObstacle), legend);
}

TEST_F(SitePicture, shows_blocked_ground_in_another_colour_than_free_ground)
{
  const auto s = ground(100, 100);
  for (int x = 50; x < 100; ++x)
    for (int y = 0; y < 100; ++y) cell_at(*s, x, y).cell.traversability = 0;
  const cv::Mat3b image = picture(*s);
  const int free = count(image, bgr(io::palette::kFree));
  EXPECT_GT(free, 100'000);
  EXPECT_NEAR(count(image, bgr(io::palette::kBlocked)), free, free / 5);
}

TEST_F(SitePicture, light_comes_from_the_north_west)
{
  const auto s = ground(200, 200);
  for (int x = 0; x < 200; ++x)  // a ridge from south to north
    for (int y = 0; y < 200; ++y)
      cell_at(*s, x, y).cell.ground_m = 0.03F * static_cast<float>(x < 100 ? x : 200 - x);
  const cv::Mat3b image = picture(*s);
  const int row = image.rows / 2;
  const int left = 96, plot = image.cols - 96 - 212 - 2 * 28;
  EXPECT_GT(image(row, left + plot / 3)[1], image(row, left + plot * 2 / 3)[1] + 40);
}

TEST_F(SitePicture, is_the_same_for_the_same_site_and_another_with_a_way)
{
  const auto s = ground(300, 300);
  picture(*s);
  const std::string once = read_bytes(dir_ / "site.png");
  picture(*s);
  EXPECT_EQ(read_bytes(dir_ / "site.png"), once);
  s->ways = {{{2, 2, 0, 0}, {12, 12, 0, 0}}};
  picture(*s);
  EXPECT_NE(read_bytes(dir_ / "site.png"), once);
}

TEST_F(SitePicture, is_not_made_of_a_floor_of_which_nothing_is_known)
{
  const auto s = ground(30, 30);
  expect_error([&] { picture(*s, 1); }, {"site.png", "floor 1"});
}

TEST_F(SitePicture, marks_what_changed)
{
  const auto before = ground(300, 200), after = ground(300, 200);
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 10; ++y)
    {
      cell_at(*before, 100 + x, 50 + y) = with_obstacle(measured(0, 1'760'000'000), 0.6F);
      cell_at(*after, 200 + x, 50 + y) = with_obstacle(measured(0, 1'760'000'000), 0.6F);
      cell_at(*after, 150 + x, 120 + y).cell.ground_m = -0.4F;
    }
  const ChangeSums sums =
      write_changes(dir_ / "changes.tif", dir_ / "changes.png", *before, *after, 0, 0.2);
  EXPECT_NEAR(sums.area_m2(Change::Gone), 0.25, 1e-9);
  EXPECT_NEAR(sums.area_m2(Change::Appeared), 0.25, 1e-9);
  EXPECT_NEAR(sums.area_m2(Change::Dug), 0.25, 1e-9);
  EXPECT_EQ(sums.area_m2(Change::Built), 0);
  EXPECT_NEAR(sums.volume_m3[static_cast<std::size_t>(Change::Dug)], 0.1, 1e-6);
  const cv::Mat3b image = cv::imread(dir_ / "changes.png");
  for (const Colour& c : {kGone, kAppeared, kDug})
    EXPECT_GE(count(image, c), kSwatch_px + 100) << c;
}

TEST(Changes, are_told_only_of_what_both_have_seen)
{
  const SiteCell flat = measured(1), box = with_obstacle(measured(1), 0.5F);
  SiteCell guessed = measured(2);
  guessed.cell.state = 3;
  EXPECT_EQ(change_of(flat, box, 0.2).kind, Change::Appeared);
  EXPECT_EQ(change_of(box, flat, 0.2).kind, Change::Gone);
  EXPECT_EQ(change_of(flat, measured(1.3F), 0.2).kind, Change::Built);
  EXPECT_EQ(change_of(flat, measured(0.7F), 0.2).kind, Change::Dug);
  EXPECT_EQ(change_of(flat, measured(1.1F), 0.2).kind, Change::None);
  EXPECT_EQ(change_of(box, with_obstacle(measured(1), 0.9F), 0.2).kind, Change::Appeared);
  EXPECT_TRUE(std::isnan(change_of(flat, guessed, 0.2).change_m));
  EXPECT_TRUE(std::isnan(change_of(SiteCell{}, flat, 0.2).change_m));
}

TEST(Changes, an_edge_that_moved_by_a_cell_is_none_also_between_tiles)
{
  const ScratchDir dir;
  const auto site_with_box = [&](int x0)
  {
    auto s = std::make_unique<Site>(0.05, std::size_t{64} << 20, dir / "tiles");
    for (int x = 0; x < 300; ++x)
      for (int y = 0; y < 50; ++y)
      {
        cell_at(*s, x, y) = measured(0);
        if (x >= x0 && x < x0 + 20 && y >= 20 && y < 30)
          cell_at(*s, x, y) = with_obstacle(measured(0), 1);
      }
    return s;
  };
  // The right edge of the box lies on the border of two tiles.
  const auto before = site_with_box(kTileCells - 20), moved = site_with_box(kTileCells - 19),
             farther = site_with_box(kTileCells - 17);
  const auto changed = [&](Site& to)
  {
    const auto sums = write_changes(dir / "changes.tif", dir / "changes.png", *before, to, 0, 0.2);
    return sums.cells[3] + sums.cells[4];
  };
  EXPECT_EQ(changed(*moved), 0u);
  EXPECT_EQ(changed(*farther), 2u * 2 * 10) << "but for the row beside where it was and is";
}
