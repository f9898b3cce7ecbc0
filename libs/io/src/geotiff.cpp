#include <talus/io/geotiff.h>

#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include "bands.h"
#include "gdal_support.h"

#include <cpl_string.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

namespace talus::io
{
namespace
{
void check_shape(const std::string& path, const LayerStack& stack)
{
  try
  {
    stack.require_sound();
  }
  catch (const std::exception& e)
  {
    throw std::runtime_error(path + ": nothing to write: " + e.what());
  }
}

DatasetPtr create(const std::string& file, const LayerStack& s)
{
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("ZLEVEL", "1");  // 6 saves few per cent and takes twice as long
  options.SetNameValue("PREDICTOR", "3");
  options.SetNameValue("INTERLEAVE", "BAND");
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  return DatasetPtr(geotiff_driver().Create(
      file.c_str(), s.cells_x, s.cells_y, static_cast<int>(s.layers.size()), GDT_Float32, options));
}

/** What a file says of a band besides its cells. */
void describe(GDALRasterBand& band, const std::string& name, const std::vector<float>& cells)
{
  band.SetDescription(name.c_str());
  band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  if (const char* unit = unit_of_band(name); *unit) band.SetUnitType(unit);
  BandStatistics statistics;
  for (const float v : cells) statistics.add(v);
  for (const auto& [key, value] : band_items(name, statistics, static_cast<double>(cells.size())))
    band.SetMetadataItem(key.c_str(), value.c_str());
}

/** In which order the layers become bands. */
std::vector<std::size_t> order_of(const LayerStack& stack)
{
  std::vector<std::size_t> order(stack.names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(
      order.begin(), order.end(),
      [&](std::size_t a, std::size_t b)
      { return index_of_band(stack.names[a]) < index_of_band(stack.names[b]); });
  return order;
}

/** One layer, its last row (the northernmost) first. */
bool write_band(GDALRasterBand& band, const std::string& name, std::vector<float> cells)
{
  const int nx = band.GetXSize(), ny = band.GetYSize();
  describe(band, name, cells);
  const GSpacing pixel = sizeof(float), line = -static_cast<GSpacing>(nx) * pixel;
  float* last_row = cells.data() + static_cast<std::size_t>(ny - 1) * nx;
  return band.RasterIO(
             GF_Write, 0, 0, nx, ny, last_row, nx, ny, GDT_Float32, pixel, line, nullptr) ==
         CE_None;
}

/** Of the map frame; none where another program has brought the file to another system. */
std::optional<GeoOrigin> origin_of(GDALDataset& dataset)
{
  const char* const text = dataset.GetMetadataItem(kOriginItem);
  const auto origin = origin_from(text ? text : "");
  const OGRSpatialReference* const crs = dataset.GetSpatialRef();
  const OGRSpatialReference written = crs_of(origin);
  return !crs || crs->IsSame(&written) ? origin : std::nullopt;
}

/** Turns back what lies on Earth; false where it then is not north up with square cells. */
bool to_map_frame(double (&t)[6], const std::optional<GeoOrigin>& origin)
{
  if (origin && origin->heading_deg != 0)
  {
    const std::optional<GeoOrigin> back = GeoOrigin{0, 0, 0, -origin->heading_deg};
    to_crs(t[0], t[3], back);
    to_crs(t[1], t[4], back);
    to_crs(t[2], t[5], back);
    if (std::abs(t[2]) + std::abs(t[4]) > 1e-9 * t[1]) return false;
    return std::abs(t[1] + t[5]) <= 1e-9 * t[1];
  }
  return t[2] == 0 && t[4] == 0 && std::abs(t[1] + t[5]) <= 1e-9 * t[1];
}

/** Cells are metres. */
void require_metres(GDALDataset& dataset, const std::string& path, double cell)
{
  constexpr double kMinCell_m = 1e-3;
  const OGRSpatialReference* const crs = dataset.GetSpatialRef();
  const bool is_geographic = crs && crs->IsGeographic();
  const char* const projection = crs ? crs->GetAttrValue("PROJECTION") : nullptr;
  const bool is_stretched = projection && EQUALN(projection, "Mercator", 8);  // with the latitude
  const bool is_other = crs && !is_geographic && (crs->GetLinearUnits() != 1 || is_stretched);
  if (is_geographic || is_other || cell < kMinCell_m)
    throw std::runtime_error(
        path + ": its cells are " + number_text(cell) +
        (is_geographic ? " degrees"
         : is_other    ? " of other units"
                       : " m") +
        " wide, not metres as those of a map: give the file as talus wrote it, or bring it to a "
        "system of metres with gdalwarp");
}

/** Where the cells of a file lie, without layers. */
LayerStack place_of(GDALDataset& dataset, const std::string& path, const GdalErrors& errors)
{
  constexpr std::int64_t kMaxCells = std::int64_t{1} << 30;  // 4 GB a band
  double t[6];
  if (dataset.GetGeoTransform(t) != CE_None || !to_map_frame(t, origin_of(dataset)) ||
      !(t[1] > 0) || !std::isfinite(t[0] + t[3]))
    fail(
        path, "not a north-up GeoTIFF with square cells; gdalwarp -tr SIZE SIZE makes one", errors);
  require_metres(dataset, path, t[1]);
  LayerStack stack;
  stack.cells_x = dataset.GetRasterXSize();
  stack.cells_y = dataset.GetRasterYSize();
  stack.resolution_m = t[1];
  stack.min_x_m = t[0];
  stack.min_y_m = t[3] - stack.cells_y * t[1];
  if (std::int64_t{stack.cells_x} * stack.cells_y > kMaxCells)
    fail(path, "more than 2^30 cells in a band are not supported: cut out a part of it", errors);
  return stack;
}

/** What no cell may have but those that are unknown; NaN where there is none. */
float nodata_of(GDALRasterBand& band, const std::string& path)
{
  constexpr float kNoHeight_m = 9000;  // what no cell of a map has
  int has_nodata = 0;
  const auto nodata = static_cast<float>(band.GetNoDataValue(&has_nodata));
  if (has_nodata && std::abs(nodata) < kNoHeight_m)
    throw std::runtime_error(
        path + ": its band '" + band.GetDescription() + "' calls the value " + number_text(nodata) +
        " no data, which cells may have: another program has converted this file; mark unknown "
        "cells with NaN");
  return has_nodata ? nodata : std::numeric_limits<float>::quiet_NaN();
}

/** A square of pixels into rows from the south, of which `south` gets the southernmost; nothing
 * where the file has no block of them. */
void read_rows(
    GDALRasterBand& band, int x, int first, int width, int count, float* south,
    const std::string& path, const GdalErrors& errors)
{
  const int covered = band.GetDataCoverageStatus(x, first, width, count, 0, nullptr);
  if (covered == GDAL_DATA_COVERAGE_STATUS_EMPTY) return;
  const GSpacing pixel = sizeof(float), line = -pixel * width;
  const auto row = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(count);
  if (band.RasterIO(
          GF_Read, x, first, width, count, south + (rows - 1) * row, width, count, GDT_Float32,
          pixel, line, nullptr) != CE_None)
    fail(path, "cannot read this GeoTIFF", errors);
  const float nodata = nodata_of(band, path);
  std::replace(south, south + rows * row, nodata, std::numeric_limits<float>::quiet_NaN());
}

/** Cells from (x, y) on. All bands of a block lie side by side in a site, and so are read together.
 */
void read_layers(
    const std::vector<GDALRasterBand*>& bands, int x, int y, LayerStack& stack,
    const std::string& path, const GdalErrors& errors)
{
  constexpr int kRows = 256;
  const GdalCacheLimit limit;
  const std::ptrdiff_t width = stack.cells_x;
  for (GDALRasterBand* band : bands)
  {
    nodata_of(*band, path);
    stack.names.emplace_back(band->GetDescription());
    stack.layers.emplace_back(width * stack.cells_y, std::numeric_limits<float>::quiet_NaN());
  }
  for (int north = stack.cells_y; north > 0; north -= kRows)
  {
    const int rows = std::min(kRows, north);
    const auto south = static_cast<std::size_t>(north - rows) * stack.cells_x;
    for (std::size_t b = 0; b < bands.size(); ++b)
      read_rows(
          *bands[b], x, bands[b]->GetYSize() - y - north, stack.cells_x, rows,
          stack.layers[b].data() + south, path, errors);
  }
}
}  // namespace

void write_geotiff(
    const std::string& path, const LayerStack& stack,
    const std::map<std::string, std::string>& metadata, const std::optional<GeoOrigin>& origin)
{
  check_shape(path, stack);
  AtomicFile file(path);
  GdalErrors errors;
  DatasetPtr dataset = create(file.temporary_path(), stack);
  if (!dataset) fail(path, "cannot write this GeoTIFF", errors);

  auto transform = transform_of(
      stack.min_x_m, stack.min_y_m + stack.cells_y * stack.resolution_m, stack.resolution_m,
      origin);
  const OGRSpatialReference crs = crs_of(origin);
  dataset->SetGeoTransform(transform.data());
  dataset->SetSpatialRef(&crs);
  put_origin(*dataset, origin);
  for (const auto& [key, value] : metadata) dataset->SetMetadataItem(key.c_str(), value.c_str());
  int band = 0;
  for (const std::size_t i : order_of(stack))
    if (!write_band(*dataset->GetRasterBand(++band), stack.names[i], stack.layers[i]))
      fail(path, kNotWritten, errors);
  dataset.reset();
  if (errors.any()) fail(path, kNotWritten, errors);
  file.commit();
}

struct GeotiffFile::Impl
{
  explicit Impl(std::string p) : path(std::move(p)), dataset(open_geotiff(path, errors)) {}

  std::string path;
  GdalErrors errors;
  DatasetPtr dataset;
  std::optional<LayerStack> place{};  //!< once it was asked for: its system takes long to look at
};

GeotiffFile::GeotiffFile(const std::string& path) : impl_(std::make_unique<Impl>(path)) {}
GeotiffFile::~GeotiffFile() = default;

std::vector<std::string> GeotiffFile::bands() const
{
  std::vector<std::string> names;
  for (auto* band : impl_->dataset->GetBands()) names.emplace_back(band->GetDescription());
  return names;
}

std::string GeotiffFile::item(const char* name) const
{
  const char* const text = impl_->dataset->GetMetadataItem(name);
  return text ? text : "";
}

std::optional<GeoOrigin> GeotiffFile::origin() const { return origin_of(*impl_->dataset); }

const std::string& GeotiffFile::path() const { return impl_->path; }

LayerStack GeotiffFile::frame() const
{
  require_plain_floats(*impl_->dataset, impl_->path);
  if (!impl_->place) impl_->place = place_of(*impl_->dataset, impl_->path, impl_->errors);
  return *impl_->place;
}

LayerStack GeotiffFile::read(const std::vector<std::string>& bands) const
{
  const LayerStack whole = frame();
  LayerStack stack = read_part(0, 0, whole.cells_x, whole.cells_y, bands);
  impl_->dataset->FlushCache();  // the file stays open, its blocks need not
  return stack;
}

LayerStack GeotiffFile::read_part(
    int x, int y, int cells_x, int cells_y, const std::vector<std::string>& bands) const
{
  LayerStack stack = frame();
  if (x < 0 || y < 0 || cells_x > stack.cells_x - x || cells_y > stack.cells_y - y)
    throw std::invalid_argument(impl_->path + ": has no such part");
  stack.cells_x = cells_x;
  stack.cells_y = cells_y;
  stack.min_x_m += x * stack.resolution_m;
  stack.min_y_m += y * stack.resolution_m;
  std::vector<GDALRasterBand*> wanted;
  for (auto* band : impl_->dataset->GetBands())
    if (bands.empty() ||
        std::find(bands.begin(), bands.end(), band->GetDescription()) != bands.end())
      wanted.push_back(band);
  read_layers(wanted, x, y, stack, impl_->path, impl_->errors);
  return stack;
}

LayerStack read_geotiff(const std::string& path, const std::vector<std::string>& bands)
{
  return GeotiffFile(path).read(bands);
}

}  // namespace talus::io
