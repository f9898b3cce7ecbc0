#pragma once
#include <mrpt/serialization/CArchive.h>
#include <talus/site/floor_map.h>
#include <talus/site/site.h>
#include <talus/site/site_mapper.h>
#include <talus/live_map.h>

#include <string>

#include "stream_reader.h"

namespace talus
{
/** All that a map has seen, beyond its window too, where it keeps the whole. */
class WholeMap
{
 public:
  explicit WholeMap(double resolution_m);
  WholeMap(const WholeMap& o);
  WholeMap& operator=(const WholeMap&) = delete;
  ~WholeMap() = default;

  /** Takes a frame into the map and keeps what leaves its window. */
  FrameReport update(ElevationMapper& map, const Frame& frame);

  /** The floor where the robot is, the window of `map` included. As it is until the next frame. */
  const MapSnapshot& floor(const ElevationMapper& map);
  void forget_floor() { shown_ = nullptr; }

  /** The site, the window of `map` included. */
  site::Site& site(const ElevationMapper& map);
  /** The same, and corrected everywhere by what came later: for a file. */
  site::Site& site_in_hindsight(const ElevationMapper& map);
  /** Whether it began with a map of before. */
  bool is_loaded() const { return loaded_; }
  /** Reads what was kept before, a file of each floor. Throws std::runtime_error. */
  void load(const std::string& path);

  void write(const ElevationMapper& map, mrpt::serialization::CArchive& out);
  /** Throws as StreamReader. */
  void read(detail::StreamReader& in);

 private:
  site::Site site_;
  site::SiteMapper mapper_;
  bool loaded_ = false;
  site::FloorMap floor_map_;
  const MapSnapshot* shown_ = nullptr;  //!< null: the map has changed since
};
}  // namespace talus
