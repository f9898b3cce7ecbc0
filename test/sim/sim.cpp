// The simulator against closed forms: where rays hit, and what is really there.
#include <gtest/gtest.h>

#include <algorithm>
#include <talus/sim/random.h>

#include "message_of.h"
#include "sim_world.h"

using namespace talus::sim;

namespace
{
/** The first sign change of the height above the ground, by small equal steps. */
double brute_force_m(const Ground& ground, const Ray& ray, double max_m)
{
  for (double t = 0; t < max_m; t += 0.0005)
    if (const Vec3 p = ray.at(t); p.z <= ground.height_m(p.x, p.y)) return t;
  return -1;
}
}  // namespace

TEST(Rays, hit_a_tilted_plane_where_the_closed_form_says)
{
  const World w = world_of("- plane: {z_m: 0.1, slope_x_deg: 10, slope_y_deg: -5}\n");
  const Vec3 o{1, 2, 3}, d = normalized({0.5, -0.3, -0.4});
  const double sx = std::tan(radians(10)), sy = std::tan(radians(-5));
  const double expected = (0.1 + sx * o.x + sy * o.y - o.z) / (d.z - sx * d.x - sy * d.y);
  EXPECT_NEAR(cast_m(w, o, d), expected, kExact_m);
}

TEST(Rays, hit_the_vertical_faces_of_steps_and_ditches_exactly)
{
  const World step = world_of("- step: {at_m: [2, 0], height_m: 0.5}\n");
  EXPECT_NEAR(cast_m(step, {0, 0, 0.3}, {1, 0, 0}), 2.0, kExact_m);
  EXPECT_EQ(cast_m(step, {0, 0, 0.6}, {1, 0, 0}), -1);
  const World ditch = world_of("- ditch: {at_m: [3, 0], yaw_deg: 90, width_m: 1, depth_m: 0.4}\n");
  // From 1 m above x = 0 over the near edge at 2.5 to the far face at 3.5, 0.3 m below ground.
  EXPECT_NEAR(cast_m(ditch, {0, 0, 1}, {3.5, 0, -1.3}), std::hypot(3.5, 1.3), kExact_m);
  EXPECT_NEAR(cast_m(ditch, {2, 0, 1}, {1, 0, -1.4}), std::hypot(1, 1.4), kExact_m);
}

TEST(Rays, hit_a_ramp_between_its_sides_only)
{
  const World w = world_of("- ramp: {at_m: [2, 0], length_m: 2, height_m: 1, width_m: 1}\n");
  // Level at 0.5 m the ramp is met half way up.
  EXPECT_NEAR(cast_m(w, {0, 0.4, 0.5}, {1, 0, 0}), 3.0, kExact_m);
  EXPECT_EQ(cast_m(w, {0, 0.6, 0.5}, {1, 0, 0}), -1);
  EXPECT_NEAR(cast_m(w, {3.5, 3, 0.2}, {0, -1, 0}), 2.5, kExact_m) << "its side";
}

TEST(Rays, hit_curved_ground_as_a_brute_force_search_does)
{
  const World w = world_of(
      "- sine: {amplitude_m: 0.2, wavelength_m: 2, yaw_deg: 30}\n"
      "- roughness: {amplitude_m: 0.08, wavelength_m: 0.5, octaves: 2}\n"
      "- pit: {at_m: [3, 0], radius_m: 1, depth_m: 0.4}\n"
      "- step: {at_m: [5, 0], height_m: 0.3}\n");
  Random random(5);
  for (int i = 0; i < 300; ++i)
  {
    const Ray ray{
        {0, 0, 0.9}, normalized({1, random.uniform(-0.5, 0.5), random.uniform(-0.6, -0.02)})};
    const double expected = brute_force_m(w.ground, ray, 12);
    const auto hit = w.ground.cast(ray, 12);
    ASSERT_EQ(hit.has_value(), expected >= 0) << i;
    // Crests thinner than the 2 mm that a step may skip are the only difference allowed.
    if (hit)
    {
      EXPECT_NEAR(*hit, expected, 0.002) << i;
    }
  }
}

TEST(Rays, hit_boxes_cylinders_and_spheres_where_the_closed_form_says)
{
  const World w = world_of(
      kFlat,
      "objects:\n"
      "- box: {at_m: [3, 0], size_m: [1, 1, 1], yaw_deg: 45}\n"
      "- post: {at_m: [0, 4], height_m: 1, radius_m: 0.2}\n"
      "- sphere: {at_m: [-5, 0], radius_m: 0.5}\n"
      "- branch: {from_m: [0, -3, 1], to_m: [2, -3, 1], radius_m: 0.1}\n");
  EXPECT_NEAR(cast_m(w, {0, 0, 0.5}, {1, 0, 0}), 3 - std::sqrt(0.5), kExact_m) << "its edge";
  EXPECT_NEAR(cast_m(w, {0.1, 0, 0.5}, {0, 1, 0}), 4 - std::sqrt(0.03), kExact_m);
  EXPECT_NEAR(cast_m(w, {0, 4, 3}, {0, 0, -1}), 2, kExact_m) << "its cap";
  EXPECT_NEAR(cast_m(w, {-5, 0.3, 3}, {0, 0, -1}), 3 - (0.5 + 0.4), kExact_m);
  EXPECT_NEAR(cast_m(w, {1, -3, 0.1}, {0, 0, 1}), 0.8, kExact_m) << "from below";
  EXPECT_NEAR(cast_m(w, {2.1, -3, 2}, {0, 0, -1}), 2, kExact_m) << "past its end, the ground";
}

TEST(Rays, find_the_same_object_in_the_tree_as_among_all)
{
  Random random(3);
  std::vector<Shape> shapes;
  for (int i = 0; i < 60; ++i)
  {
    const Vec3 at{random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0, 2)};
    const double s = random.uniform(0.1, 0.6);
    if (i % 2)
      shapes.push_back(make_box(at, {s, 0.3, 0.3}, random.uniform(0, 3)));
    else
      shapes.push_back(make_cylinder(at, at + Vec3{s, s, 0.5}, 0.1));
  }
  const ShapeTree tree(shapes);
  for (int i = 0; i < 500; ++i)
  {
    const Ray ray{{0, 0, 1}, normalized({random.normal(), random.normal(), 0.3 * random.normal()})};
    double nearest = 20;
    for (const Shape& s : shapes) nearest = std::min(nearest, first_hit(s, ray, 0).value_or(20));
    const auto hit = tree.cast(ray, 20, 0, 0);
    EXPECT_EQ(hit ? hit->range_m : 20, nearest);
  }
}

TEST(Rays, go_into_foliage_by_its_mean_free_path)
{
  const World w = world_of(
      kFlat,
      "objects: [foliage: {at_m: [12, 0], size_m: [20, 2, 2], form: box, mean_free_path_m: "
      "0.2}]\n");
  const Scene scene(w, 0);
  double sum = 0;
  constexpr int kRays = 20000;
  for (int i = 0; i < kRays; ++i)
    sum += scene.cast({{0, 0, 1}, {1, 0, 0}}, 100, mix(9, i))->range_m - 2;
  EXPECT_NEAR(sum / kRays, 0.2, 4 * 0.2 / std::sqrt(kRays));  // four standard errors
}

TEST(Truth, of_a_box_on_cell_borders_is_blocked_in_just_its_cells)
{
  const World w = world_of(
      "- plane: {z_m: 0.2}\n", "objects: [box: {at_m: [1, 1], size_m: [0.2, 0.2, 0.5]}]\n");
  const Truth t = truth(w, {0.8, 0.8, 8, 8, 0.05}, 0);
  for (int iy = 0; iy < 8; ++iy)
    for (int ix = 0; ix < 8; ++ix)
    {
      const bool inside = ix >= 2 && ix < 6 && iy >= 2 && iy < 6;
      const int i = iy * 8 + ix;
      EXPECT_EQ(t.label[i], inside ? 0.0f : 1.0f) << ix << " " << iy;
      EXPECT_FLOAT_EQ(t.ground[i], 0.2f);
      EXPECT_EQ(std::isnan(t.obstacle_top[i]), !inside);
      if (inside)
      {
        EXPECT_FLOAT_EQ(t.obstacle_top[i], 0.7f);
      }
      EXPECT_TRUE(std::isnan(t.underside[i]));
    }
}

TEST(Truth, says_how_much_of_a_blocked_cell_is_covered)
{
  const auto covered = [](const World& w) { return truth(w, {1, 0, 1, 1, 0.05}, 0).covered[0]; };
  const std::string box = "objects: [box: {at_m: [0.52, 0], size_m: ";
  EXPECT_FLOAT_EQ(covered(world_of(kFlat, box + "[1.02, 2, 0.5]}]\n")), 0.6f);
  EXPECT_FLOAT_EQ(covered(world_of(kFlat, box + "[1.2, 2, 0.5]}]\n")), 1.0f);
  EXPECT_FLOAT_EQ(covered(world_of(kFlat, box + "[0.8, 2, 0.5]}]\n")), 0.0f);
  EXPECT_FLOAT_EQ(covered(world_of("- plane: {slope_x_deg: 40}\n")), 1.0f);
}

TEST(Truth, says_how_much_of_a_cell_something_solid_stands_on)
{
  const auto solid = [](const World& w) { return truth(w, {1, 0, 1, 1, 0.05}, 0).solid[0]; };
  const std::string at = "{at_m: [1, 0], size_m: [1, 1, 0.3]";
  EXPECT_FLOAT_EQ(solid(world_of(kFlat, "objects: [box: " + at + "}]\n")), 1.0f);
  EXPECT_FLOAT_EQ(solid(world_of(kFlat, "objects: [box: " + at + ", lift_m: 0.1}]\n")), 0.0f);
  EXPECT_FLOAT_EQ(solid(world_of(kFlat, "objects: [foliage: " + at + ", form: box}]\n")), 0.0f);
  EXPECT_FLOAT_EQ(
      solid(world_of(kFlat, "objects: [box: {at_m: [0.52, 0], size_m: [1.02, 2, 0.5]}]\n")), 0.6f);
  EXPECT_FLOAT_EQ(solid(world_of(kFlat)), 0.0f);
}

TEST(Truth, of_a_table_is_free_below_its_top_and_blocked_at_its_legs)
{
  const World w = world_of(
      kFlat,
      "objects: [table: {at_m: [2, 0], size_m: [1, 1, 0.74], thickness_m: 0.04, leg_m: 0.05}]\n");
  const Cell middle = cell_at(w, 2, 0), leg = cell_at(w, 1.5, -0.5), beside = cell_at(w, 2.5, 0);
  EXPECT_EQ(middle.label, 1);
  EXPECT_NEAR(middle.underside, 0.70, 1e-6);
  EXPECT_TRUE(std::isnan(middle.top));
  EXPECT_EQ(leg.label, 0);
  EXPECT_NEAR(leg.top, 0.74, 1e-6);
  EXPECT_EQ(beside.label, 1);
  EXPECT_TRUE(std::isnan(beside.underside));
}

TEST(Truth, of_what_hangs_depends_on_the_clearance_above_what_stands)
{
  const World w = world_of(
      kFlat,
      "objects:\n"
      "- beam: {from_m: [1, 0], to_m: [2, 0], underside_m: 0.35, width_m: 1, thickness_m: 0.1}\n"
      "- beam: {from_m: [3, 0], to_m: [4, 0], underside_m: 0.65, width_m: 1, thickness_m: 0.1}\n"
      "- box: {at_m: [3.8, 0], size_m: [0.2, 0.2, 0.065]}\n"
      "- box: {at_m: [6, 0], size_m: [0.2, 0.2, 0.065]}\n");
  const Cell low = cell_at(w, 1.5, 0), high = cell_at(w, 3.2, 0);
  EXPECT_EQ(low.label, 0);
  EXPECT_NEAR(low.top, 0.45, 1e-6);
  EXPECT_NEAR(low.underside, 0.35, 1e-6);
  EXPECT_EQ(high.label, 1);
  EXPECT_EQ(cell_at(w, 3.8, 0).label, 0) << "0.585 m of air above the low box";
  const Cell low_box = cell_at(w, 6, 0);
  EXPECT_EQ(low_box.label, 1);
  EXPECT_NEAR(low_box.top, 0.065, 1e-6);
}

TEST(Truth, of_slopes_and_steps_follows_their_thresholds)
{
  EXPECT_EQ(cell_at(world_of("- plane: {slope_x_deg: 30}\n"), 0, 0).label, 1);
  EXPECT_EQ(cell_at(world_of("- plane: {slope_x_deg: 40}\n"), 0, 0).label, 0);
  EXPECT_EQ(cell_at(world_of("- plane: {slope_x_deg: 28, slope_y_deg: 28}\n"), 0, 0).label, 0);
  const World low = world_of("- step: {at_m: [1, 0], height_m: 0.15}\n");
  const World high = world_of("- step: {at_m: [1, 0], height_m: 0.25}\n");
  for (const double x : {0.90, 0.95, 1.0, 1.05})
  {
    EXPECT_EQ(cell_at(low, x, 0).label, 1) << x;
    EXPECT_EQ(cell_at(high, x, 0).label, x > 0.92 && x < 1.03 ? 0 : 1) << x;
  }
}

TEST(Truth, of_a_low_face_inside_a_cell_is_not_that_of_a_slope)
{
  for (const char* height_m : {"0.04", "0.07", "0.1", "0.13", "0.19"})
    for (const char* yaw_deg : {"0", "10", "45"})
    {
      const World step = world_of(
          "- plane: {slope_x_deg: 5}\n- step: {at_m: [1.022, 0], yaw_deg: " + std::string(yaw_deg) +
          ", height_m: " + height_m + "}\n");
      EXPECT_EQ(cell_at(step, 1.0, 0).label, 1) << height_m << " m at " << yaw_deg << " degrees";
    }
}

TEST(Truth, of_a_steep_stretch_blocks_where_it_rises_by_more_than_a_step)
{
  const auto label = [](const char* length_m, const char* height_m, double x_m)
  {
    const std::string size = std::string("length_m: ") + length_m + ", height_m: " + height_m;
    return cell_at(world_of("- ramp: {at_m: [1, 0], " + size + "}\n"), x_m, 0).label;
  };
  EXPECT_EQ(label("0.05", "0.05", 1.0), 1) << "a low kerb may lean";
  EXPECT_EQ(label("0.18", "0.18", 1.1), 1);
  EXPECT_EQ(label("0.22", "0.22", 1.0), 0) << "all of a higher one blocks";
  EXPECT_EQ(label("0.22", "0.22", 1.1), 0);
  EXPECT_EQ(label("0.22", "0.22", 1.15), 0);
  EXPECT_EQ(label("0.05", "0.22", 1.0), 0);
  EXPECT_EQ(label("1", "-0.8", 1.5), 0);
  EXPECT_EQ(label("1", "0.6", 1.5), 1) << "31 degrees";
  TruthOptions gentle;
  gentle.max_slope_rad = 0.001;
  const World hill = world_of("- plane: {slope_x_deg: 1}\n");
  EXPECT_EQ(truth(hill, {0, 0, 1, 1, 0.05}, 0, gentle).label[0], 0);
  gentle.max_step_m = 0;
  EXPECT_THROW(truth(hill, {0, 0, 1, 1, 0.05}, 0, gentle), std::invalid_argument);
}

TEST(Truth, takes_movers_where_they_are_at_the_time_or_leaves_them_out)
{
  const World w = world_of(
      kFlat, "movers: [person: {path: [[1, 0, 2], [3, 4, 2], [5, 4, 6]], radius_m: 0.2}]\n");
  EXPECT_EQ(cell_at(w, 0, 2, 0.0).label, 0) << "waits at its first stop";
  EXPECT_EQ(cell_at(w, 2, 2, 2.0).label, 0);
  EXPECT_EQ(cell_at(w, 2, 2, 2.0, false).label, 1);
  EXPECT_EQ(cell_at(w, 2, 2, 3.0).label, 1);
  EXPECT_EQ(cell_at(w, 4, 4, 4.0).label, 0);
  EXPECT_EQ(cell_at(w, 4, 6, 99.0).label, 0) << "stays at its last stop";
  EXPECT_NEAR(cell_at(w, 4, 4, 4.0).top, 1.75, 1e-6);
}

TEST(Truth, says_how_large_a_raster_that_does_not_fit_would_be)
{
  const auto large = [] { window_around({{0, 0, 0}, {5000, 5000, 0}}, 0, 0.05); };
  EXPECT_TRUE(has(message_of(large), "100001 x 100001 cells, 240"));
  EXPECT_THROW(window_around({}, 1, 0), std::invalid_argument);
}
