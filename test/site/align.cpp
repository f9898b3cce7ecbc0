// Maps of drives whose poses lie in other frames are brought together, as far as the ground tells.
#include <gtest/gtest.h>
#include <talus/align/align.h>
#include <talus/site/merge.h>

#include <cmath>
#include <memory>
#include <random>

#include "log_files.h"
#include "sites.h"

using namespace talus;
using namespace talus::align;
using namespace talus::site;
using namespace talus::test;

namespace
{
constexpr double kCell_m = 0.05;
using Names = std::vector<std::string>;

/** A place on Earth: its ground, and how high something stands there. */
struct World
{
  double (*ground_m)(double x_m, double y_m);
  double (*object_m)(double x_m, double y_m);
};

double level(double, double) { return 0; }
double hills(double x, double y)
{
  return 0.4 * std::sin(0.9 * x) + 0.3 * std::cos(1.1 * y + 0.4 * x);
}
double ramp(double x, double) { return 0.2 * x; }
double nothing(double, double) { return 0; }
double corridor(double, double y) { return std::abs(std::abs(y) - 2) < 0.06 ? 1.5 : 0; }
bool is_post(double x, double y, double at_x, double at_y)
{
  return std::hypot(x - at_x, y - at_y) < 0.15;
}
double oblique_walls(double x, double y)
{
  const bool is_wall =
      std::abs(0.9 * x + 0.44 * y - 1) < 0.12 || std::abs(0.3 * x - 0.95 * y) < 0.12;
  return is_wall ? 1.2 : 0;
}
double posts(double x, double y)
{
  return is_post(x, y, -2.3, 1.1) || is_post(x, y, 0.4, -1.7) || is_post(x, y, 2.9, 0.6) ||
                 is_post(x, y, 4.1, -1.2) || is_post(x, y, -3.6, -0.9)
             ? 0.8
             : 0;
}
double posts_and_the_same_half_a_turn_on(double x, double y)
{
  return std::max(posts(x, y), posts(-x, -y));
}
/** Ten, at other places for each kind. */
template <int kKind>
double people(double x, double y)
{
  for (int i = 0; i < 10; ++i)
    if (is_post(x, y, std::fmod(i * kKind * 1.7, 10) - 5, std::fmod(i * kKind * 0.9, 5) - 2.5))
      return 1.7;
  return 0;
}
double posts_and_a_car(double x, double y)
{
  return std::abs(x - 1.5) < 0.8 && std::abs(y - 1.6) < 0.5 ? 1.4 : posts(x, y);
}

class Align : public testing::Test
{
 protected:
  std::unique_ptr<Site> site() const
  {
    return std::make_unique<Site>(kCell_m, std::size_t{64} << 20, dir_ / "tiles");
  }
  /** What a drive whose frame lies so in the world has measured of it: 12 x 6 m. */
  void write(
      const std::string& name, const World& world, unsigned seed, const MapShift& frame = {}) const
  {
    const auto s = site();
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.003);
    double middle_x_m = 0, middle_y_m = 0;
    frame.undo(middle_x_m, middle_y_m);
    const auto cell = [](double m) { return static_cast<int>(std::floor(m / kCell_m)); };
    const int turned = std::abs(std::sin(frame.yaw_rad)) > 0.7 ? 60 : 0;
    for (int i = cell(middle_x_m) - 120 + turned; i < cell(middle_x_m) + 120 - turned; ++i)
      for (int k = cell(middle_y_m) - 60 - turned; k < cell(middle_y_m) + 60 + turned; ++k)
      {
        double x_m = (i + 0.5) * kCell_m, y_m = (k + 0.5) * kCell_m;
        frame.apply(x_m, y_m);
        if (std::abs(x_m) > 5.5 || std::abs(y_m) > 2.7) continue;
        const double ground_m = world.ground_m(x_m, y_m) - frame.z_m + noise(random);
        SiteCell c = measured(static_cast<float>(ground_m), 1000 + seed, 9e-6F);
        const double object_m = world.object_m(x_m, y_m);
        if (object_m > 0) c = with_obstacle(c, static_cast<float>(object_m));
        cell_at(*s, i, k) = c;
      }
    s->ways = {{{0, 0, 0, 0}, {1, 0, 0, 0}}};
    write_site(dir_ / name, *s, 0);
  }
  Alignment aligned() const { return align_sites({dir_ / "a.tif", dir_ / "b.tif"}).back(); }
  ScratchDir dir_;
};

void expect_near(const MapShift& is, const MapShift& expected, double within_m = 0.03)
{
  EXPECT_NEAR(is.x_m, expected.x_m, within_m);
  EXPECT_NEAR(is.y_m, expected.y_m, within_m);
  EXPECT_NEAR(is.z_m, expected.z_m, 0.001);
  EXPECT_NEAR(is.yaw_rad, expected.yaw_rad, 0.0065) << "half a cell at the outermost post";
}
}  // namespace

TEST_F(Align, maps_of_one_frame_stay_as_they_are)
{
  for (const World& world : {World{level, posts}, World{hills, nothing}})
  {
    write("a.tif", world, 1);
    write("b.tif", world, 2);
    EXPECT_FALSE(aligned().shift.moves());
  }
}

TEST_F(Align, what_stands_shows_where_a_map_lies_and_a_car_that_came_changes_nothing)
{
  write("a.tif", {level, posts}, 1);
  for (const MapShift& frame :
       {MapShift{0, 0, 0.6, 0}, MapShift{0.15, 0, 0, 0}, MapShift{-0.9, 0.6, -0.15, 0.06},
        MapShift{0.3, -0.2, 0.1, 0}})
  {
    const bool has_car = frame.x_m == 0.3;
    write("b.tif", {level, has_car ? posts_and_a_car : posts}, 2, frame);
    const Alignment a = aligned();
    EXPECT_EQ(a.unobservable, Names());
    expect_near(a.shift, frame, frame.y_m == 0 ? 1e-9 : 0.03);
    EXPECT_TRUE(!has_car || a.shift.yaw_rad == 0);
  }
}

TEST_F(Align, drives_that_began_elsewhere_or_half_a_turn_apart_come_together)
{
  write("a.tif", {level, posts}, 1);
  for (const MapShift& frame :
       {MapShift{0.2, -0.1, 0.05, M_PI}, MapShift{0.2, -0.1, 0.05, -M_PI / 2},
        MapShift{4.2, -2.1, 0.05, M_PI}, MapShift{-4.3, 2.2, 0, 0}})
  {
    write("b.tif", {level, posts}, 2, frame);
    const Alignment a = aligned();
    EXPECT_NEAR(std::cos(a.shift.yaw_rad - frame.yaw_rad), 1, 1e-9);
    expect_near(
        {a.shift.x_m, a.shift.y_m, a.shift.z_m, 0}, {frame.x_m, frame.y_m, frame.z_m, 0}, 1e-9);
  }
}

TEST_F(Align, of_two_places_that_fit_as_well_none_is_told)
{
  write("a.tif", {level, posts_and_the_same_half_a_turn_on}, 1);
  write("b.tif", {level, posts_and_the_same_half_a_turn_on}, 2, {0.2, -0.1, 0.05, M_PI / 2});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, (Names{"x", "y", "yaw"}));
  EXPECT_FALSE(a.shift.moves_cells());
  EXPECT_NEAR(a.shift.z_m, 0.05, 0.001);
}

TEST_F(Align, what_is_no_whole_cell_is_told_to_a_tenth_of_one)
{
  write("a.tif", {level, oblique_walls}, 1);
  for (const MapShift& frame : {MapShift{0.123, -0.081, 0, 0}, MapShift{0.02, 0.017, 0, 0}})
  {
    write("b.tif", {level, oblique_walls}, 2, frame);
    const Alignment a = aligned();
    EXPECT_NEAR(a.shift.x_m + a.rest_x_m, frame.x_m, kCell_m / 10);
    EXPECT_NEAR(a.shift.y_m + a.rest_y_m, frame.y_m, kCell_m / 10);
    EXPECT_NEAR(a.shift.x_m / kCell_m, std::round(a.shift.x_m / kCell_m), 1e-9);
  }
}

/** Ten stood in the way of the first drive, and ten elsewhere in that of the second. */
TEST_F(Align, people_who_have_moved_between_the_drives_move_nothing)
{
  const auto before = [](double x, double y) { return people<7>(x, y); };
  const auto after = [](double x, double y) { return people<10>(x, y); };
  write("a.tif", {level, before}, 1);
  write("b.tif", {level, after}, 2);
  EXPECT_FALSE(aligned().shift.moves_cells());
}

TEST_F(Align, a_car_alone_tells_nothing_where_the_other_map_has_none)
{
  const auto car = [](double x, double y)
  { return std::abs(x - 1.5) < 0.8 && std::abs(y - 1.6) < 0.5 ? 1.4 : 0.0; };
  write("a.tif", {level, nothing}, 1);
  write("b.tif", {level, car}, 2, {0, 0, 0.05, 0});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, (Names{"x", "y", "yaw"}));
  EXPECT_FALSE(a.shift.moves_cells());
}

TEST_F(Align, hills_tell_where_a_map_lies_without_anything_that_stands)
{
  write("a.tif", {hills, nothing}, 1);
  write("b.tif", {hills, nothing}, 2, {0.4, -0.25, 0.2, -0.04});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, Names());
  expect_near(a.shift, {0.4, -0.25, 0.2, -0.04});
}

TEST_F(Align, level_and_bare_ground_tells_the_height_alone)
{
  write("a.tif", {level, nothing}, 1);
  write("b.tif", {level, nothing}, 2, {0.4, -0.25, 0.6, 0});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, (Names{"x", "y", "yaw"}));
  EXPECT_FALSE(a.shift.moves_cells());
  EXPECT_NEAR(a.shift.z_m, 0.6, 0.0005);
}

TEST_F(Align, a_ramp_does_not_tell_height_and_way_up_apart)
{
  write("a.tif", {ramp, nothing}, 1);
  write("b.tif", {ramp, nothing}, 2, {0.4, 0, 0.3, 0});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, (Names{"x", "y"})) << "it tells the turn";
  EXPECT_FALSE(a.shift.moves_cells());
  EXPECT_NEAR(a.shift.z_m, 0.3 - 0.2 * 0.4, 0.002);
}

TEST_F(Align, a_corridor_tells_all_but_the_way_along)
{
  write("a.tif", {level, corridor}, 1);
  write("b.tif", {level, corridor}, 2, {0.4, 0.2, 0.1, 0});
  const Alignment a = aligned();
  EXPECT_EQ(a.unobservable, Names{"x"});
  EXPECT_NEAR(a.shift.x_m, 0, 1e-9);
  EXPECT_NEAR(a.shift.y_m, 0.2, 0.03);
  EXPECT_NEAR(a.shift.z_m, 0.1, 0.001);
}

TEST_F(Align, maps_without_common_ground_stay)
{
  write("a.tif", {level, posts}, 1);
  const auto far = site();
  for (int i = 0; i < 30; ++i) cell_at(*far, 5000 + i, 0) = measured(7);
  write_site(dir_ / "b.tif", *far, 0);
  const Alignment a = aligned();
  EXPECT_FALSE(a.overlaps);
  EXPECT_FALSE(a.shift.moves());
}

TEST_F(Align, each_map_comes_onto_those_that_lie_already)
{
  write("a.tif", {level, posts}, 1);
  write("b.tif", {level, posts}, 2, {0.5, 0, 0.2, 0});
  write("c.tif", {level, posts}, 3, {0, -0.5, -0.4, 0});
  const auto all = align_sites({dir_ / "a.tif", dir_ / "b.tif", dir_ / "c.tif"});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_FALSE(all[0].shift.moves());
  expect_near(all[1].shift, {0.5, 0, 0.2, 0});
  expect_near(all[2].shift, {0, -0.5, -0.4, 0});
}

TEST_F(Align, a_map_that_is_raised_keeps_its_cells_and_their_evidence)
{
  write("a.tif", {hills, posts}, 1);
  const auto is = site(), raised = site();
  read_site(dir_ / "a.tif", *is, 0);
  read_site(dir_ / "a.tif", *raised, 0, {0, 0, 0.25, 0});
  for (int i = -110; i < 110; i += 7)
    for (int k = -54; k < 54; k += 5)
    {
      SiteCell c = cell_at(*is, i, k);
      c.cell.ground_m += 0.25F;
      c.cell.elevation_m += 0.25F;
      EXPECT_EQ(bytes_of(c), bytes_of(cell_at(*raised, i, k)));
    }
  EXPECT_EQ(raised->ways[0][0].z_m, 0.25F);
}

TEST_F(Align, a_map_that_is_moved_by_whole_cells_has_the_same_cells_elsewhere)
{
  write("a.tif", {hills, posts}, 1);
  const auto is = site(), moved = site(), back = site();
  read_site(dir_ / "a.tif", *is, 0);
  read_site(dir_ / "a.tif", *moved, 0, {0.15, -7.5, 0, 0});
  int known = 0;
  for (int i = -130; i < 130; ++i)
    for (int k = -70; k < 70; ++k)
    {
      ASSERT_EQ(bytes_of(cell_at(*is, i, k)), bytes_of(cell_at(*moved, i + 3, k - 150)));
      known += cell_at(*moved, i + 3, k - 150).known();
    }
  EXPECT_GT(known, 20'000);
  EXPECT_NEAR(moved->ways[0][1].x_m, 1.15, 1e-6);
}

TEST_F(Align, a_map_that_is_turned_has_no_holes)
{
  write("a.tif", {level, posts}, 1);
  const auto turned = site();
  read_site(dir_ / "a.tif", *turned, 0, {0, 0, 0, 0.5});
  for (int i = -40; i < 40; ++i)
    for (int k = -20; k < 20; ++k) ASSERT_TRUE(cell_at(*turned, i, k).known()) << i << " " << k;
  // The post at (0.4, -1.7).
  const double x_m = 0.4 * std::cos(0.5) + 1.7 * std::sin(0.5);
  const double y_m = 0.4 * std::sin(0.5) - 1.7 * std::cos(0.5);
  const auto cell = [](double at_m) { return static_cast<int>(std::floor(at_m / kCell_m)); };
  EXPECT_NEAR(cell_at(*turned, cell(x_m), cell(y_m)).cell.elevation_m, 0.8, 0.02);
  EXPECT_TRUE(std::isnan(cell_at(*turned, cell(0.4), cell(-1.7)).cell.elevation_m));
}

TEST_F(Align, maps_that_are_merged_tell_how_they_fit)
{
  const auto fit = [&](const std::vector<MapShift>& shifts)
  {
    const auto s = site();
    MergeOptions options;
    options.shifts = shifts;
    const auto fits = merge_sites({dir_ / "a.tif", dir_ / "b.tif"}, *s, 0, options);
    EXPECT_EQ(fits.size(), 1u);
    return fits.front();
  };
  write("a.tif", {level, posts}, 1);
  write("b.tif", {level, posts}, 2, {0.3, 0, -0.15, 0});
  const MapFit bad = fit({}), good = fit({{}, {0.3, 0, -0.15, 0}});
  EXPECT_NEAR(bad.offset_z_m, 0.15, 0.0005);
  EXPECT_GT(bad.ground_disagrees, 0.99);
  EXPECT_GT(bad.standing_disagrees, 0.15);
  EXPECT_FALSE(bad.fits());
  EXPECT_NEAR(good.offset_z_m, 0, 0.0005);
  EXPECT_LT(good.ground_disagrees, 0.01);
  EXPECT_LT(good.standing_disagrees, 0.02);
  EXPECT_NEAR(good.overlap_m2, 11 * 5.4, 1);
  EXPECT_TRUE(good.fits());
}
