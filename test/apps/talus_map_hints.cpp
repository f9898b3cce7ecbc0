// The command talus-map tells what looks wrongly set: of each wrong configuration its cause and
// nothing else, of sound ones nothing.
#include "hint_drive.h"

using namespace talus;
using namespace talus::test;

namespace
{
const std::map<std::string, int> kNone;

/** A room with a table ahead, whose board is 3 cm thick. */
constexpr const char* kCanteen = R"(
ground: [plane: {}]
objects:
  - wall: {from_m: [-2, -4], to_m: [12, -4], height_m: 2.6}
  - wall: {from_m: [-2, 4], to_m: [12, 4], height_m: 2.6}
  - wall: {from_m: [-2, -4], to_m: [-2, 4], height_m: 2.6}
  - wall: {from_m: [12, -4], to_m: [12, 4], height_m: 2.6}
  - table: {at_m: [4, 0], size_m: [0.8, 1.6, 0.78], thickness_m: 0.03}
robot: {path_m: [[0, 0], [2.5, 0], [4.5, 2.6]], speed_mps: 1}
)";

CPose3D at_its_origin(const CPose3D&, const std::string&) { return {}; }

class TalusMapHints : public HintDrive
{
};
}  // namespace

TEST_F(TalusMapHints, name_the_parameter_that_is_wrong_and_nothing_of_a_sound_drive)
{
  write_drive();
  EXPECT_EQ(causes(), kNone);
  EXPECT_TRUE(summary("out")["hints"].empty());
  for (const auto& [settings, cause] : std::map<std::string, std::string>{
           {"-s min_height_m=-0.5", "min_height_m ="},
           {"-s max_height_m=-0.75", "max_height_m ="},
           {"-s window_m=3", "outside of the window"},
           {"-s window_m=100 -s resolution_m=0.2 -s max_range_m=8", "was seen"}})
    EXPECT_EQ(causes(settings), only(cause)) << settings;
  runs("drive.rawlog --no-site --strict --output sound");
  const CommandEnd failed = run("drive.rawlog --strict --output strict -s window_m=3");
  EXPECT_EQ(failed.code, 1);
  EXPECT_EQ(causes_in(failed.err), only("outside of the window"));
  EXPECT_TRUE(failed.says("--strict")) << failed.err;
  EXPECT_FALSE(exists("strict"));
  fails("drive.rawlog drive.rawlog --suggest", 2, {});
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
  const CommandEnd done = run("drive.rawlog --no-site --output out");
  EXPECT_EQ(causes_in(done.err), only("outside of the window"));
  EXPECT_TRUE(done.says("the ground begins 4.5 m from the sensor")) << done.err;
  EXPECT_EQ(causes("-s window_m=18"), kNone);
  write_bytes(path("robot.ini"), run("drive.rawlog --suggest").out);
  EXPECT_EQ(causes("--config robot.ini"), kNone);
  EXPECT_GE(summary("out")["parameters"]["window_m"], 12);
}

TEST_F(TalusMapHints, points_in_the_frame_of_the_base_or_of_the_map)
{
  Mistakes wrong;
  wrong.points_in_base = true;
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("begin in the ground")) << "with the mounting told as it is";
  wrong.mounting = at_its_origin;
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes(), only("begin in the ground"));
  wrong.points_in_base = false;
  wrong.points_in_map = true;
  write_drive(kOneSensor, wrong);
  EXPECT_EQ(causes("--static"), only("begin in the ground"));
  write_drive("sensor: {scanner: RS-LiDAR-16, at_m: [0.1, 0, 0.1]}\n");
  EXPECT_EQ(causes(), kNone) << "a sensor at a tenth of a metre is not in the ground";
}

TEST_F(TalusMapHints, a_sensor_that_does_not_see_what_is_as_high_as_the_robot)
{
  const auto at = [](const std::string& scanner, double height_m, int pitch_deg)
  {
    return "sensor: {scanner: " + scanner + ", at_m: [0, 0, " + std::to_string(height_m) +
           "], roll_pitch_yaw_deg: [0, " + std::to_string(pitch_deg) + ", 0]}\n";
  };
  const std::string settings = "-s clearance_m=0.8";
  write_drive(at("RS-LiDAR-16", 0.68, 20), {}, kCanteen);
  const CommandEnd done = run("drive.rawlog --no-site --output out " + settings);
  EXPECT_EQ(causes_in(done.err), only("the highest ray ahead"));
  EXPECT_TRUE(done.says("looks 5 degrees down from 0.68 m")) << done.err;
  EXPECT_TRUE(done.says("and 0.80 m is seen")) << done.err;
  EXPECT_SAYS(run("drive.rawlog --suggest").out, "seen nowhere");
  EXPECT_EQ(causes("-s clearance_m=0.55"), kNone) << "a lower robot";
  for (const auto& sensor :
       {at("RS-LiDAR-16", 0.68, 0), at("OS0-128", 0.68, 20), at("RS-LiDAR-16", 1.0, 20)})
  {
    write_drive(sensor, {}, kCanteen);
    EXPECT_EQ(causes(settings), kNone) << sensor;
  }
}

TEST_F(TalusMapHints, a_level_sensor_in_an_empty_field_may_see_what_is_high)
{
  // Beams above the horizon exist, and only a building far aside returns any.
  const std::string field = "ground: [plane: {}]\nrobot: {path_m: [[0, 0], [9, 0]]}\n";
  const std::string building = "objects: [box: {at_m: [5, 70], size_m: [20, 5, 12]}]\n";
  for (const auto& world : {field, field + building})
  {
    write_drive(kOneSensor, {}, world);
    EXPECT_EQ(causes("-s clearance_m=0.8"), kNone) << world;
    EXPECT_EQ(causes("-s clearance_m=0.8 -s max_range_m=8"), kNone) << world << "cut";
  }
}

TEST_F(TalusMapHints, a_mounting_that_is_not_where_the_sensor_is)
{
  for (const auto& [off, cause] : std::vector<std::pair<CPose3D, std::string>>{
           {{0, 0, 0.45, 0, 0, 0}, "mounting contradicts"},
           {{0, 0, 0, 0, 12 * kDegree, 0}, "mounting contradicts"},
           {{0, 0, 0, 0, 0, 35 * kDegree}, "tilted against the base"},
           {{0, 0, 0, 0, 0, 180 * kDegree}, "upside down"}})
  {
    write_drive(kOneSensor, mounting_off_by(off));
    EXPECT_EQ(causes(), only(cause)) << off;
  }
  Mistakes wrong;
  wrong.mounting = [](const CPose3D& T_base_sensor, const std::string& label)
  { return label == "rear" ? CPose3D(0, 0, 0.3, 0, 0, 0) + T_base_sensor : T_base_sensor; };
  write_drive(kTwoSensors, wrong);
  EXPECT_EQ(causes(), only("two grounds"));
  write_drive(kTwoSensors);
  EXPECT_EQ(causes(), kNone);
}

TEST_F(TalusMapHints, poses_that_are_turned_jump_or_are_late)
{
  const auto with_pose = [](const std::function<CPose3D(const CPose3D&, double)>& pose)
  {
    Mistakes wrong;
    wrong.pose = pose;
    return wrong;
  };
  Mistakes quaternion =
      with_pose([](const CPose3D& T, double) { return CPose3D(0, 0, 0, M_PI / 2, 0, 0) + T; });
  quaternion.quaternion_begins_with_w = true;
  Mistakes late;
  late.late_s = 0.3;
  for (const auto& [wrong, cause] :
       std::vector<std::pair<Mistakes, std::string>>{
           {with_pose([](const CPose3D&T, double) { return T + CPose3D(0, 0, 0, 0, 0, M_PI); }),
            "upside down"},
           {quaternion, "is tilted in the map"},
           {with_pose([](const CPose3D&T, double) { return CPose3D(0, 0, 0, 0, 0.5, 0) + T; }),
            "is tilted in the map"},
           {with_pose([](const CPose3D&T, double time_s)
                      { return time_s > 4 ? CPose3D(1.5, 4, 0.2, 0, 0, 0) + T : T; }),
            "the poses jump"},
           {late, "contradict each other"}})
  {
    write_drive(kOneSensor, wrong);
    EXPECT_EQ(causes(), only(cause));
  }
}

TEST_F(TalusMapHints, the_body_of_the_robot_with_the_box_to_paste)
{
  const std::string body = "  body: [{box: {at_m: [-0.4, 0.2, 0.5], size_m: [0.2, 0.3, 0.5]}}]\n";
  write_drive(kOneSensor, {}, kWorld + body);
  const CommandEnd done = run("drive.rawlog --no-site --output out");
  EXPECT_EQ(causes_in(done.err), only("move with the robot"));
  const std::string begin = "body_boxes_m = ";
  const auto at = done.err.find(begin);
  ASSERT_NE(at, std::string::npos) << done.err;
  const std::string boxes =
      done.err.substr(at + begin.size(), done.err.find('\n', at) - at - begin.size());
  EXPECT_EQ(causes("-s 'body_boxes_m=" + boxes + "'"), kNone) << boxes;
}

TEST_F(TalusMapHints, suggest_prints_a_configuration_and_writes_nothing)
{
  write_drive();
  const std::size_t before = entries();
  const CommandEnd done = runs("drive.rawlog --suggest --quiet -s max_height_m=-2");
  EXPECT_EQ(entries(), before);
  write_bytes(path("robot.ini"), done.out);
  const CommandEnd mapped = runs("drive.rawlog --no-site --config robot.ini --output out");
  EXPECT_EQ(mapped.err, "");
  const auto p = summary("out")["parameters"];
  EXPECT_EQ(p["window_m"], 10) << done.out;
  EXPECT_EQ(p["min_height_m"], -3);
  EXPECT_NEAR(p["clearance_m"], 0.7, 1e-9);
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
