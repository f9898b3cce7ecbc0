// The simulator's robots with several sensors, lifts and decks, its errors of localisation, and
// what appears, vanishes or gives way.
#include <gtest/gtest.h>

#include <cmath>

#include "message_of.h"
#include "sim_world.h"

using namespace talus::sim;

namespace
{
/** Heights above the map's zero of what a frame hit. */
std::vector<double> heights_m(const Drive& drive, int frame)
{
  const auto T = compose(drive.T_map_base(frame), drive.T_base_sensor(frame));
  const Scan s = drive.scan(frame);
  std::vector<double> z;
  for (std::size_t i = 0; i < s.size(); ++i)
    z.push_back(transform(T, {s.x_m[i], s.y_m[i], s.z_m[i]}).z);
  return z;
}
}  // namespace

TEST(SeveralSensors, take_frames_in_the_order_of_time_each_with_its_own_mounting)
{
  const World w = world_of(
      kFlat,
      "sensors:\n"
      "- {name: front, scanner: VLP-16, at_m: [0.6, 0, 1], noise_m: 0, dropout: 0}\n"
      "- {name: rear, scanner: VLP-16, at_m: [-0.6, 0, 0.7], roll_pitch_yaw_deg: [180, 0, 0],\n"
      "   phase_s: 0.05, noise_m: 0}\n"
      "- {name: slow, rate_hz: 5, noise_m: 0}\n");
  const Drive drive(w);
  EXPECT_EQ(drive.frames(), 11 + 10 + 6);
  for (int i = 0; i < drive.frames(); ++i)
  {
    EXPECT_GE(drive.time_s(i), i > 0 ? drive.time_s(i - 1) : 0);
    EXPECT_EQ(drive.T_base_sensor(i).m, w.sensors[drive.sensor(i)].T_base_sensor.m);
  }
  EXPECT_EQ(drive.sensor(0), 0u);
  EXPECT_EQ(drive.sensor(1), 2u);
  EXPECT_EQ(drive.sensor(2), 1u);
  EXPECT_NEAR(drive.time_s(2), 0.05, kExact_m);
  for (const int frame : {0, 1, 2})
    for (const double z : heights_m(drive, frame))
      ASSERT_NEAR(z, 0, 1e-4) << "also upside down; frame " << frame;
}

TEST(SeveralSensors, of_which_none_begins_before_the_end_are_refused)
{
  const World w = world_of(kFlat, "sensors: [{name: late, phase_s: 1.5}]\n");
  EXPECT_TRUE(has(message_of([&] { Drive{w}; }), "no sensor begins a sweep"));
}

TEST(CutFrames, hold_the_points_of_their_sweep_each_from_its_own_place)
{
  const World w = world_of(
      kFlat, "sensor: {noise_m: 0, motion_distortion: true}\n",
      "{path_m: [[0, 0], [1, 0]], speed_mps: 1}");
  DriveOptions options;
  options.cut_frames = 10;
  options.every = 2;
  const Drive whole(w), cut(w, options);
  EXPECT_EQ(whole.frames(), 11);
  EXPECT_EQ(cut.frames(), 60);
  EXPECT_NEAR(cut.time_s(13), 0.23, 1e-9);
  EXPECT_NEAR(cut.T_map_base(13).x(), 0.23, 1e-6);
  std::size_t points = 0;
  for (int i = 10; i < 20; ++i)
  {
    const Scan s = cut.scan(i);
    points += s.size();
    ASSERT_FALSE(s.time_s.empty());
    EXPECT_GE(s.time_s.front(), 0);
    EXPECT_LT(s.time_s.back(), 0.01);
  }
  EXPECT_EQ(points, whole.scan(2).size());
  options.cut_frames = 0;
  EXPECT_THROW(Drive(w, options), std::invalid_argument);
}

TEST(PoseErrors, jump_and_drift_while_the_truth_stays)
{
  const World w = world_of(
      kFlat,
      "poses: {drift_mps: {z: 0.01}, jumps: [{time_s: 0.5, z_m: -0.3, roll_deg: 1}, "
      "{time_s: 0.8, x_m: 2}]}\n",
      "{path_m: [[7, 3]], duration_s: 1}");
  const Drive drive(w);
  ASSERT_TRUE(drive.has_pose_errors());
  EXPECT_NEAR(drive.T_map_base_noisy(4).z(), 0.004, kExact_m);
  EXPECT_NEAR(drive.T_map_base_noisy(5).z(), -0.3 + 0.005, kExact_m);
  EXPECT_NEAR(drive.T_map_base_noisy(5).y(), 3, kExact_m) << "turned about the robot";
  EXPECT_NEAR(rotate(drive.T_map_base_noisy(5), {0, 1, 0}).z, std::sin(radians(1)), kExact_m);
  EXPECT_NEAR(drive.T_map_base_noisy(7).x(), 7, kExact_m);
  EXPECT_NEAR(drive.T_map_base_noisy(8).x(), 9, kExact_m);
  EXPECT_NEAR(drive.T_map_base_noisy(10).z(), -0.3 + 0.01, kExact_m);
  EXPECT_NEAR(drive.T_map_base(10).z(), 0, kExact_m);
}

TEST(Lift, raises_the_robot_on_the_spot_and_leaves_it_on_the_deck)
{
  const World w = world_of(
      kFlat, "objects: [deck: {at_m: [5, 0], size_m: [8, 4], z_m: 3}]\n",
      "{path_m: [[0, 0], [8, 0]], lifts: [{time_s: 0.5, duration_s: 4, z_m: 3}]}");
  const RobotPath path(w);
  EXPECT_NEAR(path.duration_s(), 12, kExact_m);
  EXPECT_NEAR(path.T_map_base(0.4).z(), 0, kExact_m);
  EXPECT_NEAR(path.T_map_base(2.5).z(), 1.5, kExact_m);
  EXPECT_NEAR(path.T_map_base(2.5).x(), 0.5, 1e-6);
  EXPECT_NEAR(path.T_map_base(4.6).z(), 3, kExact_m) << "hangs until it comes to a floor";
  EXPECT_NEAR(path.T_map_base(12).x(), 8, 1e-6);
  EXPECT_NEAR(path.T_map_base(12).z(), 3, kExact_m);
  const World at_once =
      world_of(kFlat, "", "{path_m: [[0, 0]], duration_s: 2, lifts: [{time_s: 1, z_m: 3.2}]}");
  EXPECT_NEAR(RobotPath(at_once).T_map_base(0.99).z(), 0, kExact_m);
  EXPECT_NEAR(RobotPath(at_once).T_map_base(1).z(), 3.2, kExact_m);
}

TEST(Deck, is_driven_on_by_a_ramp_and_driven_below_without)
{
  const std::string ground =
      "- plane: {}\n- ramp: {at_m: [2, 0], length_m: 12, height_m: 2, width_m: 3, top_m: 0}\n";
  const std::string deck = "objects: [deck: {at_m: [19, 0], size_m: [10, 12], z_m: 2}]\n";
  const World up = world_of(ground, deck, "{path_m: [[0, 0], [20, 0]]}");
  const World below = world_of(ground, deck, "{path_m: [[0, 4], [20, 4]]}");
  EXPECT_NEAR(RobotPath(up).T_map_base(8).z(), 1, kExact_m);
  EXPECT_NEAR(RobotPath(up).T_map_base(14.1).z(), 2, 0.03) << "half on the ramp";
  EXPECT_NEAR(RobotPath(up).T_map_base(20).z(), 2, kExact_m);
  EXPECT_NEAR(RobotPath(below).T_map_base(20).z(), 0, kExact_m);
  TruthOptions options;
  const TruthWindow cell{18, 1, 1, 1, 0.05};
  const Truth low = truth(up, cell, 0, options);
  EXPECT_EQ(low.ground[0], 0);
  EXPECT_NEAR(low.underside[0], 1.8, 1e-6);
  options.level_m = 2;
  const Truth high = truth(up, cell, 0, options);
  EXPECT_NEAR(high.ground[0], 2, 1e-6);
  EXPECT_TRUE(std::isnan(high.obstacle_top[0]));
  EXPECT_EQ(high.label[0], 1);
}

TEST(Presence, of_ground_objects_and_movers_is_from_one_time_until_another)
{
  const World w = world_of(
      "- plane: {}\n"
      "- mound: {at_m: [4, 0], radius_m: 2, height_m: 0.5, from_s: 1}\n"
      "- ditch: {at_m: [-4, 0], yaw_deg: 90, width_m: 1, depth_m: 0.5, until_s: 2}\n",
      "objects: [box: {at_m: [0, 4], size_m: [1, 1, 1], from_s: 1, until_s: 3},\n"
      "  box: {at_m: [4, 0], size_m: [0.1, 0.1, 0.2], from_s: 2}]\n"
      "movers: [person: {path: [[0, 0, -4]], until_s: 2}]\n");
  const auto z = [&](double time_s, double x_m, double y_m)
  {
    const auto hit = Scene(w, time_s).cast({{x_m, y_m, 9}, {0, 0, -1}}, 100);
    return hit ? 9 - hit->range_m : -100;
  };
  EXPECT_NEAR(z(0.9, 4, 0), 0, 1e-6);
  EXPECT_NEAR(z(1.0, 4, 0), 0.5, 1e-6);
  EXPECT_NEAR(z(2.0, 4, 0), 0.7, 1e-6) << "on the heap that was there when it appeared";
  EXPECT_NEAR(z(1.9, -4, 0), -0.5, 1e-6);
  EXPECT_NEAR(z(2.0, -4, 0), 0, 1e-6);
  EXPECT_NEAR(z(0.5, 0, 4), 0, 1e-6);
  EXPECT_NEAR(z(1.5, 0, 4), 1, 1e-6);
  EXPECT_NEAR(z(3.0, 0, 4), 0, 1e-6);
  EXPECT_NEAR(z(1.5, 0, -4), 1.75, 1e-6);
  EXPECT_NEAR(z(2.5, 0, -4), 0, 1e-6);
  EXPECT_EQ(cell_at(w, -4, 0, 0).ground, -0.5f);
  EXPECT_EQ(cell_at(w, -4, 0, 2.5).ground, 0);
  EXPECT_EQ(cell_at(w, 0, 4, 0).label, 1);
  EXPECT_EQ(cell_at(w, 0, 4, 1).label, 0);
}

TEST(Grass, stops_rays_somewhere_and_is_no_obstacle)
{
  const World w = world_of(
      kFlat,
      "objects: [grass: {at_m: [3, 0], size_m: [4, 4], height_m: 0.45, density_per_m: 2}]\n"
      "sensor: {noise_m: 0}\n");
  int blades = 0, ground = 0;
  for (const double z : heights_m(Drive(w), 0))
  {
    ASSERT_LE(z, 0.4501);
    ++(z > 0.01 ? blades : ground);
  }
  EXPECT_GT(blades, 300);
  EXPECT_GT(ground, 100);
  const Cell c = cell_at(w, 3, 0);
  EXPECT_EQ(c.label, 1);
  EXPECT_TRUE(std::isnan(c.top));
}

TEST(Body, is_seen_where_it_is_on_the_robot)
{
  const World w = world_of(
      "- plane: {slope_x_deg: 5}\n",
      "sensor: {noise_m: 0, at_m: [0, 0, 0.7], roll_pitch_yaw_deg: [0, 0, 30]}\n",
      "{path_m: [[0, 0]], duration_s: 1, body: [box: {at_m: [1, 0, 0.2], size_m: [0.4, 0.6, 0.5]},"
      " post: {at_m: [-1, 0, 0], height_m: 2, radius_m: 0.05}]}");
  const Drive drive(w);
  const Scan s = drive.scan(0);
  int box = 0, post = 0;
  for (std::size_t i = 0; i < s.size(); ++i)
  {
    const Vec3 p = transform(drive.T_base_sensor(0), {s.x_m[i], s.y_m[i], s.z_m[i]});
    box += std::abs(p.x - 0.8) < 1e-3 && std::abs(p.y) < 0.301;
    post += std::abs(std::hypot(p.x + 1, p.y) - 0.05) < 1e-3;
  }
  EXPECT_GT(box, 100);
  EXPECT_GT(post, 50);
}

TEST(WorldFile, says_what_is_wrong_with_sensors_lifts_poses_and_presence)
{
  const auto expect = [](const std::string& rest, const std::string& robot, const std::string& part)
  {
    const std::string error = error_of(
        "ground: [plane: {}]\n" + rest + "robot: {path_m: [[0, 0]], duration_s: 1" + robot + "}\n");
    EXPECT_TRUE(has(error, part));
  };
  expect("sensors: []\n", "", "bad.yaml:2: sensors: must hold one sensor or more");
  expect("sensors: {}\n", "", "sensors: must be a list, e.g. `- {name: front");
  expect("sensors: [{scanner: VLP-16}]\n", "", "sensors: key 'name' is missing");
  expect("sensors: [{name: a}, {name: a}]\n", "", "'a' is the name of another sensor");
  expect("sensors: [{name: a, fase_s: 1}]\n", "", "did you mean 'phase_s'?");
  expect("sensor: {}\nsensors: [{name: a}]\n", "", "key 'sensor' exclude each other");
  expect("poses: {jumps: [{z_m: 1}]}\n", "", "poses.jumps: key 'time_s' is missing");
  expect("poses: {jumps: [{time_s: 2}, {time_s: 1}]}\n", "", "not be before that of the jump");
  expect("poses: {drift_mps: {w: 1}}\n", "", "poses.drift_mps: unknown key 'w'");
  expect("", ", lifts: [{time_s: 1}]", "robot.lifts: key 'z_m' is missing");
  expect(
      "", ", lifts: [{time_s: 1, duration_s: 2, z_m: 1}, {time_s: 2, z_m: 1}]",
      "before the end of the lift before it");
  expect("", ", body: [bx: {}]", "robot.body: unknown key 'bx', did you mean 'box'?");
  expect("", ", body: [box: {at_m: [0, 0], size_m: [1, 1, 1]}]", "must be a list of 3 numbers");
  expect(
      "objects: [box: {at_m: [0, 0], size_m: [1, 1, 1], from_s: 3, until_s: 3}]\n", "",
      "objects.box: key 'until_s' must be later than from_s");
  expect("objects: [grass: {at_m: [0, 0], size_m: [1, 1]}]\n", "", "key 'height_m' is missing");
  expect("objects: [deck: {at_m: [0, 0], size_m: [1, 1]}]\n", "", "key 'z_m' is missing");
}
