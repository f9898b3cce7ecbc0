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
      const std::uint32_t newest_s = site_.pyramid_.newest_s();
      for (int c = 0; c < kTileCells; ++c) *to++ = band_value(from[c], band_, newest_s);
    }
  }

  SiteDataset& site_;
  Band band_;
};

SiteDataset::SiteDataset(
    TilePyramid& pyramid, const GeoTransform& transform, const OGRSpatialReference& crs)
    : pyramid_(pyramid), whole_(this), transform_(transform), crs_(crs)
{
  make_bands();
  for (int level = 1; level < pyramid.levels(); ++level)
    overviews_.push_back(std::unique_ptr<SiteDataset>(new SiteDataset(*this, level)));
}

SiteDataset::SiteDataset(SiteDataset& whole, int level)
    : pyramid_(whole.pyramid_), whole_(&whole), level_(level), transform_(whole.transform_)
{
  make_bands();
}

void SiteDataset::make_bands()
{
  nRasterXSize = static_cast<int>(pyramid_.width_cells(level_));
  nRasterYSize = static_cast<int>(pyramid_.height_cells(level_));
  for (std::size_t b = 0; b < kBandCount; ++b)
    SetBand(static_cast<int>(b) + 1, new SiteBand(*this, static_cast<Band>(b)));
  SetMetadataItem("INTERLEAVE", "PIXEL", "IMAGE_STRUCTURE");
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
