#pragma once
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CSerializable.h>
#include <talus/io/trajectory.h>

#include <cstdint>
#include <memory>
#include <string>

namespace talus::io
{
/** Reads a rawlog (plain, gz or zstd, observation-only or action/sensory-frame format, external
 * files included), or the key frames of a simplemap, front to back, one observation at a time. Not
 * thread safe, nor are two readers of logs with external files at once: where such files lie is a
 * global of MRPT. */
class RawlogReader
{
 public:
  /** Throws std::runtime_error that names the file and says what is wrong and what to do: missing,
   * a directory, empty, not a rawlog. */
  explicit RawlogReader(const std::string& path);
  ~RawlogReader();
  RawlogReader(const RawlogReader&) = delete;
  RawlogReader& operator=(const RawlogReader&) = delete;

  /** The next observation, or nullptr at the end of the log, unless it grows by whole parts as of
   * PackedLog::flush(); those of a sensory frame one by one.
   * Externally stored points and depth images are loaded. Throws std::runtime_error naming the file
   * and the byte offset (after decompression) of the object that cannot be read, or saying that gz
   * or zstd data is cut short or damaged: what was read of a log is sure at its end only. */
  mrpt::obs::CObservation::Ptr next();

  /** The text that describes the log, its first CObservationComment; empty where it does not begin
   * with one. */
  const std::string& description() const;

  /** Fraction of the log read so far, 0..1, for progress bars. */
  double progress() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** How many bytes there are of which the objects of a log, or another file of MRPT, can be made:
 * its own, 250 for each where it is packed, and those of the folder with its external files. 0
 * where there is no such file. */
std::uint64_t bytes_of_log(const std::string& path);

/** The poses that a log holds itself: of key frames, else CObservationRobotPose, else
 * CObservationOdometry, else its action pairs (odometry integrated from the origin), in that order
 * of preference; of several labels the one with the most poses. Poses that are not finite are left
 * out. `source` gets a few words for messages. Empty when the log has none. Throws as RawlogReader.
 */
Trajectory trajectory_from_rawlog(const std::string& path, std::string* source = nullptr);

/** The objects of a rawlog (plain, gz or zstd) one after the other, whatever their class. */
class RawlogStream
{
 public:
  /** Throws std::runtime_error that names the file, what is wrong and what to do. */
  explicit RawlogStream(const std::string& path);
  ~RawlogStream();

  /** The next object, or nullptr at the end, where packed data has been compared with its checksum.
   * Throws std::runtime_error naming the file and the byte offset (after unpacking) at which the
   * object begins, or, of packed data that is cut short or damaged, where it is that. */
  mrpt::serialization::CSerializable::Ptr next();

  /** Throws std::runtime_error: `what` is wrong with the object that next() returned last. */
  [[noreturn]] void fail(const std::string& what) const;

  /** Fraction of the data read so far, 0..1. */
  double progress() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::io
