#pragma once
#include <mrpt/obs/CObservation.h>
#include <talus/import/scan_source.h>

#include <memory>
#include <optional>
#include <string>

namespace talus::import
{
/** The stamp of a scan as a log keeps it: in steps of 100 ns [s since the epoch]. */
double stamp_in_log_s(double time_s);

/** What a comment at the start of a log says of the intensities of its points, which are other
 * values: the name of these. Nothing where it says nothing of that. */
std::optional<std::string> values_told_by(const std::string& comment);

/** A scan as a log keeps it: a CObservationPointCloud, or, where points have times and no colours,
 * a decoded CObservationVelodyneScan: the one class that keeps them in every version of MRPT. */
mrpt::obs::CObservation::Ptr observation_of(const ImportedScan& scan, bool is_intensity = true);

/** Writes scans, see observation_of(), gz-packed as what talus-sim writes. */
class RawlogWriter
{
 public:
  /** `values`: see SourceOptions. Throws std::runtime_error naming the file. */
  explicit RawlogWriter(const std::string& path, const std::string& values = "");
  ~RawlogWriter();
  RawlogWriter(const RawlogWriter&) = delete;
  RawlogWriter& operator=(const RawlogWriter&) = delete;

  /** Throws std::runtime_error naming the file. */
  void write(const ImportedScan& scan);

  /** Ends the file, and reads it again to see that it is whole. Throws std::runtime_error. */
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::import
