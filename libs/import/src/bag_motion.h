#pragma once
#include <talus/import/scan_source.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bag_clock.h"
#include "bag_clouds.h"
#include "bag_frames.h"
#include "bag_reader.h"
#include "bag_topics.h"
#include "point_times.h"

namespace talus::import
{
/** Points that the last message may have by its bytes in the file. */
std::uint64_t most_points(const BagReader& reader);

/** Where sensors are mounted and where the base was: all that a bag says of frames and poses, read
 * ahead of the scans, as it may come after them; and which of its clouds are scans. */
class BagMotion
{
 public:
  /** Reads the bag once, without most points. Throws std::runtime_error that names the file and
   * what is wrong; for a frame in `options` that is not there: those that are. */
  BagMotion(
      BagReader& reader, const std::vector<BagRole>& roles, const SourceOptions& options,
      const std::string& path);

  /** Nothing where the chain of frames is not known at that time. Identity, and a remark, where
   * there is none. */
  std::optional<mrpt::poses::CPose3D> T_base_sensor(
      const std::string& sensor_frame, std::int64_t stamp_ns);

  const io::Trajectory& poses() const { return poses_; }
  /** Topics whose clouds are no scans, but maps of a SLAM, or those of another topic once more. */
  const std::vector<std::size_t>& left_out() const { return left_out_; }
  /** How the times of its points are read. */
  const PointClock& clock(std::size_t topic) const;
  /** Whether the bytes of its clouds have another order than these say. */
  bool is_of_other_order(std::size_t topic) const;
  /** By topic: where the sensor has points that gave no return. */
  std::map<std::size_t, std::vector<std::array<double, 3>>> no_returns() const;
  /** Of what poses() are made of. */
  const StampOffsets& pose_offsets() const { return pose_offsets_; }
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  /** Poses in histories before those that are not needed are dropped. */
  static constexpr std::size_t kPruneAt = 100000;

  struct PoseTopic
  {
    std::size_t topic = 0;
    std::string map, child;  //!< frames
    PoseHistory history;
    std::size_t count = 0;
    StampOffsets offsets;
    bool is_path = false;  //!< each message has all poses up to it
  };

  struct CloudTopic
  {
    std::size_t topic = 0;
    std::string frame;  //!< of its first cloud
    std::size_t count = 0, points = 0, hash = 0;  //!< clouds, and of the last one
    bool grows = true;  //!< each cloud is that before it, or has more points
    bool needs_look = true;
    bool is_of_other_order = false;  //!< of bytes, than it says
    NoReturns no_returns;
    PointClock clock;
    FirstClouds first;
  };

  void read(BagReader& reader, const std::vector<BagRole>& roles);
  void read_message(BagReader& reader, const BagMessage& message, BagRole role);
  void add_cloud(BagReader& reader, const BagMessage& message, std::string_view payload);
  void add_links(std::string_view payload, const BagMessage& message, bool is_static);
  void add_pose(const BagMessage& message, FrameTransform pose);
  void add_path(const BagMessage& message, std::string_view payload);
  PoseTopic& pose_topic(std::size_t topic, const FrameTransform& pose);
  void set_time(MessageHeader& header, const BagMessage& message) const;
  void require_room(const BagReader& reader);
  void prune(bool is_full);
  void choose_base(const SourceOptions& options, const std::string& path);
  void choose_map(const SourceOptions& options, const std::string& path);
  void choose_poses(BagReader& reader, const SourceOptions& options);
  bool take_from_tf();
  void take_from(const PoseTopic& topic, const BagReader& reader);
  const PoseTopic* named_topic(BagReader& reader, const SourceOptions& options) const;
  std::string topics_text(BagReader& reader) const;
  [[noreturn]] void fail_without(
      const std::string& frame, const std::string& option, const std::string& path) const;
  bool is_fixed(const std::string& frame) const;
  bool has_moved() const;
  bool is_left_out(std::size_t topic) const;
  void leave_out(std::size_t topic, const BagReader& reader, const std::string& why);
  void find_maps(const BagReader& reader, const SourceOptions& options);
  void find_copies(const BagReader& reader, const SourceOptions& options);
  void remark(const std::string& text) { remarks_.push_back(text); }

  FrameTree tree_;
  std::vector<PoseTopic> pose_topics_;
  std::vector<CloudTopic> cloud_topics_;
  std::size_t clouds_left_ = 0;  //!< topics whose frame is not known yet
  std::size_t prune_at_ = kPruneAt;
  std::size_t poses_held_ = 0;  //!< in the histories of pose_topics_
  bool recorded_times_ = false;
  std::size_t bad_poses_ = 0;
  std::string base_, map_;
  std::vector<std::size_t> left_out_;
  io::Trajectory poses_;
  StampOffsets tf_offsets_, pose_offsets_;
  std::vector<std::string> remarks_;
  std::set<std::string> reported_frames_;
};

}  // namespace talus::import
