// The simulator's scanners, its robot and its world files.
#include <gtest/gtest.h>
#include <talus/sim/scanner.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "message_of.h"
#include "sim_world.h"

using namespace talus::sim;

TEST(Scanner, has_range_noise_of_the_given_deviation_and_no_bias)
{
  const World w =
      world_of(kFlat, "sensor: {noise_m: 0.02, dropout: 0.25, roll_pitch_yaw_deg: [0, 90, 0]}\n");
  // Looking down, every beam meets the ground at a range known from its elevation.
  const Drive drive(w);
  double sum = 0, squares = 0;
  int n = 0;
  for (int frame = 0; frame < 4; ++frame)
  {
    const Scan s = drive.scan(frame);
    for (std::size_t i = 0; i < s.size(); ++i)
    {
      const double range = norm({s.x_m[i], s.y_m[i], s.z_m[i]});
      if (range > 20) continue;
      const double error = range - range * 0.68 / s.x_m[i];  // x points down
      sum += error;
      squares += error * error;
      ++n;
    }
  }
  ASSERT_GT(n, 10000);
  EXPECT_NEAR(sum / n, 0, 4 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 4 * 0.02 / std::sqrt(2.0 * n));
}

TEST(Scanner, loses_the_given_share_of_its_returns)
{
  const std::string room = "objects: [wall: {from_m: [3, -9], to_m: [3, 9], height_m: 9}]\n";
  const World all = world_of(kFlat, room),
              some = world_of(kFlat, room + "sensor: {dropout: 0.3}\n");
  const double n = static_cast<double>(Drive(all).scan(0).size());
  const double share = static_cast<double>(Drive(some).scan(0).size()) / n;
  EXPECT_NEAR(share, 0.7, 4 * std::sqrt(0.21 / n));
}

TEST(Scanner, gives_the_same_bits_for_the_same_seed_in_any_order)
{
  const World w = world_of(
      "- roughness: {amplitude_m: 0.05, wavelength_m: 0.5}\n", "", "{path_m: [[0, 0], [1, 0]]}");
  const Drive a(w), b(w);
  b.scan(3);
  const Scan first = a.scan(2), again = b.scan(2);
  ASSERT_EQ(first.size(), again.size());
  const auto same = [](const std::vector<float>& u, const std::vector<float>& v)
  { return u.size() == v.size() && !std::memcmp(u.data(), v.data(), u.size() * sizeof(float)); };
  EXPECT_TRUE(same(first.x_m, again.x_m) && same(first.z_m, again.z_m));
  DriveOptions other;
  other.seed = 2;
  EXPECT_FALSE(same(first.x_m, Drive(w, other).scan(2).x_m));
}

TEST(Scanner, above_a_table_hits_its_top_and_below_it_the_floor_and_the_legs)
{
  const std::string table = "objects: [table: {at_m: [3, 0], size_m: [1, 1, 0.74]}]\n";
  const auto tops_and_floors = [&](const std::string& height)
  {
    const World w = world_of(
        kFlat, table + "sensor: {scanner: OS1-64, noise_m: 0, at_m: [0, 0, " + height + "]}\n");
    const Scan s = Drive(w).scan(0);
    int tops = 0, floors = 0, others = 0;
    for (std::size_t i = 0; i < s.size(); ++i)
    {
      if (s.x_m[i] < 2.51 || s.x_m[i] > 3.49 || std::abs(s.y_m[i]) > 0.49) continue;
      const double z = s.z_m[i] + std::stod(height);
      ++(std::abs(z - 0.74) < 1e-5 ? tops : std::abs(z) < 1e-5 ? floors : others);
    }
    return std::array<int, 3>{tops, floors, others};
  };
  const auto high = tops_and_floors("1.5"), low = tops_and_floors("0.6");
  EXPECT_GT(high[0], 100);
  EXPECT_EQ(low[0], 0);
  EXPECT_GT(low[1], 100) << "floor below the table";
  EXPECT_GT(low[2], 10) << "legs, and the top from below";
}

TEST(Scanner, that_moves_takes_each_point_from_where_it_is_by_then)
{
  const World w = world_of(
      kFlat,
      "objects: [wall: {from_m: [6, -9], to_m: [6, 9], height_m: 9, thickness_m: 0.2}]\n"
      "sensor: {motion_distortion: true, noise_m: 0}\n",
      "{path_m: [[0, 0], [5, 0]], speed_mps: 5}");
  const Drive drive(w);
  const Scan s = drive.scan(2);
  ASSERT_EQ(s.time_s.size(), s.size());
  EXPECT_TRUE(std::is_sorted(s.time_s.begin(), s.time_s.end()));
  EXPECT_LT(s.time_s.back(), 0.1);
  int on_wall = 0;
  for (std::size_t i = 0; i < s.size(); ++i)
  {
    if (s.z_m[i] < 0 || std::abs(s.y_m[i]) > 3 || s.x_m[i] < 0) continue;
    EXPECT_NEAR(1.0 + 5 * s.time_s[i] + s.x_m[i], 5.9, 1e-5);
    ++on_wall;
  }
  EXPECT_GT(on_wall, 500);
}

TEST(Scanner, that_is_a_camera_looks_forward_only)
{
  const Scan s = Drive(world_of(kFlat, "sensor: {scanner: depth-camera}\n")).scan(0);
  ASSERT_GT(s.size(), 5000u);
  for (std::size_t i = 0; i < s.size(); ++i)
    ASSERT_LE(std::abs(s.y_m[i]), s.x_m[i] * std::tan(radians(43.5)) + 1e-5);
}

TEST(Robot, stands_on_a_slope_with_the_roll_and_pitch_of_the_ground)
{
  const World w = world_of(
      "- plane: {z_m: 1, slope_x_deg: 10, slope_y_deg: 5}\n", "",
      "{path_m: [[0, 0], [3, 3]], speed_mps: 1}");
  const talus::Pose T = Drive(w).T_map_base(20);
  const Vec3 normal = normalized({-std::tan(radians(10)), -std::tan(radians(5)), 1});
  EXPECT_NEAR(T.x(), std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(T.z(), w.ground.height_m(T.x(), T.y()), kExact_m);
  const Vec3 up = rotate(T, {0, 0, 1}), forward = rotate(T, {1, 0, 0});
  EXPECT_NEAR(norm(up - normal), 0, kExact_m);
  EXPECT_NEAR(std::atan2(forward.y, forward.x), kPi / 4, kExact_m);
}

TEST(Robot, has_a_noisy_pose_that_errs_and_drifts_as_asked)
{
  const World w = world_of(kFlat, "", "{path_m: [[0, 0], [100, 0]]}");
  DriveOptions options;
  options.pose_noise_m = 0.02;
  options.z_drift = 0.01;
  const Drive drive(w, options);
  double squares = 0, climb = 0;
  for (int i = 0; i < drive.frames(); ++i)
  {
    const talus::Pose truth = drive.T_map_base(i), noisy = drive.T_map_base_noisy(i);
    squares += (noisy.x() - truth.x()) * (noisy.x() - truth.x());
    climb += (noisy.z() - truth.z()) / drive.frames();
  }
  EXPECT_NEAR(std::sqrt(squares / drive.frames()), 0.02, 0.002);
  EXPECT_NEAR(climb, 0.5, 0.01) << "1 m of drift at the end, half of it on average";
}

TEST(WorldFile, errors_name_file_line_key_and_the_nearest_known_key)
{
  const std::string robot = "robot: {path_m: [[0, 0]], duration_s: 1}\n";
  const auto expect = [](const std::string& text, const std::string& part)
  { EXPECT_TRUE(has(error_of(text), part)); };
  expect(
      "ground:\n- plane: {z_m: 0}\n- step: {at_m: [0, 0],\n   heigth_m: 1}\n" + robot,
      "bad.yaml:4: ground.step: unknown key 'heigth_m', did you mean 'height_m'? Known: at_m");
  expect("ground: [plane: {z_m: low}]\n" + robot, "bad.yaml:1: ground.plane: key 'z_m': 'low'");
  expect("ground: [plane: {}]\ngoal_m: [1, 0]\n" + robot, "--goal X,Y");
  expect("ground: [sine: {amplitude_m: 1}]\n" + robot, "key 'wavelength_m' is missing");
  expect("ground: [plan: {}]\n" + robot, "did you mean 'plane'?");
  expect(
      "ground: [plane: {}]\nseed: 1\nseed: 2\n" + robot, "bad.yaml:3: world: key 'seed' is given");
  expect("ground: [plane: {}]\nrobot: {path_m: [[0, 0, 0]]}\n", "must be a list of 2 numbers");
  expect("ground: [plane: {}]\nsensor: {scanner: VLP-61}\n" + robot, "did you mean 'VLP-16'?");
  expect(
      "ground: [plane: {}]\nobjects: [box: {at_m: [0, 0], size_m: [1, 1, -1]}]\n" + robot,
      "-1 is not in [");
  expect(
      "ground: [plane: {}]\nmovers: [person: {path: [[1, 0, 0], [1, 2, 0]]}]\n" + robot,
      "ascending times");
  expect("ground: [plane: {}\n" + robot, "not valid YAML");
  expect("", "bad.yaml:1: world: must be a map");
  expect(
      "ground: [image: {file: none.pgm, pixel_m: 1, min_m: 0, max_m: 1}]\n" + robot,
      "key 'file' none.pgm: no such file");
}

TEST(WorldFile, with_a_key_that_is_no_word_or_a_second_document_says_where)
{
  const std::string world = "ground: [plane: {}]\nrobot: {path_m: [[0, 0]]}\n";
  EXPECT_EQ(error_of(world), "no error");
  for (const char* key : {"{a: 1}: 3\n", "[1, 2]: 3\n"})
    EXPECT_EQ(
        error_of(world + key), "bad.yaml:3: world: a key must be a word, not a list or a map");
  EXPECT_EQ(
      error_of("ground: [{[1]: 3}]\nrobot: {path_m: [[0, 0]]}\n"),
      "bad.yaml:1: ground: a key must be a word, not a list or a map");
  const std::string two = error_of(world + "---\n" + world);
  EXPECT_EQ(two.rfind("bad.yaml:4: world: a second YAML document", 0), 0U) << two;
  EXPECT_EQ(error_of("---\n" + world + "---\n"), "no error") << "only one holds anything";
  for (const std::string stray : {"]", ", 1", "} x"})
  {
    const std::string first = error_of(stray + "\n" + world);
    EXPECT_EQ(first.rfind("bad.yaml:1: not valid YAML", 0), 0U) << first;
    const std::string later = error_of(world + "---\n" + stray);
    EXPECT_EQ(later.rfind("bad.yaml:4: ", 0), 0U) << later;
  }
  const std::string deep = error_of("ground: " + std::string(20000, '['));
  EXPECT_EQ(deep.rfind("bad.yaml:1: lists and maps are nested too deeply", 0), 0U) << deep;
}

TEST(WorldFile, of_too_many_parts_is_refused_at_once)
{
  const auto error = [](const std::string& object)
  {
    return error_of(
        "ground: [plane: {}]\nrobot: {path_m: [[0, 0]]}\nobjects:\n  - " + object + "\n");
  };
  const std::string rail = "railing: {height_m: 1, from_m: [-1, 2], ";
  EXPECT_EQ(
      error(rail + "to_m: [1, 2], bars: 20, spacing_m: 1e-6}"),
      "bad.yaml:4: objects.railing: key 'spacing_m' makes 42000001 parts, the limit is 10000: take "
      "a shorter line or fewer parts");
  const std::string overflow = error(rail + "to_m: [1e6, 2], spacing_m: 1e-6}");
  EXPECT_TRUE(has(overflow, "key 'spacing_m' makes 3"));
  EXPECT_TRUE(has(error(rail + "to_m: [1e6, 2]}"), "key 'to_m' makes"));
  EXPECT_EQ(error(rail + "to_m: [1999, 2]}"), "no error");
  const std::string wall = "wall: {height_m: 1, from_m: [0, 2], to_m: ";
  EXPECT_TRUE(has(error(wall + "[10001, 2]}"), "key 'to_m' makes 10001"));
  EXPECT_EQ(error(wall + "[10000, 2]}"), "no error");
}

TEST(WorldFile, whose_lists_repeat_one_thing_without_an_end_is_refused_at_once)
{
  const auto repeat = [](const std::string& first, int times)
  {
    std::string list = "[&again " + first;
    for (int i = 0; i < times; ++i) list += ",*again";
    return list + "]\n";
  };
  const std::string robot = "robot: {path_m: [[0, 0]], duration_s: 1}\n";
  EXPECT_EQ(
      error_of(robot + "ground: " + repeat("{plane: {}}", 100000)),
      "bad.yaml:2: ground: has 100001 entries, the limit is 1000");
  const std::string flat = robot + "ground: [plane: {}]\n";
  EXPECT_EQ(
      error_of(flat + "movers: " + repeat("{person: {path: [[0, 5, 5]]}}", 100000)),
      "bad.yaml:3: movers: has 100001 entries, the limit is 1000");
  const std::string wall = "{wall: {height_m: 1, from_m: [0, 2], to_m: [9000, 2]}}";
  const auto error = error_of(flat + "objects: " + repeat(wall, 100000));
  EXPECT_TRUE(has(error, "more than 200000: leave some out"));
}

TEST(WorldFile, whose_robot_drives_too_far_is_refused_before_memory_ends)
{
  const auto error = [](const std::string& path)
  { return error_of("ground: [plane: {}]\nrobot: {path_m: " + path + "}\nobjects: []\n"); };
  EXPECT_EQ(
      error("[[0, 0], [1e6, 0], [-1e6, 0]]"),
      "bad.yaml:2: robot: key 'path_m' is longer than 100 km: shorten it");
  EXPECT_EQ(error("[[0, 0], [50, 0], [0, 0]]"), "no error");
}

TEST(WorldFile, that_cannot_be_read_to_its_end_is_no_world)
{
  const auto error = [](const std::string& path) { return message_of([&] { load_world(path); }); };
  const std::string file = "/proc/self/mem";  // nothing can be read at its beginning
  EXPECT_TRUE(!std::filesystem::exists(file) || has(error(file), file + ": is empty"));
  const std::string too_long(300, 'x');
  EXPECT_TRUE(has(error(too_long), too_long + ": no such file"));
}

TEST(WorldFile, whose_mover_goes_through_a_thing_says_where_and_when)
{
  const auto error = [](const std::string& object, const std::string& mover)
  {
    return error_of(
        "ground: [plane: {z_m: 1}]\nobjects: [" + object + "]\nrobot: {path_m: [[0, -5]]}\n" +
        "movers:\n  - person: {radius_m: 0.2, " + mover + "}\n");
  };
  const std::string box = "box: {at_m: [5, 0], size_m: [1, 1, 1]}", path = "path: [[0, 0, 0], ";
  EXPECT_EQ(
      error(box, path + "[10, 10, 0]]"),
      "bad.yaml:5: movers.person: key 'path' leads into an object: at (4.4, 0.0) after 4.4 s; "
      "lead it around, or move the object");
  EXPECT_NE(error(box, path + "[9, 9, 0.6]]"), "no error") << "grazes its side";
  EXPECT_EQ(error(box, path + "[9, 0, 9]]"), "no error") << "another way";
  EXPECT_EQ(error(box, path + "[2, 0, 0.8], [9, 9, 0.8]]"), "no error") << "passes beside";
  EXPECT_EQ(error(box, path + "[9, 9, 0]], lift_m: 1.1"), "no error") << "flies over";
  EXPECT_EQ(error("box: {at_m: [5, 0], size_m: [1, 1, 0.19]}", path + "[9, 9, 0]]"), "no error");
  EXPECT_NE(error("box: {at_m: [5, 0], size_m: [1, 1, 0.25]}", path + "[9, 9, 0]]"), "no error");
  EXPECT_NE(
      error("post: {at_m: [5, 0], height_m: 1, radius_m: 0.02}", path + "[9, 9, 0]]"), "no error");
  const std::string beam = "beam: {from_m: [5, -1], to_m: [5, 1], width_m: 0.1, thickness_m: 0.1, ";
  EXPECT_NE(error(beam + "underside_m: 1.7}", path + "[9, 9, 0]]"), "no error") << "head";
  EXPECT_EQ(error(beam + "underside_m: 1.8}", path + "[9, 9, 0]]"), "no error") << "passes below";
  EXPECT_EQ(error("foliage: {at_m: [5, 0], size_m: [1, 1, 1]}", path + "[9, 9, 0]]"), "no error");
  EXPECT_EQ(error(box, path + "[9, 0, 1e6]]"), "no error") << "and soon, however long the way";
}

TEST(WorldFile, whose_mover_meets_the_robot_says_where_and_when)
{
  const auto error = [](const std::string& mover, const std::string& robot)
  {
    return error_of(
        "ground: [plane: {}]\nrobot: {" + robot + "}\nsensor: {at_m: [0, 0, 0.8]}\n" +
        "movers: [box: {size_m: [0.4, 0.4, 1], " + mover + "}]\n");
  };
  const std::string drive = "path_m: [[0, 0], [8, 0]], wheelbase_m: 0.6";
  EXPECT_EQ(
      error("path: [[0, 8, 0], [8, 0, 0]]", drive),
      "bad.yaml:4: movers.box: key 'path' leads into the robot: at (4.2, 0.0) after 3.8 s; "
      "lead it around, or let it come earlier or later");
  EXPECT_EQ(error("path: [[0, 8, 0.5], [8, 0, 0.5]]", drive), "no error") << "passes beside";
  EXPECT_EQ(error("path: [[5, 4, 1], [6, 4, -1]]", drive), "no error") << "crosses behind";
  EXPECT_NE(error("path: [[3, 4, 1], [5, 4, -1]]", drive), "no error");
  EXPECT_NE(error("path: [[0, 4, 0]]", drive), "no error") << "stands in the way";
  EXPECT_EQ(error("path: [[0, 4, 0]], lift_m: 0.9", drive), "no error") << "hangs over it";
  EXPECT_EQ(error("path: [[9, 4, 0], [12, 8, 0]]", "path_m: [[0, 0]]"), "no error");
  EXPECT_NE(error("path: [[3, 4, 3], [6, 0, 0]]", "path_m: [[0, 0]], duration_s: 7"), "no error")
      << "where the robot waits";
  EXPECT_EQ(error("path: [[3, 4, 3], [8, 0, 0]]", "path_m: [[0, 0]], duration_s: 7"), "no error")
      << "when the drive is over";
}

TEST(Drive, of_endless_many_or_no_number_of_frames_is_refused_with_what_it_would_have)
{
  World w = world_of(kFlat, "", "{path_m: [[0, 0]], duration_s: 100000}");
  const auto error = [&w] { return message_of([&w] { Drive{w}; }); };
  EXPECT_TRUE(has(error(), "1000001 frames"));
  for (const auto& [rate_hz, text] :
       {std::pair{std::numeric_limits<double>::infinity(), "inf frames"},
        {std::nan(""), "nan frames"},
        {1e300, "1e+305 frames"}})
  {
    w.sensors[0].rate_hz = rate_hz;
    EXPECT_TRUE(has(error(), text));
  }
}

TEST(HeightImage, that_is_too_short_or_brighter_than_white_is_refused)
{
  const auto file = std::filesystem::path(testing::TempDir()) / "talus_sim_bad.pgm";
  const auto error = [&](const std::string& bytes)
  {
    std::ofstream(file, std::ios::binary) << bytes;
    return message_of([&] { read_pgm(file.string()); });
  };
  EXPECT_EQ(error("P2 2 1 100 0 100"), "no error");
  EXPECT_TRUE(has(error("P2 2 1 100 0 101"), "a pixel of 101, white is 100"));
  EXPECT_TRUE(has(error("P2 2 1 100 0 -1"), "a pixel of -1"));
  EXPECT_TRUE(has(error(std::string("P5 2 1 1 \1\2")), "a pixel of 2"));
  EXPECT_TRUE(has(error("P2 3 1 100 0 100"), "ends before"));
  EXPECT_TRUE(has(error("P5 20000 20000 255 abc"), "ends before"));
  std::filesystem::remove(file);
}

TEST(RobotPath, finds_the_nearest_of_its_places)
{
  World w = world_of(kFlat);
  w.robot = {};
  w.robot.waypoints = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {1, 1, 0}, {-20, 3, 0}};
  const RobotPath path(w);
  for (double x = -25; x < 15; x += 1.7)
    for (double y = -5; y < 15; y += 1.3)
    {
      double nearest = HUGE_VAL;
      for (double t = 0; t < path.duration_s(); t += 0.02)
      {
        const auto T = path.T_map_base(t);
        nearest = std::min(nearest, std::hypot(T.x() - x, T.y() - y));
      }
      EXPECT_NEAR(path.distance_to_m(x, y), nearest, 0.02) << x << " " << y;
    }
}

TEST(WorldFile, takes_the_ground_from_a_height_image_and_knows_nothing_beyond_it)
{
  const auto folder = std::filesystem::path(testing::TempDir());
  std::ofstream(folder / "talus_sim_hill.pgm") << "P2\n# hill\n3 2\n100\n0 50 100\n0 0 100\n";
  const World w = parse_world(
      "ground: [image: {file: talus_sim_hill.pgm, pixel_m: 1, min_m: 0, max_m: 2}]\n"
      "robot: {path_m: [[0, 0]], duration_s: 1}\n",
      (folder / "world.yaml").string());
  EXPECT_NEAR(w.ground.height_m(1, 1), 1.0, 1e-6) << "north row, middle";
  EXPECT_NEAR(w.ground.height_m(1.5, 0), 1.0, 1e-6);
  EXPECT_NEAR(w.ground.height_m(2, 0.5), 2.0, 1e-6);
  EXPECT_NEAR(cast_m(w, {0.5, 0.5, 3}, {0, 0, -1}), 2.75, 1e-6);
  EXPECT_FALSE(std::isnan(cell_at(w, 1, 0.5).label));
  EXPECT_TRUE(std::isnan(cell_at(w, 2.5, 0.5).label) && std::isnan(cell_at(w, 2.5, 0.5).ground));
}

TEST(DropReach, is_what_one_ray_sees_of_a_hole)
{
  Scanner one;
  one.elevations_rad = {-std::atan(0.25)};  // meets the ground 4 m ahead of a sensor at 1 m
  one.rate_hz = 10;
  const talus::Pose up = pose_from_rpy({0.5, 0, 1}, 0);
  Stopping stopping;
  EXPECT_NEAR(nearest_ground_m(one, up), 4.5, 1e-9);
  EXPECT_NEAR(stopping.distance_m(2), 0.4 * 2 + 2, 1e-9);
  EXPECT_NEAR(narrowest_hole_m(one, up, 1, stopping), 0.05 / 0.25 + 0.1, 1e-9)
      << "5 cm down over its width, and on as it drives in a tenth of a second";
  const double fastest = fastest_before_hole_mps(one, up, 1, stopping);
  EXPECT_NEAR(stopping.distance_m(fastest) + 0.1 * fastest + 0.3, 4.5, 0.04);
  EXPECT_EQ(narrowest_hole_m(one, up, fastest + 0.02, stopping), INFINITY);
  EXPECT_NEAR(fastest_before_hole_mps(one, up, 0.3, stopping), 1, 0.011);
  EXPECT_EQ(fastest_before_hole_mps(one, up, 0.19, stopping), 0) << "narrower than it can see";
  one.elevations_rad = {0.1};
  EXPECT_EQ(nearest_ground_m(one, up), INFINITY);
  EXPECT_EQ(fastest_before_hole_mps(one, up, 5, stopping), 0);
}

TEST(WorldFile, of_every_world_of_the_project_has_a_free_way_of_60_to_250_frames)
{
  // A sill across the way, which is steep; a rim close beside it.
  const std::set<std::string> narrow{"basement", "greenhouse", "playground"};
  int worlds = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(TALUS_WORLDS_DIR))
  {
    if (entry.path().extension() != ".yaml") continue;
    const World w = load_world(entry.path().string());
    const Drive drive(w);
    EXPECT_GE(drive.frames(), 60) << w.name;
    EXPECT_LE(drive.frames(), 250) << w.name;
    TruthOptions options;
    options.movers = false;
    options.samples = 2;
    const TruthWindow window = window_around(drive.path().bounds(), 0.4, 0.1);
    const Truth t = truth(w, window, 0, options);
    double beside = 0, free_beside = 0;
    for (int i = 0; i < window.cells_x * window.cells_y; ++i)
    {
      const double x = window.min_x_m + (i % window.cells_x + 0.5) * window.resolution_m;
      const double y = window.min_y_m + (i / window.cells_x + 0.5) * window.resolution_m;
      const double distance_m = drive.path().distance_to_m(x, y);
      if (distance_m > 0.3) continue;
      ++beside;
      free_beside += t.label[i] == 1;
      if (narrow.count(w.name) == 0)
      {
        EXPECT_EQ(t.label[i], 1) << w.name << " at " << x << ", " << y;
      }
      const bool stands = t.obstacle_top[i] - t.ground[i] > options.min_obstacle_m;
      EXPECT_FALSE(stands && distance_m < 0.1) << w.name << " at " << x << ", " << y;
    }
    EXPECT_GT(free_beside, 0.9 * beside) << w.name << ": things stand close to the way";
    ++worlds;
  }
  EXPECT_GE(worlds, 14);
}
