// The command talus-map tells what looks wrongly set: of each wrong configuration its cause and
// nothing else, of sound ones nothing.
#include "hint_drive.h"

using namespace talus;
using namespace talus::test;

namespace
{
const std::map<std::string, int> kNone;

class TalusMapHints : public HintDrive
{
};
}  // namespace

TEST_F(TalusMapHints, a_sound_drive_has_none)
{
  write_drive();
  EXPECT_EQ(causes(), kNone);
  EXPECT_TRUE(summary("out")["hints"].empty());
  EXPECT_EQ(run("drive.rawlog --no-site --strict --output strict").code, 0);
}

TEST_F(TalusMapHints, a_band_that_ends_above_the_ground)
{
  write_drive();
  EXPECT_EQ(causes("-s min_height_m=-0.5"), only("min_height_m ="));
}

TEST_F(TalusMapHints, a_band_that_ends_below_what_the_robot_meets)
{
  write_drive();
  EXPECT_EQ(causes("-s max_height_m=-0.75"), only("max_height_m ="));
}

TEST_F(TalusMapHints, a_window_that_is_too_small)
{
  write_drive();
  EXPECT_EQ(causes("-s window_m=3"), only("outside of the window"));
}

TEST_F(TalusMapHints, a_window_that_ends_before_the_ground_begins)
{
  // Beams down to 15 degrees from 1.2 m meet the floor 4.5 m away. Walls are near, so that most
  // points are inside of the window.
  const std::string corridor = R"(
ground: [plane: {}]
objects:
  - box: {at_m: [3, 1.2], size_m: [0.6, 0.6, 0.5]}
  - wall: {from_m: [-5, 2.2], to_m: [20, 2.2], height_m: 2}
  - wall: {from_m: [-5, -2.2], to_m: [20, -2.2], height_m: 2}
robot: {path_m: [[0, 0], [5, 0]], speed_mps: 1}
)";
  write_drive("sensor: {scanner: VLP-16, at_m: [0, 0, 1.2]}\n", {}, corridor);
  const Outcome done = run("drive.rawlog --no-site --output out");
  EXPECT_EQ(causes_in(done.err), only("outside of the window"));
  EXPECT_TRUE(done.says("the ground begins 4.5 m from the sensor")) << done.err;
  EXPECT_EQ(causes("-s window_m=18"), kNone);
  write_bytes(path("robot.ini"), run("drive.rawlog --suggest").out);
  EXPECT_EQ(causes("--config robot.ini"), kNone);
  EXPECT_GE(summary("out")["parameters"]["window_m"], 12);
}

TEST_F(TalusMapHints, a_window_of_which_little_is_seen)
{
  write_drive();
  EXPECT_EQ(causes("-s window_m=100 -s resolution_m=0.2 -s max_range_m=8"), only("was seen"));
}

TEST_F(TalusMapHints, points_in_the_frame_of_the_base)
{
  Mistakes wrong;
  wrong.points_in_base = true;
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("height of the sensor itself"));
}

TEST_F(TalusMapHints, a_mounting_that_is_too_high)
{
  write_drive(kOneSensor, mounting_off_by({0, 0, 0.45, 0, 0, 0}));
  EXPECT_EQ(causes(), only("mounting contradicts"));
}

TEST_F(TalusMapHints, a_mounting_that_is_tilted)
{
  write_drive(kOneSensor, mounting_off_by({0, 0, 0, 0, 12 * kDegree, 0}));
  EXPECT_EQ(causes(), only("mounting contradicts"));
}

TEST_F(TalusMapHints, a_mounting_that_is_turned_to_its_side)
{
  write_drive(kOneSensor, mounting_off_by({0, 0, 0, 0, 0, 35 * kDegree}));
  EXPECT_EQ(causes(), only("tilted against the base"));
}

TEST_F(TalusMapHints, a_sensor_upside_down)
{
  write_drive(kOneSensor, mounting_off_by({0, 0, 0, 0, 0, 180 * kDegree}));
  EXPECT_EQ(causes(), only("upside down"));
}

TEST_F(TalusMapHints, poses_upside_down)
{
  Mistakes wrong;
  wrong.pose = [](const CPose3D& T, double) { return T + CPose3D(0, 0, 0, 0, 0, M_PI); };
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("upside down"));
}

TEST_F(TalusMapHints, a_quaternion_in_the_wrong_order)
{
  Mistakes wrong;
  wrong.quaternion_begins_with_w = true;
  wrong.pose = [](const CPose3D& T, double) { return CPose3D(0, 0, 0, M_PI / 2, 0, 0) + T; };
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("is tilted in the map"));
}

TEST_F(TalusMapHints, a_map_frame_that_is_not_level)
{
  Mistakes wrong;
  wrong.pose = [](const CPose3D& T, double) { return CPose3D(0, 0, 0, 0, 0.5, 0) + T; };
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("is tilted in the map"));
}

TEST_F(TalusMapHints, two_sensors_that_see_two_grounds)
{
  Mistakes wrong;
  wrong.mounting = [](const CPose3D& T_base_sensor, const std::string& label)
  { return label == "rear" ? CPose3D(0, 0, 0.3, 0, 0, 0) + T_base_sensor : T_base_sensor; };
  write_drive(kTwoSensors, wrong);
  EXPECT_EQ(causes(), only("two grounds"));
}

TEST_F(TalusMapHints, two_sensors_that_see_one_ground)
{
  write_drive(kTwoSensors);
  EXPECT_EQ(causes(), kNone);
}

TEST_F(TalusMapHints, a_jump_of_the_poses)
{
  Mistakes wrong;
  wrong.pose = [](const CPose3D& T, double time_s)
  { return time_s > 4 ? CPose3D(1.5, 4, 0.2, 0, 0, 0) + T : T; };
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("the poses jump"));
}

TEST_F(TalusMapHints, a_clock_that_is_late)
{
  Mistakes wrong;
  wrong.late_s = 0.3;
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("contradict each other"));
}

TEST_F(TalusMapHints, the_body_of_the_robot_with_the_box_to_paste)
{
  const std::string body = "  body: [{box: {at_m: [-0.4, 0.2, 0.5], size_m: [0.2, 0.3, 0.5]}}]\n";
  write_drive(kOneSensor, {}, kWorld + body);
  const Outcome done = run("drive.rawlog --no-site --output out");
  EXPECT_EQ(causes_in(done.err), only("move with the robot"));
  const std::string begin = "body_boxes_m = ";
  const auto at = done.err.find(begin);
  ASSERT_NE(at, std::string::npos) << done.err;
  const std::string boxes =
      done.err.substr(at + begin.size(), done.err.find('\n', at) - at - begin.size());
  EXPECT_EQ(causes("-s 'body_boxes_m=" + boxes + "'"), kNone) << boxes;
}

TEST_F(TalusMapHints, are_errors_with_strict_and_nothing_is_written)
{
  write_drive();
  const Outcome failed = run("drive.rawlog --strict --output out -s window_m=3");
  EXPECT_EQ(failed.code, 1);
  EXPECT_EQ(causes_in(failed.err), only("outside of the window"));
  EXPECT_TRUE(failed.says("--strict")) << failed.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(TalusMapHints, suggest_prints_a_configuration_and_writes_nothing)
{
  write_drive();
  const std::size_t before = entries();
  const Outcome done = run("drive.rawlog --suggest --quiet -s max_height_m=-2");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(entries(), before);
  write_bytes(path("robot.ini"), done.out);
  const Outcome mapped = run("drive.rawlog --no-site --config robot.ini --output out");
  EXPECT_EQ(mapped.code, 0) << mapped.err;
  EXPECT_EQ(mapped.err, "");
  const auto p = summary("out")["parameters"];
  EXPECT_EQ(p["window_m"], 10) << done.out;
  EXPECT_EQ(p["min_height_m"], -3);
  EXPECT_NEAR(p["clearance_m"], 0.7, 1e-9);
}

TEST_F(TalusMapHints, suggest_takes_one_log)
{
  write_drive();
  EXPECT_EQ(run("drive.rawlog drive.rawlog --suggest").code, 2);
}

TEST_F(TalusMapHints, real_logs_have_none)
{
  const std::string street = real_data("street.rawlog"), parked = real_data("parked.rawlog");
  TALUS_SKIP_WITHOUT(street);
  const std::string car = std::string(" --no-site --output out --config ") + TALUS_SOURCE_DIR +
                          "/datasets/configs/car.ini";
  EXPECT_EQ(run(street + car).err, "");
  EXPECT_EQ(run(parked + " --no-site --output out").err, "");
}
