#pragma once
#include "remake.h"
#include "watched_trajectory.h"

#include <talus/import/scan_stream.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace talus::app
{
/** Records a drive, and makes its map again where better poses become known. */
class Remaker
{
 public:
  /** `folder`: of all that is written. Throws std::runtime_error naming the file, as all do. */
  Remaker(const Options& options, const Settings& settings, const std::string& folder);

  /** Before the scans that they belong to. `jumps`: just before these poses. */
  void add(
      const std::vector<import::StreamPose>& poses, const std::vector<Jump>& jumps, double now_s);
  void add(const import::ImportedScan& scan) { record_.add(scan); }
  /** Of the scans that come now. */
  const io::Trajectory& poses();
  /** Corrected poses that were published. */
  void take_path(const import::StreamPath& path, const std::string& map_frame, double now_s);

  /** Goes on with what is to be done; the map that is right from now on, where one is made. */
  std::unique_ptr<DriveMap> work(double now_s);
  /** Whether something is to be done. */
  bool is_at_work() const { return remake_ || due_s_; }
  bool is_making() const { return remake_ != nullptr; }
  /** Without a rest. */
  void hurry()
  {
    if (due_s_) due_s_ = 0;
    took_s_ = 0;
  }
  /** The occupancy of the map that work() gave. */
  WholeGrid take_whole() { return std::move(whole_); }
  /** Of all poses of the map, see add_to_history(). */
  const Poses& history() const { return history_; }
  /** What a person should know since the last call, and what went wrong. */
  std::vector<std::string> take_news() { return std::exchange(news_, {}); }
  std::vector<std::string> take_errors() { return std::exchange(errors_, {}); }

  /** Leaves undone what is to be done, and ends the record. */
  void close();

 private:
  void ask_for(const std::string& source, double from_s);
  void require_same_time(const Poses& given, const std::string& source) const;
  bool is_news(const Poses& given) const;
  void look_at_file(double now_s);
  void begin(double now_s);
  void go_on();
  std::unique_ptr<DriveMap> end(double now_s);

  const Options& options_;
  const Settings& settings_;
  std::string folder_;
  Record record_;
  std::filesystem::file_time_type resumed_time_;  //!< when that was written
  std::optional<WatchedTrajectory> file_;
  Correction known_;
  std::string source_;  //!< of the newest correction
  std::optional<double> due_s_;  //!< from when on it is to be followed
  double looked_s_ = 0, began_s_ = 0, took_s_ = 0;
  mrpt::poses::CPose3D T_after_;  //!< brings poses that come to where they should be
  Poses recent_, history_;
  std::optional<io::Trajectory> trajectory_;  //!< of recent_
  std::unique_ptr<Remake> remake_;
  WholeGrid whole_;
  Remake::Added added_;  //!< for it
  std::vector<std::string> news_, errors_;
};

}  // namespace talus::app
