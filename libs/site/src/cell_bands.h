#pragma once
#include <talus/layers.h>
#include <talus/site/tile_store.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

// A cell of a site in the bands of its GeoTIFF, and back with the same bits.
namespace talus::site
{
enum class Band : std::size_t
{
  Traversability = 0,
  GroundElevation,
  Elevation,
  Variance,
  State,  //!< NaN where the cell is unknown, as in all bands
  Reached,  //!< a part of the evidence; files of older versions have it there alone
  Age,  //!< [s] whole, before the newest cell of the file, see Shape
  ElevationVariance,
  Evidence,  //!< the first three bytes of CellRecord::evidence, the first the lowest
  Shape  //!< the next two, then what a float32 cannot hold of an age above 194 days
};
constexpr std::size_t kBandCount = 10;
constexpr std::array<const char*, kBandCount> kBandNames{
    "traversability",     "ground_elevation", "elevation", "variance", "state", "reached", "age",
    "elevation_variance", "evidence",         "shape"};

/** The layers of a map among them, which come first. */
constexpr std::array kKeptLayers{Layer::Traversability, Layer::GroundElevation, Layer::Elevation,
                                 Layer::Variance,       Layer::State,           Layer::Reached};

/** Their values. NaN has one bit pattern. */
std::array<float, kKeptLayers.size()> kept_values(const CellRecord& cell);

using BandValues = std::array<float, kBandCount>;

/** `newest_s`: of all cells of the file. NaN has one bit pattern. */
BandValues values_of(const SiteCell& cell, std::uint32_t newest_s);

/** A number that changes with any bit of the known cells of a tile: bits flip on disks and cables.
 */
class TileSum
{
 public:
  /** Cells in the order of Tile; all their bands, those of channels last. */
  void add(const float* bands, std::size_t count);
  std::uint32_t value() const { return static_cast<std::uint32_t>(sum_ >> 32); }

 private:
  std::uint64_t sum_ = 0, cell_ = 0;
};

/** The cell that has these values: unknown where the state is NaN or 0. Nothing where they are none
 * of a site. */
std::optional<SiteCell> cell_of(const BandValues& values, std::uint32_t newest_s);

}  // namespace talus::site
