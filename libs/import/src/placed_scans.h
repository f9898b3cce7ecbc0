#pragma once
#include <talus/import/scan_source.h>

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace talus::import
{
/** Scans and poses of a source in the frames of a log, whatever frames the source has them in:
 * points in that of the sensor (--clouds-in map, world coordinates), poses of the base (--poses-of
 * sensor). Warns of what contradicts what it reads. `path` names the source in messages;
 * `mounted_by_tf`: its mountings are those of the frames of the clouds. */
std::unique_ptr<ScanSource> place_scans(
    std::unique_ptr<ScanSource> source, const std::string& path, const SourceOptions& options,
    bool mounted_by_tf);

/** Whether the points are so far away that no sensor is at their origin. */
bool is_in_world(const ImportedScan& scan);

/** Points in the map frame become points in the frame of the sensor; in double precision. */
void bring_to_sensor(const mrpt::poses::CPose3D& T_map_sensor, ImportedScan& scan);

/** Of points in world coordinates the ground below their middle: in whole metres, its height in
 * centimetres, not turned. There is one point at least. */
mrpt::poses::CPose3D base_below(const ImportedScan& scan);

/** The median of how far the points are from a place in their frame; 0 without points. */
double median_range_m(const ImportedScan& scan, const std::array<double, 3>& from_m);

/** Holds the mountings of sensors against the ground that their scans show. */
class GroundCheck
{
 public:
  /** A scan in the frame of its sensor. */
  void look_at(const ImportedScan& scan);

  /** A sentence for each sensor whose mounting puts the ground elsewhere than at the base. */
  std::vector<std::string> remarks() const;

 private:
  struct Sensor
  {
    std::size_t scans = 0;
    mrpt::poses::CPose3D T_base_sensor;  //!< of the first scan
    std::vector<double> ground_m;  //!< height of the ground in the base, of scans that show any
  };
  std::map<std::string, Sensor> sensors_;
};

}  // namespace talus::import
