#pragma once
#include "site_metadata.h"

#include <talus/site/site_geotiff.h>
#include <gdal_support.h>
#include <talus/site/map_shift.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace talus::site
{
/** A file that write_site() wrote, tile by tile. */
class SiteReader
{
 public:
  /** Throws std::runtime_error that names the file, what is wrong and what to do. */
  explicit SiteReader(const std::string& path);

  const std::string& path() const { return path_; }
  const SiteInfo& info() const { return info_; }
  const std::optional<GeoOrigin>& origin() const { return origin_; }
  /** Its last bands are their layers. */
  const std::vector<Channel>& channels() const { return channels_; }
  /** Throws where the site has one of them with another rule, or too many become. */
  void add_channels_to(Site& site) const;
  /** Throws where the site has another resolution or origin. */
  void require_fits(const Site& site) const;
  /** As of floor `floor`. */
  Ways ways(int floor) const;

  struct TileIndex
  {
    std::int32_t x, y;
  };
  /** The tiles that may have a known cell; neighbours are near each other. */
  std::vector<TileIndex> tiles() const;
  /** Throws where one of those is cut short; what its cells say is not looked at. */
  void check(TileIndex tile) { load(tile, 1); }
  /** One of those, and whether it has a known cell; in `values`, unless it is null, the values of
   * its channels. Throws as the constructor. */
  bool read(TileIndex tile, Tile& to, ChannelTile* values = nullptr);

 private:
  void load(TileIndex tile, std::size_t bands);
  void read_channels();
  void check_bands();
  void check_values(int bands) const;
  void read_metadata();
  void check_extent();
  void check_sum(TileIndex tile);
  void read_values(ChannelTile& to) const;
  std::string item(const char* name) const;
  std::int64_t whole_item(const char* name, std::int64_t min, std::int64_t max) const;
  void add_covered(TileIndex from, int size_tiles, std::vector<TileIndex>& to) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  io::DatasetPtr dataset_;
  SiteInfo info_;
  std::optional<GeoOrigin> origin_;
  std::vector<Channel> channels_;
  std::int64_t min_cell_x_ = 0, min_cell_y_ = 0;
  int width_tiles_ = 0, height_tiles_ = 0;
  std::vector<int> bands_;  //!< their numbers in the file, in our order
  std::vector<float> values_;
  std::optional<TileSums> sums_;  //!< of its tiles, from the first one on
};

/** A file of a site, moved: heights change by exactly what is asked for; where cells move to other
 * positions, each is the one of the file that lies nearest. */
class MovedReader
{
 public:
  /** Throws as SiteReader. */
  MovedReader(const std::string& path, const MapShift& shift);

  const SiteReader& file() const { return file_; }
  /** As of floor `floor`, moved. */
  Ways ways(int floor) const;
  /** The tiles that may have a known cell. */
  std::vector<SiteReader::TileIndex> tiles() const;
  /** One of those, and whether it has a known cell. Throws as SiteReader. */
  bool read(SiteReader::TileIndex tile, Tile& to, ChannelTile* values = nullptr);

 private:
  using Key = std::pair<std::int32_t, std::int32_t>;  //!< x, y
  /** The tiles of the file below a tile of the moved map, or the other way round. */
  std::set<Key> below(SiteReader::TileIndex tile, bool of_file) const;
  bool read_moved(SiteReader::TileIndex tile, Tile& to, ChannelTile* values);
  void list_tiles();

  SiteReader file_;
  MapShift shift_;
  std::set<Key> there_;  //!< in the file; only where cells move, and from the first read() on
};

}  // namespace talus::site
