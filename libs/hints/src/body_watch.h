#pragma once
#include <talus/parameters.h>

#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

#include "near_ground.h"

namespace talus::hints
{
/** Looks for what moves with the robot: it is at the same place of the base frame wherever the
 * robot is, and leaves nothing behind in the map. What stands along the path (walls of a corridor)
 * can be at the same place of the base too, but stays in the map when the robot has gone on.
 *
 * Two things that are no body do both: a pane of glass that only returns rays near its normal, and
 * a person who follows. They differ by the reach of a robot, by the ground that is seen
 * before them, and by turns: the body alone stays in its place when the robot changes direction. */
class BodyWatch
{
 public:
  /** Whether a frame with this pose would be looked at: the robot has moved on. */
  bool wants(const Pose& T_map_base) const;

  /** `near`: all points in reach, in the frame of the base; `ground`: where it lies there. To be
   * called before add() with the same frame. */
  void add_ground(const std::vector<Vec3>& near, const NearPlane& ground, const Vec3& sensor)
  {
    before_.add(near, ground, sensor);
  }
  /** `near`: points in reach that are not ground; `all`: a sample of the frame; both in the frame
   * of the base. */
  void add(const std::vector<Vec3>& near, const std::vector<Vec3>& all, const Pose& T_map_base);

  /** Whether the robot has driven and turned enough: at rest nothing separates its body from who
   * stands beside it. */
  bool is_conclusive() const;
  /** Boxes around what moves with the robot, frame of the base [m], the one with most points first;
   * none where nothing shows it. `ground`: where it lies in that frame; `sensor`: where it is
   * mounted. */
  std::vector<BodyBox> boxes(const NearPlane& ground, const Vec3& sensor) const;

  /** Driven while it looked [m]; it looks at the first frames only. */
  double path_m() const { return path_m_; }

 private:
  struct Voxel
  {
    std::uint64_t frames = 0;  //!< a bit for each that hit it
    std::uint32_t points = 0;
  };
  using Key = std::uint64_t;
  using Part = std::vector<Key>;  //!< voxels that touch
  std::vector<Part> parts(const NearPlane& ground) const;
  bool moves_along(const Part& part) const;
  bool is_hit_always(const Part& part) const;
  bool is_in_reach(const Part& part, const Vec3& sensor, double height_m) const;
  bool stands_apart(const Part& part, const Vec3& sensor) const;
  Vec3 mean_place(const std::set<Key>& around, std::uint64_t frames) const;
  bool keeps_its_place(const Part& part) const;
  std::uint64_t far_frames(std::size_t frame, double least_m) const;
  bool stays(const Vec3& at_map, std::uint64_t frames) const;

  GroundBefore before_;
  std::vector<Pose> poses_;
  double path_m_ = 0;
  std::unordered_map<Key, Voxel> body_;  //!< by place in the base frame
  std::unordered_map<Key, std::uint64_t> map_;  //!< by place in the map: frames that hit it
};

}  // namespace talus::hints
