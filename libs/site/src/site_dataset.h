#pragma once
#include "cell_bands.h"
#include "tile_pyramid.h"

#include <gdal_priv.h>

#include <array>
#include <exception>
#include <memory>
#include <vector>

namespace talus::site
{
/** What GDAL copies into a file: reads blocks from the tiles when it is asked for them. */
class SiteDataset : public GDALDataset
{
 public:
  using GeoTransform = std::array<double, 6>;

  SiteDataset(TilePyramid& pyramid, const GeoTransform& transform, const OGRSpatialReference& crs);
  ~SiteDataset() override = default;

  CPLErr GetGeoTransform(double* to) override;
  const OGRSpatialReference* GetSpatialRef() const override { return &crs_; }

  /** Throws again what a tile threw while GDAL read. */
  void rethrow() const;

 private:
  friend class SiteBand;
  SiteDataset(SiteDataset& whole, int level);
  void make_bands();

  TilePyramid& pyramid_;
  SiteDataset* whole_;  //!< this, or that of which this is an overview
  int level_ = 0;
  GeoTransform transform_;
  OGRSpatialReference crs_;
  std::vector<std::unique_ptr<SiteDataset>> overviews_;
  std::exception_ptr failure_;
};

}  // namespace talus::site
