#pragma once
#include "corrected_poses.h"
#include "drive_map.h"
#include "options.h"
#include "record.h"
#include "whole_grid.h"

#include <talus/io/rawlog_reader.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <future>
#include <memory>
#include <string>
#include <utility>

namespace talus::app
{
/** Keeps ten poses a second of those that come. */
void add_to_history(const io::Trajectory::Entry& pose, Poses& history);
/** Drops those that are older than scans may be. */
void keep_last(Poses& poses);

/** Makes the map of a record again, with other poses, while the record goes on. */
class Remake
{
 public:
  /** Of a record that has been flushed. `history`: the poses that the map had; `folder`: for tiles
   * that find no room in memory. */
  Remake(
      const Options& options, const Settings& settings, const std::string& folder,
      const Record& record, Correction correction, Poses history);
  /** Ends what it is at. */
  ~Remake();
  Remake(const Remake&) = delete;
  Remake& operator=(const Remake&) = delete;

  /** What a record has got since the last call; at the first one no poses. */
  struct Added
  {
    std::size_t scans = 0;  //!< of all
    Poses heard;  //!< as they came
    double right_from_s = HUGE_VAL;  //!< from when on they are right so
  };
  /** Maps all scans of the record, which has to be flushed. Throws std::runtime_error that says
   * what went wrong. */
  void map(const Added& added);
  /** The same in the background, on one core that nobody else needs. */
  void start(Added added);
  bool is_at_work() const;
  /** Until start() is done. Throws as map(). */
  void wait() { round_.get(); }

  /** What is mapped. */
  std::size_t scans() const { return scans_; }
  /** In the end: the last poses, and what brings those that are still to come to where they should
   * be. */
  const CorrectedPoses& poses() const { return corrected_; }
  /** See add_to_history(). */
  const Poses& history() const { return history_; }
  /** How far poses have moved from where the map had them: "by 1.2 m on average, ...". */
  const std::string& moved_text() const { return moved_text_; }
  /** The occupancy of the map, as far as tiles tell it: to read all takes long. */
  WholeGrid take_whole() { return std::move(whole_); }
  /** The map; its poses are in Record::other_tum(). */
  std::unique_ptr<DriveMap> take_map();

 private:
  void begin();
  void look_at_tiles();
  void add(const io::Trajectory::Entry& pose);

  const Options& options_;
  Settings settings_;
  std::string folder_, log_, heard_tum_, tum_;
  std::uint64_t heard_bytes_;
  Correction correction_;
  Poses history_;
  CorrectedPoses corrected_;
  std::string moved_text_;
  std::unique_ptr<io::RawlogReader> reader_;
  std::unique_ptr<DriveMap> map_;
  WholeGrid whole_{kOccupancy.close_islands_m};
  std::ofstream out_;
  std::size_t scans_ = 0;
  std::atomic<bool> is_stopped_ = false;
  std::future<void> round_;
};

}  // namespace talus::app
