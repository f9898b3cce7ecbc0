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

  /** Where it is at a time, with z = 0; it faces where it goes. */
  Pose pose(double time_s) const;
  /** The same with its origin on the ground. */
  Pose on_ground(double time_s, const Ground& ground) const;
  /** Its shapes where it is, map frame. */
  std::vector<Shape> placed(const Pose& T_map_mover) const;
};

/** The robot is raised on the spot, its attitude as it is; it drives on when that is done. */
struct Lift
{
  double time_s = 0;  //!< when it begins, since the start of the drive
  double duration_s = 0;  //!< 0: at once
  double z_m = 0;  //!< negative: it is let down
};

/** The robot and its path, map frame. */
struct RobotSetup
{
  std::vector<Vec3> waypoints;  //!< one or more, z unused; a smooth curve goes through all
  double yaw_rad = 0;  //!< heading where there is only one waypoint
  double speed_mps = 1.0;  //!< along the curve seen from above
  double duration_s = 0;  //!< of the drive; the robot waits at the end of its path
  double wheelbase_m = 0.45, track_m = 0.45;  //!< between the wheels, lengthwise and sideways
  std::vector<Lift> lifts;  //!< ascending in time, one after the other
  std::vector<Shape> body;  //!< what its sensors see of the robot itself, in the frame of its base
};

/** One sensor and how it is mounted. What is not given is the scanner's own. */
struct SensorSetup
{
  std::string name = "lidar";  //!< the label of its scans in a log
  std::string scanner = "RS-LiDAR-16";
  /** The base is on the ground below the middle of the robot. */
  Pose T_base_sensor = pose_from_rpy({0, 0, 0.68}, 0);
  double phase_s = 0;  //!< when its first sweep begins, since the start of the drive
  std::optional<double> noise_m, noise_per_m, dropout, rate_hz, max_range_m;
  bool motion_distortion = false;  //!< points are taken while the robot moves
};

/** How a localisation errs. */
struct PoseErrors
{
  /** From a time on the poses are shifted along the axes of the map, and turned about the point
   * at which the robot was said to be. */
  struct Jump
  {
    double time_s = 0;
    Vec3 shift_m;
    double roll_rad = 0, pitch_rad = 0, yaw_rad = 0;
  };
  std::vector<Jump> jumps;  //!< ascending in time
  Vec3 drift_mps;  //!< along the axes of the map, from the start on
};

/** From a time on the ground is another. */
struct GroundChange
{
  double time_s = 0;
  Ground ground;
};

/** Everything that a world file says. */
struct World
{
  std::string name, description;
  std::uint64_t seed = 1;
  Ground ground;  //!< at the start
  std::vector<GroundChange> ground_changes;  //!< ascending in time
  ShapeTree objects;  //!< what stands still
  std::vector<Shape> decks;  //!< those of the objects that a robot drives on
  std::vector<Mover> movers;
  RobotSetup robot;
  std::vector<SensorSetup> sensors{SensorSetup{}};  //!< one or more
  PoseErrors poses;

  const Ground& ground_at(double time_s) const;
  /** The highest floor at (x, y) and a time that is not above `highest_m`: the top of a deck, or
   * the ground, below which there is no other. */
  double floor_m(double x_m, double y_m, double time_s, double highest_m) const;
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

  /** Replaces `heights_m` by the heights between which the vertical line at (x, y) is inside an
   * object, one entry for each object, from the lowest up. Foliage counts as full, grass is
   * nothing. */
  void column(double x_m, double y_m, std::vector<Span>& heights_m) const;

  const Ground& ground() const { return ground_; }
  /** World::floor_m() at the time of the scene. */
  double floor_m(double x_m, double y_m, double highest_m) const
  {
    return world_.floor_m(x_m, y_m, time_s_, highest_m);
  }

 private:
  const World& world_;
  double time_s_;
  const Ground& ground_;
  std::vector<Shape> movers_;
};

/** Reads a world file. Throws std::runtime_error whose message has the file, the line, the key,
 * what is wrong and what would be right. datasets/README.md describes the format. */
World load_world(const std::string& path);
/** The same from text; `file` is for messages and for finding height images beside it. */
World parse_world(const std::string& text, const std::string& file);

}  // namespace talus::sim
