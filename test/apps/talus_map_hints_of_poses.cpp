// What poses and clocks do wrong is told by its name: no pitch, a late clock, scans that are sweeps
// of a robot that turns fast.
#include <talus/io/trajectory.h>

#include <algorithm>
#include <optional>

#include "hint_scene.h"

using namespace talus;
using namespace talus::test;

namespace
{
const std::map<std::string, int> kNone;

class TalusMapHintsOfPoses : public HintScenes
{
};

constexpr const char* kHills = R"(
seed: 5
ground:
  - sine: {amplitude_m: 0.3, wavelength_m: 10}
  - roughness: {amplitude_m: 0.01, wavelength_m: 0.4, seed: 3}
objects:
  - wall: {from_m: [-4, 5], to_m: [14, 5], height_m: 2.5}
  - box: {at_m: [6, -3], size_m: [1, 1, 1]}
robot: {path_m: [[0, 0], [5, 0.5], [10, 0]], speed_mps: 1.2}
)";
constexpr const char* kSlope = R"(
ground: [plane: {slope_x_deg: 7}]
objects: [box: {at_m: [6, -3], size_m: [1, 1, 1]}]
robot: {path_m: [[0, 0], [8, 0]], speed_mps: 1.2}
)";

/** Drives 2 m, turns on the spot to the left and back to the right at that rate, drives on. */
std::function<Place(double)> turning_at(double rate_rps, double back_rps)
{
  return [=](double time_s) -> Place
  {
    const double to_left_s = 2, turn_s = 1.2 / rate_rps, back_s = 2.4 / back_rps;
    const double left = std::clamp((time_s - to_left_s) / turn_s, 0.0, 1.0);
    const double right = std::clamp((time_s - to_left_s - turn_s - 0.5) / back_s, 0.0, 1.0);
    return {std::min(time_s, to_left_s), 0, 1.2 * left - 2.4 * right};
  };
}

/** A room, 10 Hz. */
Scene room_with(const std::function<Place(double)>& robot)
{
  Scene scene;
  scene.robot = robot;
  scene.duration_s = 7;
  scene.step_s = 0.1;
  return scene;
}
}  // namespace

TEST_F(TalusMapHintsOfPoses, whose_axes_are_mirrored_swapped_or_turned)
{
  Scene scene = room_with(
      [](double t) -> Place {
        return {10 * std::sin(t / 10), 10 * (1 - std::cos(t / 10)), t / 10};
      });
  scene.step_s = 0.2;
  scene.duration_s = 8;
  write_scene(scene);
  EXPECT_EQ(causes(), kNone);
  const auto poses = talus::io::Trajectory::load(path("drive.tum"));
  using Change = Place (*)(const CPose3D&);
  const std::map<std::string, Change> mistakes{
      {"y of the poses is mirrored",
       [](const CPose3D& T) {
         return Place{T.x(), -T.y(), T.yaw()};
       }},
      {"y and yaw of the poses",
       [](const CPose3D& T) {
         return Place{T.x(), -T.y(), -T.yaw()};
       }},
      {"x and y of the poses",
       [](const CPose3D& T) {
         return Place{T.y(), T.x(), T.yaw()};
       }},
      {"turned by yaw 45 degrees",
       [](const CPose3D& T) {
         return Place{T.x(), T.y(), T.yaw() - M_PI / 4};
       }},
      {"is that of a compass",
       [](const CPose3D& T) {
         return Place{T.x(), T.y(), M_PI / 2 - T.yaw()};
       }},
      {"poses are inverted",
       [](const CPose3D& T) {
         return Place{(-T).x(), (-T).y(), (-T).yaw()};
       }},
      {"a point of the robot",
       [](const CPose3D& T)
       {
         const CPose3D antenna = T + CPose3D(1.2, -0.5, 0, 0, 0, 0);
         return Place{antenna.x(), antenna.y(), T.yaw()};
       }},
      {"the poses have no yaw",
       [](const CPose3D& T) {
         return Place{T.x(), T.y(), 0};
       }},
      {"multiplied by 0.1000:",
       [](const CPose3D& T) {
         return Place{10 * T.x(), 10 * T.y(), T.yaw()};
       }},
      {"multiplied by 0.3",
       [](const CPose3D& T) {
         return Place{T.x() / 0.3, T.y() / 0.3, T.yaw()};
       }},
      {"multiplied by 2.0",
       [](const CPose3D& T) {
         return Place{T.x() / 2, T.y() / 2, T.yaw()};
       }},
      {"in millimetres",
       [](const CPose3D& T) {
         return Place{1e3 * T.x(), 1e3 * T.y(), T.yaw()};
       }},
      {"stands still by its poses", [](const CPose3D&) {
         return Place{0, 0, 0};
       }}};
  for (const auto& [text, changed] : mistakes)
  {
    std::string tum;
    for (const auto& [time_s, T] : poses.entries())
    {
      const Place p = changed(T);
      tum += mrpt::format(
          "%.6f %f %f 0 0 0 %f %f\n", time_s, p.x_m, p.y_m, std::sin(p.heading_rad / 2),
          std::cos(p.heading_rad / 2));
    }
    write_bytes(path("drive.tum"), tum);
    const CommandEnd done = run("drive.rawlog --no-site --output out");
    EXPECT_TRUE(done.says(text)) << text << ", and not: " << done.err;
  }
}

TEST_F(TalusMapHintsOfPoses, of_a_robot_that_drives_sideways)
{
  Mistakes turned = mounting_off_by({});
  const CPose3D quarter(0, 0, 0, M_PI / 2, 0, 0);
  turned.mounting = [=](const CPose3D& T_base_sensor, const std::string&)
  { return (-quarter) + T_base_sensor; };
  turned.pose = [=](const CPose3D& T, double) { return T + quarter; };
  write_drive(kOneSensor, turned);
  EXPECT_EQ(causes(), only("drives sideways"));
}

TEST_F(TalusMapHintsOfPoses, in_the_frame_of_a_tilted_sensor_are_levelled)
{
  Mistakes tilted;
  std::optional<CPose3D> first;
  tilted.pose = [&](const CPose3D& T, double)
  {
    if (!first) first = T + CPose3D(0.1, 0, 0.9, 0, 12 * kDegree, 0);
    return (-*first) + T;
  };
  write_drive(
      "sensor: {scanner: RS-LiDAR-16, at_m: [0.1, 0, 0.9], roll_pitch_yaw_deg: [0, 12, 0]}\n",
      tilted, "ground: [plane: {}]\nrobot: {path_m: [[0, 0], [9, 0]]}\n");
  const CommandEnd leaning = run("drive.rawlog --no-site --output out");
  EXPECT_TRUE(leaning.says("--level turns the map upright")) << leaning.err;
  EXPECT_EQ(causes("--level"), kNone);
  const std::string poses = summary("out")["poses"];
  EXPECT_NE(poses.find("drive.tum, levelled by 1"), std::string::npos) << poses;
}

TEST_F(TalusMapHintsOfPoses, without_pitch_on_hills)
{
  Mistakes level;
  level.pose = [](const CPose3D& T, double)
  { return CPose3D(T.x(), T.y(), T.z(), T.yaw(), 0, T.roll()); };
  for (const char* world : {kHills, kSlope})
  {
    write_drive(kOneSensor, {}, world);
    EXPECT_EQ(causes(), kNone) << world;
    write_drive(kOneSensor, level, world);
    EXPECT_EQ(causes(), only("poses have no pitch")) << world;
  }
}

TEST_F(TalusMapHintsOfPoses, of_a_plane_on_hills)
{
  Mistakes flat;
  flat.pose = [](const CPose3D& T, double) { return CPose3D(T.x(), T.y(), 0, T.yaw(), 0, 0); };
  write_drive(kOneSensor, flat, kHills);
  EXPECT_EQ(causes(), only("poses have no pitch"));
}

TEST_F(TalusMapHintsOfPoses, of_a_plane_on_level_ground_are_right)
{
  write_scene(room_with(turning_at(1, 1)));
  EXPECT_EQ(causes(), kNone);
}

TEST_F(TalusMapHintsOfPoses, whose_heights_are_noisy_on_level_ground_are_no_hills)
{
  Mistakes noisy;
  noisy.pose = [](const CPose3D& T, double time_s)
  { return CPose3D(T.x(), T.y(), 0.04 * std::sin(1e4 * time_s), T.yaw(), 0, 0); };
  write_drive(kOneSensor, noisy, "ground: [plane: {}]\nrobot: {path_m: [[0, 0], [9, 0]]}\n");
  const auto told = causes();
  EXPECT_EQ(told.count("poses have no pitch"), 0U);
}

TEST_F(TalusMapHintsOfPoses, against_which_the_clock_of_the_scans_is_late_or_early)
{
  for (const double late_s : {0.12, -0.08})
  {
    Scene scene = room_with(turning_at(0.8, 0.8));
    scene.late_s = late_s;
    write_scene(scene);
    const CommandEnd done = run("drive.rawlog --no-site --output out");
    EXPECT_EQ(causes_in(done.err), only("the clock of the scans")) << done.err;
    const std::string seconds = late_s > 0 ? "0.12 s late" : "0.08 s early";
    EXPECT_TRUE(done.says("the clock of the scans is " + seconds)) << done.err;
  }
}

TEST_F(TalusMapHintsOfPoses, in_other_units_of_a_drive_of_five_metres)
{
  const std::map<double, std::string> units{
      {1 / 0.0254, "0.0254:"}, {10, "0.1000:"}, {1 / 0.3048, "0.3048:"}, {0.1, "10.00:"}};
  for (const double scale : {1.0, 1 / 0.0254, 10.0, 1 / 0.3048, 0.1})
  {
    Scene scene = room_with([](double t) -> Place { return {std::min(t, 4.7), 0, 0}; });
    scene.bystander = {{3, 3.6, 2, 2.8, 1}, {7, 7.3, -3, -2, 1}, {8, 8.6, 3, 3.5, 1}};
    scene.sweep_s = 0.1;
    scene.has_times = true;
    scene.duration_s = 4.7;
    write_scene(scene);
    std::string tum;
    for (const auto& [time_s, T] : talus::io::Trajectory::load(path("drive.tum")).entries())
      tum += mrpt::format("%.6f %f 0 0 0 0 0 1\n", time_s, scale * T.x());
    write_bytes(path("drive.tum"), tum);
    const CommandEnd done = run("drive.rawlog --no-site --output out");
    EXPECT_EQ(done.says("multiplied by"), scale != 1);
    EXPECT_TRUE(scale == 1 || done.says("multiplied by " + units.at(scale))) << done.err;
  }
}

TEST_F(TalusMapHintsOfPoses, of_another_drive_and_mirrored_along_x)
{
  Scene scene = room_with([](double t) -> Place { return {0.6 * t, 0, 0.8 * std::sin(t)}; });
  scene.bystander = {
      {3, 3.6, 2, 2.8, 1}, {4, 4.3, -3, -2, 1}, {7, 7.6, 1, 1.5, 1}, {9, 9.2, -8, 4.5, 2}};
  scene.duration_s = 12;
  write_scene(scene);
  EXPECT_EQ(causes(), kNone);
  for (const bool is_mirrored : {false, true})
  {
    std::string tum;
    for (int i = 0; i < 120; ++i)
    {
      const double yaw = 0.8 * std::sin(0.1 * i + (is_mirrored ? 0 : 2.5));
      tum += mrpt::format(
          "%.6f %f %f 0 0 0 %f %f\n", kFirstStamp_s + 0.1 * i, (is_mirrored ? -0.06 : 0.06) * i,
          is_mirrored ? 0 : 0.02 * i, std::sin(yaw / 2), std::cos(yaw / 2));
    }
    write_bytes(path("drive.tum"), tum);
    EXPECT_TRUE(run("drive.rawlog --no-site --output out")
                    .says(is_mirrored ? "x of the poses is mirrored" : "the poses of this log"));
  }
}

TEST_F(TalusMapHintsOfPoses, of_a_late_clock_show_where_points_have_times)
{
  Scene scene = room_with(turning_at(0.8, 0.8));
  scene.sweep_s = 0.1;
  scene.has_times = true;
  for (const double late_s : {0.0, 0.12})
  {
    scene.late_s = late_s;
    write_scene(scene);
    EXPECT_EQ(causes(), late_s == 0 ? kNone : only("the clock of the scans"));
  }
}

TEST_F(TalusMapHintsOfPoses, where_the_times_of_points_run_backwards)
{
  Scene scene = room_with(turning_at(0.8, 0.8));
  scene.sweep_s = 0.1;
  scene.has_times = scene.has_times_backwards = true;
  write_scene(scene);
  EXPECT_EQ(causes(), only("the times of the points run backwards"));
}

TEST_F(TalusMapHintsOfPoses, against_which_the_clock_of_the_scans_runs_fast_or_slow)
{
  write_scene(room_with(turning_at(0.8, 0.8)));
  const auto poses = talus::io::Trajectory::load(path("drive.tum"));
  for (const double seconds : {0.95, 1.05})
  {
    std::string tum;
    for (const auto& [time_s, T] : poses.entries())
      tum += mrpt::format(
          "%.6f %f %f 0 0 0 %f %f\n", kFirstStamp_s + seconds * (time_s - kFirstStamp_s), T.x(),
          T.y(), std::sin(T.yaw() / 2), std::cos(T.yaw() / 2));
    write_bytes(path("drive.tum"), tum);
    const CommandEnd done = run("drive.rawlog --no-site --output out");
    EXPECT_TRUE(done.says("the clock of the scans runs 5.")) << done.err;
    EXPECT_TRUE(done.says(seconds < 1 ? "% fast against" : "% slow against")) << done.err;
  }
}

TEST_F(TalusMapHintsOfPoses, that_turn_fast_while_a_scan_is_taken)
{
  for (const double rate_rps : {1.5, 2.5})
  {
    Scene scene = room_with(turning_at(rate_rps, rate_rps));
    write_scene(scene);
    EXPECT_EQ(causes(), kNone) << "a scan of one moment";
    scene.sweep_s = 0.1;
    write_scene(scene);
    const CommandEnd done = run("drive.rawlog --no-site --output out");
    EXPECT_EQ(causes_in(done.err), only("scans are not deskewed")) << rate_rps;
  }
}

TEST_F(TalusMapHintsOfPoses, that_turn_slowly_while_a_scan_is_taken_are_right)
{
  Scene scene = room_with(turning_at(0.4, 0.4));
  scene.sweep_s = 0.1;
  write_scene(scene);
  EXPECT_EQ(causes(), kNone);
}
