#include "site_dataset.h"

#include <algorithm>
#include <limits>

namespace talus::site
{
/** One band; its blocks are the tiles. */
class SiteBand : public GDALRasterBand
{
 public:
  SiteBand(SiteDataset& dataset, Band band) : site_(dataset), band_(band)
  {
    poDS = &dataset;
    nBand = static_cast<int>(band) + 1;
    eDataType = GDT_Float32;
    nRasterXSize = dataset.GetRasterXSize();
    nRasterYSize = dataset.GetRasterYSize();
    nBlockXSize = nBlockYSize = kTileCells;
    SetDescription(kBandNames[static_cast<std::size_t>(band)]);
  }

  double GetNoDataValue(int* has) override
  {
    if (has) *has = TRUE;
    return std::numeric_limits<double>::quiet_NaN();
  }
  const char* GetUnitType() override
  {
    return io::unit_of_band(kBandNames[static_cast<std::size_t>(band_)]);
  }
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
    const Tile* tile = site_.pyramid_.tile(site_.level_, x, y);
    constexpr std::size_t kSize = std::tuple_size<decltype(Tile::cells)>::value;
    if (!tile) std::fill_n(to, kSize, std::numeric_limits<float>::quiet_NaN());
    for (int r = 0; tile && r < kTileCells; ++r)
    {
      const SiteCell* from = tile->cells.data() + TilePyramid::row_of(site_.level_, r) * kTileCells;
      for (int c = 0; c < kTileCells; ++c)
        *to++ = values_of(from[c], site_.pyramid_.newest_s())[static_cast<std::size_t>(band_)];
    }
  }

  SiteDataset& site_;
  Band band_;
};

SiteDataset::SiteDataset(
    TilePyramid& pyramid, const GeoTransform& transform, const OGRSpatialReference& crs)
    : pyramid_(pyramid), whole_(this), transform_(transform), crs_(crs)
{
  nRasterXSize = static_cast<int>(pyramid_.width_cells(0));
  nRasterYSize = static_cast<int>(pyramid_.height_cells(0));
  const Statistics all = statistics();
  make_bands(&all);
  for (int level = 1; level < pyramid.levels(); ++level)
    overviews_.push_back(std::unique_ptr<SiteDataset>(new SiteDataset(*this, level)));
}

SiteDataset::SiteDataset(SiteDataset& whole, int level)
    : pyramid_(whole.pyramid_), whole_(&whole), level_(level), transform_(whole.transform_)
{
  make_bands(nullptr);
}

SiteDataset::Statistics SiteDataset::statistics() const
{
  Statistics all;
  pyramid_.for_each_tile(
      [&](const Tile& tile)
      {
        for (const SiteCell& cell : tile.cells)
        {
          if (!cell.known()) continue;
          const BandValues values = values_of(cell, pyramid_.newest_s());
          for (std::size_t b = 0; b < kBandCount; ++b) all[b].add(values[b]);
        }
      });
  return all;
}

void SiteDataset::make_bands(const Statistics* statistics)
{
  nRasterXSize = static_cast<int>(pyramid_.width_cells(level_));
  nRasterYSize = static_cast<int>(pyramid_.height_cells(level_));
  for (std::size_t b = 0; b < kBandCount; ++b)
  {
    SetBand(static_cast<int>(b) + 1, new SiteBand(*this, static_cast<Band>(b)));
    if (!statistics) continue;
    const double cells = static_cast<double>(nRasterXSize) * nRasterYSize;
    for (const auto& [key, value] : io::band_items(kBandNames[b], (*statistics)[b], cells))
      GetRasterBand(static_cast<int>(b) + 1)->SetMetadataItem(key.c_str(), value.c_str());
  }
  SetMetadataItem("INTERLEAVE", "PIXEL", "IMAGE_STRUCTURE");
}

CPLErr SiteDataset::IRasterIO(
    GDALRWFlag flag, int x, int y, int width, int height, void* to, int to_width, int to_height,
    GDALDataType type, int band_count, BANDMAP_TYPE bands, GSpacing pixel, GSpacing line,
    GSpacing band, GDALRasterIOExtraArg* extra)
{
  constexpr GSpacing kBand = sizeof(float), kPixel = kBand * kBandCount;
  bool all_bands = band_count == static_cast<int>(kBandCount);
  for (int b = 0; all_bands && b < band_count; ++b) all_bands = bands[b] == b + 1;
  const bool whole_cells = width == to_width && height == to_height;
  if (flag != GF_Read || type != GDT_Float32 || !all_bands || !whole_cells || band != kBand ||
      pixel != kPixel || line != kPixel * width)
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
  const int x1 = (x + width - 1) / kTileCells, y1 = (y + height - 1) / kTileCells;
  const auto covered = pyramid_.coverage(level_, x / kTileCells, y / kTileCells, x1, y1);
  if (!covered.all)
    std::fill_n(
        to, static_cast<std::size_t>(width) * height * kBandCount,
        std::numeric_limits<float>::quiet_NaN());
  for (int ty = y / kTileCells; covered.any && ty <= y1; ++ty)
    for (int tx = x / kTileCells; tx <= x1; ++tx)
    {
      const Tile* tile = pyramid_.tile(level_, tx, ty);
      if (!tile) continue;
      const int left = std::max(x, tx * kTileCells), top = std::max(y, ty * kTileCells);
      const int right = std::min(x + width, (tx + 1) * kTileCells);
      const int bottom = std::min(y + height, (ty + 1) * kTileCells);
      for (int row = top; row < bottom; ++row)
      {
        const SiteCell* from = tile->cells.data() +
                               TilePyramid::row_of(level_, row - ty * kTileCells) * kTileCells -
                               tx * kTileCells;
        float* at = to + (static_cast<std::size_t>(row - y) * width + (left - x)) * kBandCount;
        for (int column = left; column < right; ++column, at += kBandCount)
        {
          const BandValues values = values_of(from[column], pyramid_.newest_s());
          std::copy(values.begin(), values.end(), at);
        }
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
