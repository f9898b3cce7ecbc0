#include <talus/site/site_files.h>
#include <talus/site/site_geotiff.h>

#include "kept_cell.h"
#include "site_reader.h"
#include "site_dataset.h"
#include "site_metadata.h"

#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include <cpl_string.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr int kLargestOverview_cells = 512;
constexpr std::int64_t kManyCells = std::int64_t{1} << 38;  //!< then blocks are larger
constexpr std::int64_t kMaxCells = std::int64_t{1} << 43;  //!< the file lists all its blocks

void set_metadata(
    SiteDataset& dataset, const TilePyramid& pyramid, const Site& site, const FileOfFloor& file)
{
  const auto set = [&](const char* name, const std::string& text)
  { dataset.SetMetadataItem(name, text.c_str()); };
  set(kFloorItem, std::to_string(file.floor));
  if (file.floors.size() > 1 && file.floor == file.floors.front())
    set(kFloorsItem, text_of_floors(file.floors));
  if (file.islands > 0) set(kObjectTopsItem, std::to_string(file.islands));
  set(kResolutionItem, exact_number_text(site.resolution_m));
  set(kMinCellXItem, std::to_string(pyramid.min_cell_x()));
  set(kMinCellYItem, std::to_string(pyramid.min_cell_y()));
  set(kSeenItem, std::to_string(pyramid.newest_s()));
  const std::string ways = text_of_ways(site.ways, file.floor);
  if (!ways.empty()) set(kWaysItem, ways);
  if (!site.channels.empty()) set(kChannelsItem, channels_text(site.channels));
  set(kSumsItem, text_of_sums(dataset.sums()));
  io::put_origin(dataset, site.origin);
  dataset.SetMetadataItem("AREA_OR_POINT", "Area");
}

CPLStringList options_for(const TilePyramid& pyramid)
{
  const bool many = pyramid.width_cells(0) * pyramid.height_cells(0) > kManyCells;
  CPLStringList options;
  // DEFLATE of level 2 is 7 % larger and takes three times as long. A predictor saves nothing.
  options.SetNameValue("COMPRESS", "ZSTD");
  options.SetNameValue("LEVEL", "1");
  options.SetNameValue("BLOCKSIZE", many ? "512" : "256");
  options.SetNameValue("OVERVIEW_RESAMPLING", "NEAREST");
  options.SetNameValue("OVERVIEWS", "FORCE_USE_EXISTING");
  options.SetNameValue("SPARSE_OK", "YES");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("NUM_THREADS", "ALL_CPUS");  // in the order of the blocks
  return options;
}

int CPL_STDCALL report(double done, const char*, void* progress)
{
  const auto& p = *static_cast<const Progress*>(progress);
  if (p) p(done);
  return TRUE;
}

void check_extent(const std::string& path, const TilePyramid& pyramid, int floor)
{
  if (pyramid.empty())
    throw std::runtime_error(
        path + ": nothing to write: no cell of floor " + std::to_string(floor) + " is known");
  constexpr std::int64_t kWidest = std::numeric_limits<int>::max();
  const std::int64_t width = pyramid.width_cells(0), height = pyramid.height_cells(0);
  if (width > kWidest || height > kWidest || width > kMaxCells / height)
    throw std::runtime_error(
        path + ": the site spans " + std::to_string(width) + " x " + std::to_string(height) +
        " cells, more than a GeoTIFF can hold: did a pose jump? Else divide the drive");
}

/** To its end: not every version of GDAL reports where the disk was full. */
bool can_be_read(const std::string& path)
{
  try
  {
    SiteReader reader(path);
    for (const SiteReader::TileIndex& at : reader.tiles()) reader.check(at);
    return true;
  }
  catch (const std::runtime_error&)
  {
    return false;
  }
}
}  // namespace

void write_site(const std::string& path, Site& site, int floor, const Progress& progress)
{
  write_site_file(path, site, {floor, floors_of(site), 0}, progress);
}

void write_site_file(
    const std::string& path, Site& site, const FileOfFloor& of, const Progress& progress)
{
  const int floor = of.floor;
  io::AtomicFile file(path);
  TilePyramid pyramid(
      site, floor, kLargestOverview_cells, (file.hidden_folder().path() / "overviews").string());
  check_extent(path, pyramid, floor);
  const io::GdalCacheLimit limit;
  io::GdalErrors errors;
  GDALDriver& cog = io::cog_driver();
  SiteDataset dataset(
      pyramid, site.channels,
      transform_of(
          static_cast<double>(pyramid.min_cell_x()) * site.resolution_m,
          static_cast<double>(pyramid.min_cell_y() + pyramid.height_cells(0)) * site.resolution_m,
          site.resolution_m, site.origin),
      crs_of(site.origin));
  set_metadata(dataset, pyramid, site, of);
  io::DatasetPtr written(cog.CreateCopy(
      file.temporary_path().c_str(), &dataset, FALSE, options_for(pyramid), report,
      const_cast<Progress*>(&progress)));
  dataset.rethrow();
  written.reset();  // what does not reach the disk is an error here at the latest
  if (errors.any() || !can_be_read(file.temporary_path())) io::fail(path, io::kNotWritten, errors);
  file.commit();
}

void read_site(const std::string& path, Site& site, int floor, const MapShift& shift)
{
  const io::GdalCacheLimit limit;
  MovedReader reader(path, shift);
  if (!site.origin && site.tiles.keys().empty()) site.origin = reader.file().origin();
  reader.file().require_fits(site);
  reader.file().add_channels_to(site);
  auto ways = reader.ways(floor);
  const auto tile = std::make_unique<Tile>();
  const auto values = std::make_unique<ChannelTile>();
  const bool has_values = !reader.file().channels().empty();
  const auto places = channel_indices(reader.file().channels(), site.channels);
  for (const auto& at : reader.tiles())
  {
    if (!reader.read(at, *tile, values.get())) continue;
    const TileKey key{floor, at.x, at.y};
    site.tiles.at(key) = *tile;
    if (has_values) put_values(*values, places, site.channel_tiles.at(key));
  }
  for (auto& way : ways) site.ways.push_back(std::move(way));
}

void require_whole(const std::string& path)
{
  const io::GdalCacheLimit limit;
  SiteReader reader(path);
  const auto cells = std::make_unique<Tile>();
  for (const SiteReader::TileIndex& at : reader.tiles()) reader.read(at, *cells);
}

SiteInfo info_of_site(const std::string& path) { return SiteReader(path).info(); }

bool is_site(const io::GeotiffFile& file)
{
  if (file.item(kFloorItem).empty()) return false;
  const io::LayerStack at = file.read({"none of its bands"});
  const auto begins = [&](const char* cell, double min_m)
  { return std::abs(number_from(file.item(cell)).value_or(NAN) * at.resolution_m - min_m) < 1e-3; };
  return begins(kMinCellXItem, at.min_x_m) && begins(kMinCellYItem, at.min_y_m) &&
         at.cells_x % kTileCells == 0 && at.cells_y % kTileCells == 0;
}

std::vector<std::vector<WayPoint>> ways_of_site(const io::GeotiffFile& file)
{
  return ways_from(file.item(kWaysItem), 0).value_or(Ways());
}

}  // namespace talus::site
