#pragma once
#include <talus/io/geo_origin.h>
#include <talus/io/layer_stack.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace talus::io
{
/** Writes a GeoTIFF, its rows along the x axis of the map frame, the last row first: north up where
 * y points north. One float32 band per layer, band description = layer name, nodata NaN, with units
 * and statistics, compressed; traversability, ground, elevation, variance and state come first, as
 * in all files of maps. It lies on Earth where `origin` is known. `metadata` becomes dataset
 * metadata items. The file appears whole or not at all
 * (written beside, then renamed). Throws std::runtime_error naming the file and the reason. */
void write_geotiff(
    const std::string& path, const LayerStack& stack,
    const std::map<std::string, std::string>& metadata = {},
    const std::optional<GeoOrigin>& origin = std::nullopt);

/** A GeoTIFF that write_geotiff() wrote, or any other one without another rotation whose bands hold
 * float32 as they are. All throw std::runtime_error that names the file and the reason, also where
 * another program has converted the bands. */
class GeotiffFile
{
 public:
  /** Opens it. */
  explicit GeotiffFile(const std::string& path);
  ~GeotiffFile();
  GeotiffFile(const GeotiffFile&) = delete;
  GeotiffFile& operator=(const GeotiffFile&) = delete;

  /** Their names. */
  std::vector<std::string> bands() const;
  /** An item of its metadata; "" where it has none of that name. */
  std::string item(const char* name) const;
  /** Where the map is on Earth; nothing where it does not say. */
  std::optional<GeoOrigin> origin() const;
  /** As it was given. */
  const std::string& path() const;
  /** Where it lies in the map frame, without layers. */
  LayerStack frame() const;
  /** In the map frame. `bands`: of these names only, where they are there; empty: all. */
  LayerStack read(const std::vector<std::string>& bands = {}) const;
  /** The same of a part of it: `cells_x` by `cells_y` cells, the first of which is cell (x, y). */
  LayerStack read_part(
      int x, int y, int cells_x, int cells_y, const std::vector<std::string>& bands = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** GeotiffFile::read() of a file that nothing else is asked. */
LayerStack read_geotiff(const std::string& path, const std::vector<std::string>& bands = {});

}  // namespace talus::io
