#pragma once
#include "../common/import/rawlog_writer.h"
#include "corrected_poses.h"

#include <cstddef>
#include <fstream>
#include <string>

namespace talus::app
{
/** What reached the map, as a log of which talus-map makes the same map again. */
class Record
{
 public:
  /** The log; its poses go into a file beside it, whose ending is .tum. Throws std::runtime_error
   * naming the file, as all do. */
  explicit Record(const std::string& log);

  void add(const import::ImportedScan& scan);
  /** `used`: as the map has it; `heard`: as it came. */
  void add(const io::Trajectory::Entry& used, const io::Trajectory::Entry& heard);
  std::size_t scans() const { return count_; }

  /** From now on readers find all. */
  void flush();
  const std::string& log() const { return log_; }
  /** The poses as they came; they are no result. */
  std::string heard_tum() const { return log_ + ".heard.tum"; }
  /** For take_poses(). */
  std::string other_tum() const { return log_ + ".other.tum"; }

  /** From now on the map has the poses of other_tum(). */
  void take_poses();
  /** Ends all files. */
  void close();

 private:
  std::string log_, tum_;
  import::RawlogWriter scans_;
  std::ofstream used_, heard_;
  std::size_t count_ = 0;
};

}  // namespace talus::app
