#include "site_reader.h"
#include "cell_bands.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr const char* kNotASite = "is not a site: give a site.tif of talus-map or talus-merge";
constexpr const char* kDamaged = "damaged: copy it again, or make it anew";
constexpr const char* kCutShort = "cannot be read to its end; copy it again";
constexpr std::int64_t kMaxIslands = 1000000;
constexpr std::int64_t kFarthestCell = 2'000'000'000;  //!< beyond what frames can lead to
}  // namespace

SiteReader::SiteReader(const std::string& path) : path_(path)
{
  const io::GdalErrors errors;
  dataset_ = io::open_geotiff(path, errors);
  read_channels();
  check_bands();
  read_metadata();
  check_extent();
}

void SiteReader::fail(const std::string& what) const
{
  throw std::runtime_error(path_ + ": " + what);
}

void SiteReader::read_channels()
{
  const char* text = dataset_->GetMetadataItem(kChannelsItem);
  try
  {
    channels_ = channels_from(text ? text : "");
  }
  catch (const std::invalid_argument&)
  {
    fail(std::string("its ") + kChannelsItem + " are no channels; it is " + kDamaged);
  }
}

void SiteReader::add_channels_to(Site& site) const
{
  try
  {
    add_channels(site.channels, channels_);
  }
  catch (const std::invalid_argument& e)
  {
    fail(std::string("its channels do not go with those of the other maps: ") + e.what());
  }
}

void SiteReader::check_bands()
{
  const auto number_of = [&](const std::string& name)
  {
    for (int i = 1; i <= dataset_->GetRasterCount(); ++i)
      if (name == dataset_->GetRasterBand(i)->GetDescription()) return i;
    return 0;
  };
  bands_.reserve(kBandCount);
  for (const char* name : kBandNames) bands_.push_back(number_of(name));
  for (const std::string& name : channel_layer_names(channels_)) bands_.push_back(number_of(name));
  int& reached = bands_[static_cast<std::size_t>(Band::Reached)];
  const bool has_reached = reached != 0;
  if (!has_reached) reached = bands_[static_cast<std::size_t>(Band::Evidence)];
  if (std::find(bands_.begin(), bands_.end(), 0) == bands_.end())
  {
    check_values(static_cast<int>(bands_.size()) - (has_reached ? 0 : 1));
    return;
  }
  if (number_of("sparsity") != 0)
    fail("is the map.tif of one window, not a site: give the site.tif that lies beside it");
  fail(std::string("has other bands, it ") + kNotASite);
}

/** Cells of other types or scales pass for heights, too. */
void SiteReader::check_values(int bands) const
{
  const int count = dataset_->GetRasterCount();
  if (count != bands)
    fail(
        "has " + std::to_string(count) + " bands, a site has " + std::to_string(bands) +
        ": another program has added some; give the file as talus wrote it");
  io::require_plain_floats(*dataset_, path_);
  for (auto* band : dataset_->GetBands())
    if (int has = 0; !std::isnan(band->GetNoDataValue(&has)) || !has)
      fail(
          std::string("its band '") + band->GetDescription() +
          "' does not mark unknown cells with NaN: another program has converted this file; give "
          "it as talus wrote it");
}

std::string SiteReader::item(const char* name) const
{
  const char* text = dataset_->GetMetadataItem(name);
  if (!text) fail(std::string("has no ") + name + ", it " + kNotASite);
  return text;
}

std::int64_t SiteReader::whole_item(const char* name, std::int64_t min, std::int64_t max) const
{
  const auto v = number_from(item(name));
  if (!v || *v != std::floor(*v) || *v < static_cast<double>(min) || *v > static_cast<double>(max))
    fail(std::string("its ") + name + " is no whole number that fits; it is " + kDamaged);
  return static_cast<std::int64_t>(*v);
}

void SiteReader::read_metadata()
{
  const auto resolution = number_from(item(kResolutionItem));
  if (!resolution || !(*resolution > 0) || !std::isfinite(*resolution))
    fail(std::string("its resolution is none; it is ") + kDamaged);
  info_.resolution_m = *resolution;
  min_cell_x_ = whole_item(kMinCellXItem, -kFarthestCell, kFarthestCell);
  min_cell_y_ = whole_item(kMinCellYItem, -kFarthestCell, kFarthestCell);
  info_.newest_s = static_cast<std::uint32_t>(
      whole_item(kSeenItem, 0, std::numeric_limits<std::uint32_t>::max()));
  info_.floor = static_cast<int>(whole_item(kFloorItem, 0, std::numeric_limits<int>::max()));
  if (const char* text = dataset_->GetMetadataItem(kFloorsItem))
  {
    const auto floors = floors_from(text);
    if (!floors) fail(std::string("its ") + kFloorsItem + " are no floors; it is " + kDamaged);
    info_.floors = *floors;
  }
  if (dataset_->GetMetadataItem(kObjectTopsItem))
    info_.islands = static_cast<std::size_t>(whole_item(kObjectTopsItem, 1, kMaxIslands));
  if (const char* text = dataset_->GetMetadataItem(kOriginItem))
  {
    origin_ = origin_from(text);
    if (!origin_) fail(std::string("its ") + kOriginItem + " is no position; it is " + kDamaged);
  }
}

/** A program that cuts or resamples a file keeps the metadata of the whole. */
void SiteReader::check_extent()
{
  const int width = dataset_->GetRasterXSize(), height = dataset_->GetRasterYSize();
  const auto expected = transform_of(
      static_cast<double>(min_cell_x_) * info_.resolution_m,
      static_cast<double>(min_cell_y_ + height) * info_.resolution_m, info_.resolution_m, origin_);
  double t[6];
  bool same = dataset_->GetGeoTransform(t) == CE_None;
  for (std::size_t i = 0; i < 6; ++i)
    same = same && std::abs(t[i] - expected[i]) <= info_.resolution_m * (i % 3 == 0 ? 0.01 : 1e-6);
  if (!same || width % kTileCells != 0 || height % kTileCells != 0 ||
      min_cell_x_ % kTileCells != 0 || min_cell_y_ % kTileCells != 0)
    fail("was cut, moved or resampled by another program: give the file as talus wrote it");
  width_tiles_ = width / kTileCells;
  height_tiles_ = height / kTileCells;
}

void SiteReader::require_fits(const Site& site) const
{
  if (info_.resolution_m != site.resolution_m)
    fail(
        "its cells are " + number_text(info_.resolution_m) + " m wide, not " +
        number_text(site.resolution_m) +
        " m: give maps of one resolution, or go on with resolution_m=" +
        number_text(info_.resolution_m));
  const auto text = [](const std::optional<GeoOrigin>& o)
  { return o ? text_of_origin(*o) : std::string("none"); };
  if (text(origin_) != text(site.origin))
    fail(
        "its origin on Earth is another (" + text(origin_) + ", not " + text(site.origin) +
        "): give maps of one map frame, made with one --origin");
}

Ways SiteReader::ways(int floor) const
{
  const char* text = dataset_->GetMetadataItem(kWaysItem);
  auto ways = ways_from(text ? text : "", floor);
  if (!ways) fail(std::string("its ") + kWaysItem + " are no ways; it is " + kDamaged);
  return std::move(*ways);
}

std::vector<SiteReader::TileIndex> SiteReader::tiles() const
{
  int size = 1;
  while (size < std::max(width_tiles_, height_tiles_)) size *= 2;
  std::vector<TileIndex> found;
  const io::GdalErrors errors;
  add_covered({0, 0}, size, found);
  // A file that ends in its list of blocks seems to have none.
  if (errors.any() || found.empty()) io::fail(path_, kCutShort, errors);
  return found;
}

/** `from` is counted from the upper left corner of the image here. */
void SiteReader::add_covered(TileIndex from, int size_tiles, std::vector<TileIndex>& to) const
{
  if (from.x >= width_tiles_ || from.y >= height_tiles_) return;
  const int width = std::min(size_tiles, width_tiles_ - from.x) * kTileCells;
  const int height = std::min(size_tiles, height_tiles_ - from.y) * kTileCells;
  auto* band = dataset_->GetRasterBand(bands_[static_cast<std::size_t>(Band::State)]);
  const int status = band->GetDataCoverageStatus(
      from.x * kTileCells, from.y * kTileCells, width, height, GDAL_DATA_COVERAGE_STATUS_DATA,
      nullptr);
  if (!(status & (GDAL_DATA_COVERAGE_STATUS_DATA | GDAL_DATA_COVERAGE_STATUS_UNIMPLEMENTED)))
    return;
  if (size_tiles == 1)
  {
    to.push_back(
        {tile_of(min_cell_x_) + from.x, tile_of(min_cell_y_) + height_tiles_ - 1 - from.y});
    return;
  }
  const int half = size_tiles / 2;
  for (const int dy : {0, half})
    for (const int dx : {0, half}) add_covered({from.x + dx, from.y + dy}, half, to);
}

/** The first bands of a tile. The file has all of a block side by side. */
void SiteReader::load(TileIndex tile, std::size_t bands)
{
  const int left = (tile.x - tile_of(min_cell_x_)) * kTileCells;
  const int top = (height_tiles_ - 1 - (tile.y - tile_of(min_cell_y_))) * kTileCells;
  const GSpacing pixel = static_cast<GSpacing>(sizeof(float) * bands);
  const GSpacing line = pixel * kTileCells;
  const io::GdalErrors errors;
  values_.resize(static_cast<std::size_t>(kTileCells) * kTileCells * bands);
  // The last row first: rows of tiles begin in the south.
  auto* last = values_.data() + static_cast<std::size_t>(kTileCells - 1) * kTileCells * bands;
  if (dataset_->RasterIO(
          GF_Read, left, top, kTileCells, kTileCells, last, kTileCells, kTileCells, GDT_Float32,
          static_cast<int>(bands), bands_.data(), pixel, -line, sizeof(float), nullptr) != CE_None)
    io::fail(path_, kCutShort, errors);
}

/** Of the tile that was loaded. */
void SiteReader::check_sum(TileIndex tile)
{
  const char* text = dataset_->GetMetadataItem(kSumsItem);
  if (!text) return;
  if (!sums_) sums_ = sums_from(text);
  if (!sums_) fail(std::string("its ") + kSumsItem + " are none; it is " + kDamaged);
  TileSum sum;
  for (std::size_t i = 0; i < values_.size(); i += bands_.size())
    sum.add(values_.data() + i, bands_.size());
  const auto written = sums_->find({tile.x, tile.y});
  if (sum.value() == (written == sums_->end() ? TileSum().value() : written->second)) return;
  fail(
      "its cells near (" + fixed_text((tile.x + 0.5) * kTileCells * info_.resolution_m, 0) + ", " +
      fixed_text((tile.y + 0.5) * kTileCells * info_.resolution_m, 0) +
      ") m are not those that were written; it is " + kDamaged);
}

bool SiteReader::read(TileIndex tile, Tile& to, ChannelTile* values)
{
  load(tile, bands_.size());
  check_sum(tile);
  bool any = false;
  for (std::size_t i = 0; i < to.cells.size(); ++i)
  {
    BandValues of_cell;
    std::copy_n(
        values_.begin() + static_cast<std::ptrdiff_t>(i * bands_.size()), kBandCount,
        of_cell.begin());
    const auto cell = cell_of(of_cell, info_.newest_s);
    if (!cell) fail(std::string("its cells are none of a site; it is ") + kDamaged);
    to.cells[i] = *cell;
    any |= cell->known();
  }
  if (values) read_values(*values);
  return any;
}

void SiteReader::read_values(ChannelTile& to) const
{
  for (std::size_t i = 0; i < to.cells.size(); ++i)
    for (std::size_t l = 0; l < bands_.size() - kBandCount; ++l)
    {
      const float v = values_[i * bands_.size() + kBandCount + l];
      const Channel& channel = channels_[l / kChannelSurfaces];
      if (!is_channel_value(channel.rule, v))
        fail("its channel '" + channel.name + "' has values that are none; it is " + kDamaged);
      to.cells[i].values[l] = std::isnan(v) ? NAN : v;
    }
}

}  // namespace talus::site
