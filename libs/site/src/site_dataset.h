#pragma once
#include "cell_bands.h"
#include "site_metadata.h"
#include "tile_pyramid.h"

#include <bands.h>

#include <gdal_priv.h>

#include <array>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#ifndef BANDMAP_TYPE  // of GDAL before 3.10
#define BANDMAP_TYPE int*
#endif

namespace talus::site
{
/** What GDAL copies into a file: reads blocks from the tiles when it is asked for them. */
class SiteDataset : public GDALDataset
{
 public:
  using GeoTransform = std::array<double, 6>;

  /** `channels`: of the site; their layers are the last bands. */
  SiteDataset(
      TilePyramid& pyramid, const std::vector<Channel>& channels, const GeoTransform& transform,
      const OGRSpatialReference& crs);
  ~SiteDataset() override = default;

  CPLErr GetGeoTransform(double* to) override;
  const OGRSpatialReference* GetSpatialRef() const override { return &crs_; }

  /** Of its tiles. */
  const TileSums& sums() const { return sums_; }
  /** Throws again what a tile threw while GDAL read. */
  void rethrow() const;

 protected:
  /** All bands of a block at once, as the driver asks for them: much faster than one by one. */
  CPLErr IRasterIO(
      GDALRWFlag flag, int x, int y, int width, int height, void* to, int to_width, int to_height,
      GDALDataType type, int band_count, BANDMAP_TYPE bands, GSpacing pixel, GSpacing line,
      GSpacing band, GDALRasterIOExtraArg* extra) override;

 private:
  friend class SiteBand;
  using Statistics = std::vector<io::BandStatistics>;
  SiteDataset(SiteDataset& whole, int level);
  void make_bands(const Statistics* statistics);
  Statistics look_at_tiles();
  void read_pixels(int x, int y, int width, int height, float* to) const;
  /** All bands of a cell; `values`: of the channels of its tile, or null. */
  void put_cell(const Tile& tile, const ChannelTile* values, std::size_t at, float* to) const;

  TilePyramid& pyramid_;
  SiteDataset* whole_;  //!< this, or that of which this is an overview
  int level_ = 0;
  GeoTransform transform_;
  OGRSpatialReference crs_;
  std::vector<std::string> names_;  //!< of the bands
  TileSums sums_;
  std::vector<std::unique_ptr<SiteDataset>> overviews_;
  std::exception_ptr failure_;
};

}  // namespace talus::site
