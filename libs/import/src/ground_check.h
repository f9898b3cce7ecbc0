#pragma once
#include <talus/import/scan_source.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace talus::import
{
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
