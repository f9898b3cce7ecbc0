#include "changes.h"

#include "site_metadata.h"
#include "site_reader.h"
#include "known_cells.h"

#include <bands.h>
#include <gdal_support.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>
#include <cpl_string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>

namespace talus::site
{
namespace
{
constexpr int kBands = 2;  //!< change_m and kind

/** The tiles from the first to the last that both know. */
struct TileBox
{
  std::int32_t min_x = INT32_MAX, min_y = INT32_MAX, max_x = INT32_MIN, max_y = INT32_MIN;

  void add(const TileKey& k)
  {
    min_x = std::min(min_x, k.x);
    max_x = std::max(max_x, k.x);
    min_y = std::min(min_y, k.y);
    max_y = std::max(max_y, k.y);
  }
};

TileBox common_tiles(const Site& from, const Site& to, int floor)
{
  const auto before = from.tiles.keys(), after = to.tiles.keys();
  std::vector<TileKey> both;
  std::set_intersection(
      before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(both));
  TileBox box;
  for (const TileKey& key : both)
    if (key.floor == floor) box.add(key);
  return box;
}

io::DatasetPtr create(const std::string& file, const TileBox& box, const Site& site)
{
  CPLStringList options;
  for (const char* option :
       {"COMPRESS=DEFLATE", "PREDICTOR=3", "TILED=YES", "BLOCKXSIZE=128", "BLOCKYSIZE=128",
        "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER", "INTERLEAVE=PIXEL"})
    options.AddString(option);
  const int width = (box.max_x - box.min_x + 1) * kTileCells;
  const int height = (box.max_y - box.min_y + 1) * kTileCells;
  io::DatasetPtr dataset(
      io::geotiff_driver().Create(file.c_str(), width, height, kBands, GDT_Float32, options));
  if (!dataset) return dataset;
  const double tile_m = kTileCells * site.resolution_m;
  auto transform =
      transform_of(box.min_x * tile_m, (box.max_y + 1.0) * tile_m, site.resolution_m, site.origin);
  const OGRSpatialReference crs = crs_of(site.origin);
  dataset->SetGeoTransform(transform.data());
  dataset->SetSpatialRef(&crs);
  const std::array<const char*, kBands> names{"change_m", "kind"};
  for (int b = 0; b < kBands; ++b)
  {
    const char* const name = names[static_cast<std::size_t>(b)];
    dataset->GetRasterBand(b + 1)->SetDescription(name);
    dataset->GetRasterBand(b + 1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
    if (const char* unit = io::unit_of_band(name); *unit)
      dataset->GetRasterBand(b + 1)->SetUnitType(unit);
    for (const auto& [key, value] : io::band_items(name, {}, 1))
      dataset->GetRasterBand(b + 1)->SetMetadataItem(key.c_str(), value.c_str());
  }
  io::put_origin(*dataset, site.origin);
  return dataset;
}

/** Adds the changes of a tile to the sums; their pixels, north first. False where neither cell has
 * been seen by both. */
bool add_tile(const std::vector<CellChange>& changes, std::vector<float>& pixels, ChangeSums& sums)
{
  bool any = false;
  for (int i = 0; i < kTileCells * kTileCells; ++i)
  {
    const CellChange& c = changes[static_cast<std::size_t>(i)];
    const int row = kTileCells - 1 - i / kTileCells;
    float* pixel =
        pixels.data() + (static_cast<std::ptrdiff_t>(row) * kTileCells + i % kTileCells) * kBands;
    pixel[0] = pixel[1] = std::numeric_limits<float>::quiet_NaN();
    if (std::isnan(c.change_m)) continue;
    any = true;
    const auto kind = static_cast<std::size_t>(c.kind);
    pixel[0] = c.change_m;
    pixel[1] = static_cast<float>(kind);
    ++sums.cells[kind];
    if (c.kind != Change::None)
      sums.volume_m3[kind] += std::abs(static_cast<double>(c.change_m)) * sums.cell_m2;
  }
  return any;
}

ChangeSums write_geotiff(
    const std::string& path, Site& from, Site& to, int floor, double step_m, const TileBox& box)
{
  io::AtomicFile file(path);
  const io::GdalCacheLimit limit;
  const io::GdalErrors errors;
  io::DatasetPtr dataset = create(file.temporary_path(), box, to);
  if (!dataset) io::fail(path, "cannot write this GeoTIFF", errors);
  ChangeSums sums;
  sums.cell_m2 = to.resolution_m * to.resolution_m;
  std::vector<float> pixels(static_cast<std::size_t>(kTileCells) * kTileCells * kBands);
  for_each_compared_tile(
      from, to, floor, step_m,
      [&](const TileKey& key, const std::vector<CellChange>& changes)
      {
        if (!add_tile(changes, pixels, sums)) return;
        if (dataset->RasterIO(
                GF_Write, (key.x - box.min_x) * kTileCells, (box.max_y - key.y) * kTileCells,
                kTileCells, kTileCells, pixels.data(), kTileCells, kTileCells, GDT_Float32, kBands,
                nullptr, sizeof(float) * kBands, sizeof(float) * kBands * kTileCells, sizeof(float),
                nullptr) != CE_None)
          io::fail(path, io::kNotWritten, errors);
      });
  dataset.reset();
  if (errors.any()) io::fail(path, io::kNotWritten, errors);
  file.commit();
  return sums;
}
void require_one_frame(const std::string& path, const Site& from, const Site& to)
{
  const auto text = [](const Site& s)
  {
    return exact_number_text(s.resolution_m) + " " +
           (s.origin ? text_of_origin(*s.origin) : std::string("none"));
  };
  if (text(from) != text(to))
    throw std::runtime_error(
        path + ": the two maps have other resolutions, or origins on Earth (" + text(from) +
        " and " + text(to) + "): give maps of one map frame");
}

float top_m(const SiteCell& s)
{
  if (!has_seen(s)) return NAN;
  return has_elevation(s) ? s.cell.elevation_m : s.cell.ground_m;
}

/** The tops of a tile with one cell around it; NaN where none was seen. */
class Tops
{
 public:
  static constexpr int kSide = kTileCells + 2;

  /** Throws as TileStore. */
  void read(Site& site, const TileKey& key)
  {
    m_.fill(NAN);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (const Tile* tile = site.tiles.find({key.floor, key.x + dx, key.y + dy}))
          copy(*tile, dx * kTileCells, dy * kTileCells);
  }

  /** Whether a cell or one of its neighbours has a top within a step of a height. */
  bool has_near(int x, int y, float height_m, double step_m) const
  {
    for (int ny = y - 1; ny <= y + 1; ++ny)
      for (int nx = x - 1; nx <= x + 1; ++nx)
        if (std::abs(at(nx, ny) - height_m) <= step_m) return true;
    return false;
  }
  float at(int x, int y) const
  {
    return m_[static_cast<std::size_t>(y + 1) * kSide + static_cast<std::size_t>(x + 1)];
  }

 private:
  /** Those cells of a tile, which begins at (x0, y0), that are in reach. */
  void copy(const Tile& tile, int x0, int y0)
  {
    const int left = std::max(-1, x0), right = std::min(kTileCells, x0 + kTileCells - 1);
    const int low = std::max(-1, y0), high = std::min(kTileCells, y0 + kTileCells - 1);
    for (int y = low; y <= high; ++y)
      for (int x = left; x <= right; ++x)
        m_[static_cast<std::size_t>(y + 1) * kSide + static_cast<std::size_t>(x + 1)] =
            top_m(tile.cells[static_cast<std::size_t>((y - y0) * kTileCells + (x - x0))]);
  }

  std::array<float, static_cast<std::size_t>(kSide) * kSide> m_;
};

/** Whether what was there is still beside, or what is there was beside before. */
bool is_moved_edge(
    const CellChange& c, const Tops& from, const Tops& to, int x, int y, double step_m)
{
  return c.kind == Change::Gone ? to.has_near(x, y, from.at(x, y), step_m)
                                : from.has_near(x, y, to.at(x, y), step_m);
}
}  // namespace

void ChangeSums::add(const ChangeSums& other)
{
  cell_m2 = other.cell_m2;
  for (std::size_t k = 0; k < kChangeCount; ++k)
  {
    cells[k] += other.cells[k];
    volume_m3[k] += other.volume_m3[k];
  }
}

bool have_common_tile(Site& from, Site& to, int floor)
{
  const TileBox box = common_tiles(from, to, floor);
  return box.min_x <= box.max_x;
}

ChangeSums write_changes(
    const std::string& geotiff_path, const std::string& picture_path, Site& from, Site& to,
    int floor, double step_m)
{
  require_one_frame(geotiff_path, from, to);
  if (!have_common_tile(from, to, floor))
    throw std::runtime_error(
        geotiff_path + ": nothing to compare: the two sites have no place in common");
  const TileBox box = common_tiles(from, to, floor);
  const ChangeSums sums = write_geotiff(geotiff_path, from, to, floor, step_m, box);
  write_changes_picture(picture_path, from, to, floor, step_m, sums);
  return sums;
}

CellChange change_of(const SiteCell& from, const SiteCell& to, double step_m)
{
  CellChange c;
  c.change_m = top_m(to) - top_m(from);
  if (!(std::abs(c.change_m) > step_m)) return c;
  const float ground_m = to.cell.ground_m - from.cell.ground_m;
  const bool is_ground = is_measured(from) && is_measured(to) && std::abs(ground_m) > step_m;
  if (is_ground || (!has_elevation(from) && !has_elevation(to)))
    c.kind = ground_m > 0 ? Change::Built : Change::Dug;
  else
    c.kind = c.change_m > 0 ? Change::Appeared : Change::Gone;
  return c;
}

void for_each_compared_tile(Site& from, Site& to, int floor, double step_m, const OnTile& f)
{
  const auto keys = to.tiles.keys();
  const std::set<TileKey> in_both(keys.begin(), keys.end());
  const auto before = std::make_unique<Tile>(), after = std::make_unique<Tile>();
  const auto tops_before = std::make_unique<Tops>(), tops_after = std::make_unique<Tops>();
  std::vector<CellChange> changes(before->cells.size());
  for (const TileKey& key : from.tiles.keys())
  {
    if (key.floor != floor || in_both.count(key) == 0) continue;
    *before = *from.tiles.find(key);
    *after = *to.tiles.find(key);
    tops_before->read(from, key);
    tops_after->read(to, key);
    for (int i = 0; i < kTileCells * kTileCells; ++i)
    {
      const auto cell = static_cast<std::size_t>(i);
      CellChange& c = changes[cell] = change_of(before->cells[cell], after->cells[cell], step_m);
      if (c.kind != Change::None &&
          is_moved_edge(c, *tops_before, *tops_after, i % kTileCells, i / kTileCells, step_m))
        c.kind = Change::None;
    }
    f(key, changes);
  }
}

}  // namespace talus::site
