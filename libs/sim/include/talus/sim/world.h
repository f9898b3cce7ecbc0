#pragma once
#include <talus/sim/ground.h>
#include <talus/sim/shapes.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace talus::sim
{
/** Something that moves: its shapes stand on the ground wherever it is. */
struct Mover
{
  /** It is at (x, y) at that time; between stops it goes straight, before the first and after the
   * last it stands. */
  struct Stop
  {
    double time_s = 0;  //!< since the start of the drive
    double x_m = 0, y_m = 0;
  };
  std::vector<Shape> shapes;  //!< in its own frame: x forward, z up, origin on the ground
  std::vector<Stop> path;  //!< one or more, ascending in time

  /** Where it is at a time, with z = 0; it faces the way it goes. */
  Pose pose(double time_s) const;
  /** The same with its origin on the ground. */
  Pose on_ground(double time_s, const Ground& ground) const;
  /** Its shapes where it is, map frame. */
  std::vector<Shape> placed(const Pose& T_map_mover) const;
};

/** The robot and its way, map frame. */
struct RobotSetup
{
  std::vector<Vec3> waypoints;  //!< one or more, z unused; a smooth curve goes through all
  double yaw_rad = 0;  //!< heading where there is only one waypoint
  double speed_mps = 1.0;  //!< along the curve seen from above
  double duration_s = 0;  //!< of the drive; the robot waits at the end of its way
  double wheelbase_m = 0.45, track_m = 0.45;  //!< between the wheels, lengthwise and sideways
};

/** The sensor and how it is mounted. What is not given is the scanner's own. */
struct SensorSetup
{
  std::string scanner = "RS-LiDAR-16";
  Pose T_base_sensor;  //!< the base is on the ground below the middle of the robot
  std::optional<double> noise_m, noise_per_m, dropout, rate_hz, max_range_m;
  bool motion_distortion = false;  //!< points are taken while the robot moves
};

/** Everything that a world file says. */
struct World
{
  std::string name, description;
  std::uint64_t seed = 1;
  Ground ground;
  ShapeTree objects;  //!< what stands still
  std::vector<Mover> movers;
  RobotSetup robot;
  SensorSetup sensor;
};

/** A world at one time. Keeps a reference to the world. */
class Scene
{
 public:
  Scene(const World& world, double time_s, bool with_movers = true);

  /** What a ray meets first. */
  struct Hit
  {
    double range_m = 0;
    double reflectivity = 0;  //!< [0,1]
    const Shape* shape = nullptr;  //!< nullptr: the ground
  };
  /** Nothing within `max_m`: no hit. `chance`, any hash of the ray, decides how deep it goes into
   * foliage. */
  std::optional<Hit> cast(const Ray& ray, double max_m, std::uint64_t chance = 0) const;

  /** Replaces `heights_m` by the heights between which the vertical line at a place is inside an
   * object, one entry for each object, from the lowest up. Foliage counts as full. */
  void column(double x_m, double y_m, std::vector<Span>& heights_m) const;

 private:
  const World& world_;
  std::vector<Shape> movers_;
};

/** Reads a world file. Throws std::runtime_error whose message has the file, the line, the key,
 * what is wrong and what would be right. datasets/README.md describes the format. */
World load_world(const std::string& path);
/** The same from text; `file` is for messages and for finding height images beside it. */
World parse_world(const std::string& text, const std::string& file);

}  // namespace talus::sim
