#pragma once
#include "options.h"

#include <talus/frame.h>
#include <talus/io/packed_log.h>
#include <talus/mrpt/observation_points.h>
#include <talus/point_labels.h>

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace talus::app
{
/** Throws std::runtime_error where a folder has labels that talus-map did not write: those of
 * people would be lost. */
void require_no_foreign_labels(const std::string& folder);

/** What the points of each scan of a log are, written into a folder while the log is mapped.
 *
 * LabelsAs::Kitti: a file a scan, 000000.label and so on, with a number of 32 bits a point in the
 * order of the scan. All scans that were read count; those that the map did not take have zeros.
 * LabelsAs::Rawlog: a log of clouds with the number as intensity, of the scans that were mapped. */
class LabelFiles
{
 public:
  /** Throws std::runtime_error where the log cannot be made. */
  LabelFiles(std::string folder, LabelsAs as);
  ~LabelFiles();
  LabelFiles(const LabelFiles&) = delete;
  LabelFiles& operator=(const LabelFiles&) = delete;

  /** The next scan of the log, and what was read of it. */
  void note_scan(const mrpt::obs::CObservation& obs, const SensorPoints& points);
  /** That scan goes to the map, perhaps as a part of a larger one: write() comes for the scans of
   * each sensor in the order of these calls. */
  void await(std::uint32_t sensor);
  /** Of a scan that is mapped, before it is: what it is made of waits no longer. */
  void begin(const Frame& scan);
  /** Of the scan of begin(). Throws std::runtime_error where it cannot be written. */
  void write(const Frame& scan, const std::vector<PointLabel>& labels);
  /** Writes what is missing, and the table. Throws as write(). */
  void finish();

  /** The points of each label that write() got. */
  const std::array<std::uint64_t, kPointLabelCount>& counts() const { return counts_; }

 private:
  struct Part
  {
    std::size_t scan = 0, size = 0;
    mrpt::system::TTimeStamp stamp;
    std::string sensor_label;
    mrpt::poses::CPose3D T_base_sensor;
  };

  void write_part(
      const Part& part, const Frame& scan, const std::vector<PointLabel>& labels,
      std::size_t first);
  std::string path_of(std::size_t scan) const;

  std::string folder_;
  std::vector<std::uint32_t> sizes_;  //!< of all scans so far
  std::vector<bool> written_;
  Part last_;
  std::map<std::uint32_t, std::deque<Part>> waiting_;  //!< by sensor
  std::vector<Part> begun_;
  std::unique_ptr<io::PackedLog> log_;  //!< null for LabelsAs::Kitti
  std::array<std::uint64_t, kPointLabelCount> counts_{};
};

}  // namespace talus::app
