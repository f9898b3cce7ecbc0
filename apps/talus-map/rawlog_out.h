#pragma once
#include "log_mapper.h"

#include <mrpt/io/CFileOutputStream.h>
#include <talus/io/atomic_file.h>

#include <string>

namespace talus::app
{
/** The log again, each scan that was mapped followed by a snapshot of the map
 * (talus::CObservationTraversability): in its sensory frame where the log has frames, else as the
 * next observation. Everything else stays as it was; snapshots of an earlier run are left out. */
class RawlogOut
{
 public:
  /** Throws std::runtime_error when nothing can be written there. */
  RawlogOut(const std::string& path, const std::string& log);
  ~RawlogOut();
  RawlogOut(const RawlogOut&) = delete;
  RawlogOut& operator=(const RawlogOut&) = delete;

  /** Keeps the map as it is, as the snapshot that belongs to the last scan. Throws
   * std::runtime_error. */
  void add(const LogMapper& mapper);

  /** Reads the log once more and writes it with the snapshots. Throws std::runtime_error. */
  void write();

  /** Gives the file its place. Throws std::runtime_error. */
  void commit() { file_.commit(); }

  /** A folder beside the log whose files the copy needs under another name, or empty; and that
   * name. */
  std::string externals() const;
  std::string externals_of_copy() const;

 private:
  [[noreturn]] void fail_to_write(const std::string& reason) const;

  std::string path_, log_;
  io::AtomicFile file_;
  std::string snapshots_path_;
  mrpt::io::CFileOutputStream snapshots_;  //!< label of the scan, snapshot; in turn
  std::size_t snapshots_added_ = 0;
};

}  // namespace talus::app
