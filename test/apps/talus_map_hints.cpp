// The command talus-map tells what looks wrongly set: of each wrong configuration its cause and
// nothing else, of sound ones nothing.
#include <mrpt/poses/CPose3DQuat.h>
#include <talus/sim/drive.h>

#include <cmath>
#include <map>
#include <set>

#include "talus_map_run.h"

using namespace talus;
using namespace talus::test;
using mrpt::poses::CPose3D;

namespace
{
constexpr double kDegree = M_PI / 180;

/** Gentle ground with a bend of the way, walls, boxes and posts. */
constexpr const char* kWorld = R"(
seed: 5
ground:
  - plane: {slope_x_deg: 1}
  - sine: {amplitude_m: 0.12, wavelength_m: 5}
  - roughness: {amplitude_m: 0.01, wavelength_m: 0.4, seed: 3}
objects:
  - wall: {from_m: [-4, 4.5], to_m: [14, 5], height_m: 1.5}
  - box: {at_m: [4, -3], size_m: [1.2, 0.8, 0.9], yaw_deg: 20}
  - box: {at_m: [8, 3.4], size_m: [0.6, 0.6, 0.5]}
  - posts: {from_m: [1, -2.5], to_m: [11, -4], count: 4, height_m: 1.2, radius_m: 0.08}
robot:
  path_m: [[0, 0], [4, 0.3], [8, 1.5], [10, 0.5]]
  speed_mps: 1.2
)";
constexpr const char* kOneSensor = "sensor: {scanner: RS-LiDAR-16, at_m: [0.1, 0, 0.7]}\n";
constexpr const char* kTwoSensors = R"(sensors:
  - {name: front, scanner: RS-LiDAR-16, at_m: [0.3, 0, 0.7]}
  - {name: rear, scanner: RS-LiDAR-16, at_m: [-0.3, 0, 0.8], phase_s: 0.05}
)";

CPose3D to_mrpt(const Pose& T)
{
  mrpt::math::CMatrixDouble33 R;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      R(static_cast<int>(r), static_cast<int>(c)) = T.m[4 * r + c];
  return {R, mrpt::math::CMatrixDouble31({T.x(), T.y(), T.z()})};
}

/** What a log is told wrongly. */
struct Mistakes
{
  std::function<CPose3D(const CPose3D& T_base_sensor, const std::string& label)> mounting;
  std::function<CPose3D(const CPose3D& T_map_base, double time_s)> pose;
  bool points_in_base = false;  //!< while the mounting is told as it is
  bool quaternion_begins_with_w = false;
  double late_s = 0;  //!< stamps of the scans
};

/** What each hint says of its cause, in its own words. */
const std::set<std::string>& all_causes()
{
  static const std::set<std::string> causes{"upside down",           "tilted against the base",
                                            "is tilted in the map",  "height of the sensor itself",
                                            "two grounds",           "mounting contradicts",
                                            "the poses jump",        "contradict each other",
                                            "min_height_m =",        "max_height_m =",
                                            "outside of the window", "was seen",
                                            "move with the robot"};
  return causes;
}

class TalusMapHints : public TalusMap
{
 protected:
  void write_drive(
      const std::string& sensors = kOneSensor, const Mistakes& wrong = {},
      const std::string& world_text = kWorld) const
  {
    const sim::World world = sim::parse_world(world_text + sensors, "test.yaml");
    sim::DriveOptions options;
    options.every = 2;
    const sim::Drive drive(world, options);
    Objects objects;
    std::string tum;
    for (int i = 0; i < drive.frames(); ++i)
    {
      objects.push_back(observation(world, drive, i, wrong));
      tum += tum_line(drive, i, wrong);
    }
    write_log(path("drive.rawlog"), objects, Packing::Gz);
    write_bytes(path("drive.tum"), tum);
  }

  /** Maps it; the causes that are told, with how often. */
  std::map<std::string, int> causes(const std::string& settings = "") const
  {
    const Outcome done = run("drive.rawlog --no-site --output out " + settings);
    EXPECT_EQ(done.code, 0) << done.err;
    return causes_in(done.err);
  }

  static std::map<std::string, int> causes_in(const std::string& err)
  {
    std::map<std::string, int> found;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);)
    {
      if (line.find("hint: ") == std::string::npos) continue;
      std::string cause = line;
      for (const auto& known : all_causes())
        if (line.find(known) != std::string::npos) cause = known;
      ++found[cause];
    }
    return found;
  }

  static std::map<std::string, int> only(const std::string& cause) { return {{cause, 1}}; }

 private:
  static mrpt::serialization::CSerializable::Ptr observation(
      const sim::World& world, const sim::Drive& drive, int frame, const Mistakes& wrong)
  {
    const sim::Scan scan = drive.scan(frame);
    const std::string label = world.sensors[drive.sensor(frame)].name;
    const CPose3D T_base_sensor = to_mrpt(drive.T_base_sensor(frame));
    auto obs = observation_at<mrpt::obs::CObservationPointCloud>(
        kFirstStamp_s + drive.time_s(frame) + wrong.late_s, label);
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (std::size_t i = 0; i < scan.size(); ++i)
    {
      const mrpt::math::TPoint3D p(scan.x_m[i], scan.y_m[i], scan.z_m[i]);
      const auto told = wrong.points_in_base ? T_base_sensor.composePoint(p) : p;
      points->insertPoint(
          static_cast<float>(told.x), static_cast<float>(told.y), static_cast<float>(told.z));
    }
    obs->pointcloud = points;
    obs->sensorPose = wrong.mounting ? wrong.mounting(T_base_sensor, label) : T_base_sensor;
    return obs;
  }

  static std::string tum_line(const sim::Drive& drive, int frame, const Mistakes& wrong)
  {
    const double time_s = drive.time_s(frame);
    CPose3D T = to_mrpt(drive.T_map_base(frame));
    if (wrong.pose) T = wrong.pose(T, time_s);
    const mrpt::poses::CPose3DQuat p(T);
    const auto& q = p.quat();
    const std::array<double, 4> order = wrong.quaternion_begins_with_w
                                            ? std::array<double, 4>{q.r(), q.x(), q.y(), q.z()}
                                            : std::array<double, 4>{q.x(), q.y(), q.z(), q.r()};
    return mrpt::format(
        "%.6f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", kFirstStamp_s + time_s, p.x(), p.y(),
        p.z(), order[0], order[1], order[2], order[3]);
  }
};

/** The sensor mounted as said, and off by so much. */
Mistakes mounting_off_by(const CPose3D& error)
{
  Mistakes wrong;
  wrong.mounting = [error](const CPose3D& T_base_sensor, const std::string&)
  { return T_base_sensor + error; };
  return wrong;
}
}  // namespace

TEST_F(TalusMapHints, a_sound_drive_has_none)
{
  write_drive();
  EXPECT_EQ(causes(), (std::map<std::string, int>{}));
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
  EXPECT_EQ(causes(), (std::map<std::string, int>{}));
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
  EXPECT_EQ(causes("-s 'body_boxes_m=" + boxes + "'"), (std::map<std::string, int>{})) << boxes;
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
