#pragma once
// Shared by the specifications of hints: drives told rightly or wrongly, and what talus-map says.
#include <mrpt/poses/CPose3DQuat.h>
#include <talus/sim/drive.h>

#include <cmath>
#include <map>
#include <set>

#include "talus_map_run.h"

namespace talus::test
{
using mrpt::poses::CPose3D;

constexpr double kDegree = M_PI / 180;

/** Gentle ground with a bend of the way, walls, boxes and posts. */
inline constexpr const char* kWorld = R"(
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
inline constexpr const char* kOneSensor = "sensor: {scanner: RS-LiDAR-16, at_m: [0.1, 0, 0.7]}\n";
inline constexpr const char* kTwoSensors = R"(sensors:
  - {name: front, scanner: RS-LiDAR-16, at_m: [0.3, 0, 0.7]}
  - {name: rear, scanner: RS-LiDAR-16, at_m: [-0.3, 0, 0.8], phase_s: 0.05}
)";

inline CPose3D to_mrpt(const Pose& T)
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
  bool points_in_base = false;
  bool points_in_map = false;
  bool quaternion_begins_with_w = false;
  double late_s = 0;  //!< stamps of the scans
};

/** What each hint says of its cause, in its own words. */
inline const std::set<std::string>& all_causes()
{
  static const std::set<std::string> causes{
      "upside down",
      "tilted against the base",
      "is tilted in the map",
      "begin in the ground",
      "two grounds",
      "mounting contradicts",
      "walls that are seen from different positions",
      "drives sideways",
      "the poses jump",
      "contradict each other",
      "min_height_m =",
      "max_height_m =",
      "outside of the window",
      "was seen",
      "move with the robot",
      "the highest ray ahead",
      "poses have no pitch",
      "the clock of the scans",
      "scans are not deskewed",
      "the times of the points run backwards",
  };
  return causes;
}

/** A drive that is generated, mapped, and the causes that talus-map tells of it. */
class HintDrive : public TalusMap
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
    const CommandEnd done = run("drive.rawlog --no-site --output out " + settings);
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
    const CPose3D T_map_base = to_mrpt(drive.T_map_base(frame));
    auto obs = observation_at<mrpt::obs::CObservationPointCloud>(
        kFirstStamp_s + drive.time_s(frame) + wrong.late_s, label);
    auto points = mrpt::maps::CSimplePointsMap::Create();
    for (std::size_t i = 0; i < scan.size(); ++i)
    {
      const mrpt::math::TPoint3D p(scan.x_m[i], scan.y_m[i], scan.z_m[i]);
      const auto told = wrong.points_in_map    ? (T_map_base + T_base_sensor).composePoint(p)
                        : wrong.points_in_base ? T_base_sensor.composePoint(p)
                                               : p;
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
inline Mistakes mounting_off_by(const CPose3D& error)
{
  Mistakes wrong;
  wrong.mounting = [error](const CPose3D& T_base_sensor, const std::string&)
  { return T_base_sensor + error; };
  return wrong;
}
}  // namespace talus::test
