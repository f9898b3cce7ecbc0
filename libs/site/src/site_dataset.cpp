#include "site_dataset.h"

#include <algorithm>
#include <limits>

namespace talus::site
{
/** One band; its blocks are the tiles. */
class SiteBand : public GDALRasterBand
{
 public:
  SiteBand(SiteDataset& dataset, std::size_t band) : site_(dataset), band_(band)
  {
    poDS = &dataset;
    nBand = static_cast<int>(band) + 1;
    eDataType = GDT_Float32;
    nRasterXSize = dataset.GetRasterXSize();
    nRasterYSize = dataset.GetRasterYSize();
    nBlockXSize = nBlockYSize = kTileCells;
    SetDescription(dataset.names_[band].c_str());
  }

  double GetNoDataValue(int* has) override
  {
    if (has) *has = TRUE;
    return std::numeric_limits<double>::quiet_NaN();
  }
  const char* GetUnitType() override { return io::unit_of_band(site_.names_[band_]); }
  int GetOverviewCount() override { return static_cast<int>(site_.overviews_.size()); }
  GDALRasterBand* GetOverview(int i) override
  {
    return i < 0 || i >= GetOverviewCount() ? nullptr : site_.overviews_[i]->GetRasterBand(nBand);
  }

 protected:
  CPLErr IReadBlock(int x, int y, void* block) override
  {
    try
    {
      read(x, y, static_cast<float*>(block));
      return CE_None;
    }
    catch (...)
    {
      site_.whole_->failure_ = std::current_exception();
      return CE_Failure;
    }
  }

  int IGetDataCoverageStatus(
      int x, int y, int width, int height, int /*stop_at*/, double* percent) override
  {
    const auto covered = site_.pyramid_.coverage(
        site_.level_, x / kTileCells, y / kTileCells, (x + width - 1) / kTileCells,
        (y + height - 1) / kTileCells);
    if (percent) *percent = covered.all ? 100 : covered.any ? 50 : 0;  // roughly
    return (covered.any ? GDAL_DATA_COVERAGE_STATUS_DATA : 0) |
           (covered.all ? 0 : GDAL_DATA_COVERAGE_STATUS_EMPTY);
  }

 private:
  void read(int x, int y, float* to)
  {
    constexpr int kSize = kTileCells * kTileCells;
    const std::size_t bands = site_.names_.size();
    std::vector<float> all(bands * kSize);
    site_.read_pixels(x * kTileCells, y * kTileCells, kTileCells, kTileCells, all.data());
    for (std::size_t i = 0; i < kSize; ++i) to[i] = all[i * bands + band_];
  }

  SiteDataset& site_;
  std::size_t band_;
};

SiteDataset::SiteDataset(
    TilePyramid& pyramid, const std::vector<Channel>& channels, const GeoTransform& transform,
    const OGRSpatialReference& crs)
    : pyramid_(pyramid),
      whole_(this),
      transform_(transform),
      crs_(crs),
      names_(kBandNames.begin(), kBandNames.end())
{
  for (const std::string& name : channel_layer_names(channels)) names_.push_back(name);
  nRasterXSize = static_cast<int>(pyramid_.width_cells(0));
  nRasterYSize = static_cast<int>(pyramid_.height_cells(0));
  const Statistics all = look_at_tiles();
  make_bands(&all);
  for (int level = 1; level < pyramid.levels(); ++level)
    overviews_.push_back(std::unique_ptr<SiteDataset>(new SiteDataset(*this, level)));
}

SiteDataset::SiteDataset(SiteDataset& whole, int level)
    : pyramid_(whole.pyramid_),
      whole_(&whole),
      level_(level),
      transform_(whole.transform_),
      names_(whole.names_)
{
  make_bands(nullptr);
}

SiteDataset::Statistics SiteDataset::look_at_tiles()
{
  Statistics all(names_.size());
  std::vector<float> cell(names_.size());
  pyramid_.for_each_tile(
      [&](const TileKey& key, const Tile& tile, const ChannelTile* values)
      {
        TileSum sum;
        for (std::size_t i = 0; i < tile.cells.size(); ++i)
        {
          put_cell(tile, values, i, cell.data());
          sum.add(cell.data(), cell.size());
          if (!tile.cells[i].known()) continue;
          for (std::size_t b = 0; b < cell.size(); ++b) all[b].add(cell[b]);
        }
        sums_[{key.x, key.y}] = sum.value();
      });
  return all;
}

void SiteDataset::put_cell(
    const Tile& tile, const ChannelTile* values, std::size_t at, float* to) const
{
  const BandValues of_cell = values_of(tile.cells[at], pyramid_.newest_s());
  to = std::copy(of_cell.begin(), of_cell.end(), to);
  const std::size_t layers = names_.size() - kBandCount;
  if (values && tile.cells[at].known())
    std::copy_n(values->cells[at].values, layers, to);
  else
    std::fill_n(to, layers, std::numeric_limits<float>::quiet_NaN());
}

void SiteDataset::make_bands(const Statistics* statistics)
{
  nRasterXSize = static_cast<int>(pyramid_.width_cells(level_));
  nRasterYSize = static_cast<int>(pyramid_.height_cells(level_));
  for (std::size_t b = 0; b < names_.size(); ++b)
  {
    SetBand(static_cast<int>(b) + 1, new SiteBand(*this, b));
    if (!statistics) continue;
    const double cells = static_cast<double>(nRasterXSize) * nRasterYSize;
    for (const auto& [key, value] : io::band_items(names_[b], (*statistics)[b], cells))
      GetRasterBand(static_cast<int>(b) + 1)->SetMetadataItem(key.c_str(), value.c_str());
  }
  SetMetadataItem("INTERLEAVE", "PIXEL", "IMAGE_STRUCTURE");
}

CPLErr SiteDataset::IRasterIO(
    GDALRWFlag flag, int x, int y, int width, int height, void* to, int to_width, int to_height,
    GDALDataType type, int band_count, BANDMAP_TYPE bands, GSpacing pixel, GSpacing line,
    GSpacing band, GDALRasterIOExtraArg* extra)
{
  constexpr GSpacing kBand = sizeof(float);
  const GSpacing cell = kBand * GetRasterCount();
  bool all_bands = band_count == GetRasterCount();
  for (int b = 0; all_bands && b < band_count; ++b) all_bands = bands[b] == b + 1;
  const bool whole_cells = width == to_width && height == to_height;
  if (flag != GF_Read || type != GDT_Float32 || !all_bands || !whole_cells || band != kBand ||
      pixel != cell || line != cell * width)
    return GDALDataset::IRasterIO(
        flag, x, y, width, height, to, to_width, to_height, type, band_count, bands, pixel, line,
        band, extra);
  try
  {
    read_pixels(x, y, width, height, static_cast<float*>(to));
    return CE_None;
  }
  catch (...)
  {
    whole_->failure_ = std::current_exception();
    return CE_Failure;
  }
}

void SiteDataset::read_pixels(int x, int y, int width, int height, float* to) const
{
  const std::size_t bands = names_.size();
  const int x1 = (x + width - 1) / kTileCells, y1 = (y + height - 1) / kTileCells;
  const auto covered = pyramid_.coverage(level_, x / kTileCells, y / kTileCells, x1, y1);
  if (!covered.all)
    std::fill_n(
        to, static_cast<std::size_t>(width) * height * bands,
        std::numeric_limits<float>::quiet_NaN());
  for (int ty = y / kTileCells; covered.any && ty <= y1; ++ty)
    for (int tx = x / kTileCells; tx <= x1; ++tx)
    {
      const Tile* tile = pyramid_.tile(level_, tx, ty);
      if (!tile) continue;
      const ChannelTile* const values =
          bands > kBandCount ? pyramid_.values(level_, tx, ty) : nullptr;
      const int left = std::max(x, tx * kTileCells), top = std::max(y, ty * kTileCells);
      const int right = std::min(x + width, (tx + 1) * kTileCells);
      const int bottom = std::min(y + height, (ty + 1) * kTileCells);
      for (int row = top; row < bottom; ++row)
      {
        const int first =
            TilePyramid::row_of(level_, row - ty * kTileCells) * kTileCells - tx * kTileCells;
        float* at = to + (static_cast<std::size_t>(row - y) * width + (left - x)) * bands;
        for (int column = left; column < right; ++column, at += bands)
          put_cell(*tile, values, static_cast<std::size_t>(first + column), at);
      }
    }
}

CPLErr SiteDataset::GetGeoTransform(double* to)
{
  std::copy(transform_.begin(), transform_.end(), to);
  return CE_None;
}

void SiteDataset::rethrow() const
{
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace talus::site
