#pragma once
#include <talus/elevation_mapper.h>

#include <cstddef>
#include <memory>
#include <string>

namespace talus::bench
{
/** All of a drive, kept in tiles. */
class Whole
{
 public:
  virtual ~Whole() = default;
  /** map.update(frame), and what leaves is kept. */
  virtual void update(ElevationMapper& map, const Frame& frame) = 0;
  virtual std::size_t tiles() const = 0;
  virtual double tiles_MB() const = 0;  //!< in memory
  virtual double disk_MB() const = 0;
};

/** `folder`: of the tiles for which there is no memory. Throws std::runtime_error where talus is
 * built without MRPT: then it has no sites. */
std::unique_ptr<Whole> make_whole(double resolution_m, double memory_MB, const std::string& folder);

}  // namespace talus::bench
