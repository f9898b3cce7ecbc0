#pragma once
#include <mrpt/obs/CObservation.h>
#include <talus/import/scan_source.h>

#include <memory>
#include <string>

namespace talus::import
{
/** The stamp of a scan as a log keeps it: in steps of 100 ns [s since the epoch]. */
double stamp_in_log_s(double time_s);

/** What a comment at the start of a log says of its points. */
struct PointNotes
{
  std::string values;  //!< the name of what the intensities are; "": intensities
  double step = 1, least = 0;  //!< value of a byte: least + step * byte
  Pieces pieces = Pieces::Scans;  //!< what its scans are
  bool is_guess = true;  //!< step: the first scan shows it
  /** All that a byte can mean: "from 0 to 2400". */
  std::string range_text() const;
};
PointNotes notes_from(const std::string& comment);

/** A scan as a log keeps it: a CObservationPointCloud, or, where points have times and no colours,
 * a decoded CObservationVelodyneScan: the one class that keeps them in every version of MRPT. That
 * has bytes for intensities. */
mrpt::obs::CObservation::Ptr observation_of(const ImportedScan& scan, const PointNotes& notes = {});

/** Writes scans, see observation_of(), gz-packed as what talus-sim writes. */
class RawlogWriter
{
 public:
  /** Throws std::runtime_error naming the file. */
  RawlogWriter(const std::string& path, const PointNotes& notes);
  ~RawlogWriter();
  RawlogWriter(const RawlogWriter&) = delete;
  RawlogWriter& operator=(const RawlogWriter&) = delete;

  /** Throws std::runtime_error naming the file. */
  void write(const ImportedScan& scan);

  /** From now on a reader finds all that was written. Throws std::runtime_error. */
  void flush();
  /** Ends the file, and reads it again to see that it is whole. Throws std::runtime_error. */
  void close();

  /** What the bytes of intensities mean. */
  const PointNotes& notes() const;
  /** Whether they should mean something else to hold all that were written: sets what. */
  bool wants(PointNotes& notes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::import
