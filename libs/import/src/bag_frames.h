#pragma once
#include <mrpt/math/TPose3DQuat.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bag_messages.h"

namespace talus::import
{
struct StampedPose
{
  std::int64_t stamp_ns = 0;
  mrpt::math::TPose3DQuat pose;
};

/** For messages: "map, odom"; a few of many. */
std::string listed(const std::vector<std::string>& names);

/** Whether `frame` is `name` of some robot: "robot1/base_link". */
bool is_of_robot(const std::string& frame, const std::string& name);

/** Poses over time, little memory each; of those that come faster than 200 Hz not all. */
class PoseHistory
{
 public:
  /** False: it is not kept. */
  bool add(std::int64_t stamp_ns, const mrpt::math::TPose3DQuat& pose);
  /** In order of time; before the next two are asked for. */
  void sort();
  /** Interpolated; nothing more than 0.1 s outside of the history, unless all of it is one pose: a
   * mounting that is published now and then, or late. */
  std::optional<mrpt::poses::CPose3D> at(std::int64_t stamp_ns) const;
  const std::vector<StampedPose>& all() const { return all_; }
  void clear() { all_ = {}; }
  /** Of a sorted one. */
  void forget_before(std::int64_t stamp_ns);

 private:
  std::vector<StampedPose> all_;
  bool is_constant_ = false;
};

/** The frames of TF: each below one parent, at a place that is fixed or moves. */
class FrameTree
{
 public:
  /** Of a frame with two parents the first counts; which ones: conflicts(). Throws CdrError where
   * there are more frames than any robot has. */
  void add(const FrameTransform& transform, bool is_static);
  void sort();

  /** Drops the histories of long ones that lie on no chain from these frames to the root. */
  void keep_chains_of(const std::vector<std::string>& frames);
  /** Poses in all histories. */
  std::size_t size() const { return size_; }
  /** Of sorted ones. */
  void forget_before(std::int64_t stamp_ns);

  bool has(const std::string& frame) const;
  std::vector<std::string> frames() const;
  /** The first frame that has one of the names; else the only one of some robot's,
   * "robot1/base_link". Empty: none. */
  std::string named(const std::vector<std::string>& names) const;
  bool connects(const std::string& a, const std::string& b) const;
  /** The frame whose parent is `parent`, on the chain from there to `frame`; empty: none. */
  std::string child_towards(const std::string& parent, const std::string& frame) const;

  /** Nothing where no chain connects them, or one of its links is not known at that time. */
  std::optional<mrpt::poses::CPose3D> T_between(
      const std::string& from, const std::string& to, std::int64_t stamp_ns) const;

  /** The times at which the chain moves: those of the link with the most poses. */
  std::vector<std::int64_t> times_between(const std::string& from, const std::string& to) const;
  /** Until when all of its moving links are known; nothing where none moves. */
  std::optional<std::int64_t> known_until(const std::string& from, const std::string& to) const;

  /** Frames with two parents. */
  const std::set<std::string>& conflicts() const { return conflicts_; }

 private:
  struct Link
  {
    std::string parent;
    std::optional<mrpt::poses::CPose3D> fixed;
    PoseHistory moving;
  };
  using Chain = std::vector<const Link*>;
  Chain chain_to_root(const std::string& frame) const;
  /** Without what both have in common at the root's end; nothing where they are not connected. */
  std::optional<std::pair<Chain, Chain>> chains(const std::string& a, const std::string& b) const;
  static std::optional<mrpt::poses::CPose3D> T_along(const Chain& chain, std::int64_t stamp_ns);

  std::map<std::string, Link> links_;  //!< by the child
  std::set<std::string> conflicts_;
  std::size_t size_ = 0;
};

}  // namespace talus::import
