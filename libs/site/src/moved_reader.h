#pragma once
#include "site_reader.h"

#include <talus/site/map_shift.h>

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace talus::site
{
/** A file of a site, moved: heights change by exactly what they are told; where cells come to other
 * places, each is the one of the file that lies nearest. */
class MovedReader
{
 public:
  /** Throws as SiteReader. */
  MovedReader(const std::string& path, const MapShift& shift);

  const SiteReader& file() const { return file_; }
  /** As of floor `floor`, moved. */
  Ways ways(int floor) const;
  /** The tiles that may have a known cell. */
  std::vector<SiteReader::Place> tiles() const;
  /** One of those, and whether it has a known cell. Throws as SiteReader. */
  bool read(SiteReader::Place tile, Tile& to, ChannelTile* values = nullptr);

 private:
  using Key = std::pair<std::int32_t, std::int32_t>;  //!< x, y
  /** The tiles of the file below a tile of the moved map, or the other way round. */
  std::set<Key> below(SiteReader::Place tile, bool of_file) const;
  bool read_moved(SiteReader::Place tile, Tile& to, ChannelTile* values);
  void list_tiles();

  SiteReader file_;
  MapShift shift_;
  std::set<Key> there_;  //!< in the file; only where cells move, and from the first read() on
};

}  // namespace talus::site
