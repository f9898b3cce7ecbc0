#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace talus::import
{
/** What became of the clouds of a stream. */
struct StreamCounts
{
  std::size_t scans = 0;  //!< that came out
  std::size_t without_times = 0;  //!< of these: the poses ended before the last of their points
  std::size_t late = 0;  //!< left out: no pose or mounting came in time
  std::size_t dropped = 0;  //!< left out: they came faster than they were taken
  std::size_t missing = 0;  //!< did not come, by the stamps of others
  std::size_t stale = 0;  //!< left out: not newer than the scan before of the same sensor
  std::size_t refused = 0;  //!< left out: damaged, or not readable as a scan
};

/** Of the base in the map. */
struct StreamPose : io::Trajectory::Entry
{
  /** Where the odometry is, which drifts and does not jump: the identity where TF has no frame
   * between map and base. */
  mrpt::poses::CPose3D T_map_odom;
};

/** A nav_msgs/Path. */
struct StreamPath
{
  std::string frame;  //!< of its poses
  std::vector<io::Trajectory::Entry> poses;  //!< those with a time
};
/** Throws std::runtime_error that says how it is damaged. */
StreamPath path_from(std::string_view message);
/** "nav_msgs/msg/Path". */
bool is_path(const std::string& type);

/** Scans of a robot that is running: messages of ROS 2 go in as they come, and scans come out once
 * the poses of their time are known. Clouds, frames and times are read as those of a bag, but
 * nothing is known ahead: a sensor whose mounting is not known gives no scan. */
class ScanStream
{
 public:
  /** `max_wait_s`: how long a cloud waits for its poses. Of the options those of bags count. */
  ScanStream(const SourceOptions& options, double max_wait_s);
  ~ScanStream();

  /** Whether messages of such a topic are of use. */
  static bool reads(const std::string& topic, const std::string& type);
  /** Whether they are clouds. */
  static bool is_cloud(const std::string& type);
  /** Whether a topic of clouds still is: maps, and copies of what another topic has, are not. */
  bool wants(const std::string& topic) const;

  /** Takes a message. `now_s`: when it came, seconds since the epoch. What is damaged is counted
   * and reported. */
  void add(
      const std::string& topic, const std::string& type, std::string_view message, double now_s);

  /** The next scan in the order in which they came; false: none has its poses yet. */
  bool next(ImportedScan& scan, double now_s);

  /** No more messages will come: what waits need not wait for poses after its own. */
  void end();

  /** Of the base in the map, of the last seconds; they cover the scan that came out last, as those
   * of a TUM file with what take_new_poses() gives do. */
  const io::Trajectory& poses() const;
  /** Those that came since the last call, as they are read from a TUM file. */
  std::vector<StreamPose> take_new_poses();

  /** The frame of the poses; empty: not known yet. */
  const std::string& map_frame() const;
  /** So far. */
  StreamCounts counts() const;
  /** Of the last cloud that was late, with the remedy; empty: none was. */
  std::string why_late() const;
  /** What a person should know, each once, since the last call. */
  std::vector<std::string> take_news();
  /** Why there are no poses or no scans, with the remedy; empty: there are. */
  std::string why_nothing() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::import
