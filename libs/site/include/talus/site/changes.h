#pragma once
#include <talus/site/site_geotiff.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace talus::site
{
/** What became of a cell between two maps. */
enum class Change : std::uint8_t
{
  None = 0,
  Built = 1,  //!< the ground is higher
  Dug = 2,  //!< the ground is lower
  Gone = 3,  //!< what stood on the ground does no more, or is lower
  Appeared = 4  //!< something stands on the ground, or is higher
};
constexpr std::size_t kChangeCount = 5;

/** What became of a cell. */
struct CellChange
{
  /** None also where change_m is NaN. */
  Change kind = Change::None;
  float change_m = NAN;  //!< of the top: what stands on the ground, else the ground
};

/** NaN unless both have seen it: measured its ground or something on it. None unless their
 * tops differ by more than `step_m`. */
CellChange change_of(const SiteCell& from, const SiteCell& to, double step_m);

/** By kind. */
struct ChangeSums
{
  /** How many cells. */
  std::array<std::size_t, kChangeCount> cells{};
  std::array<double, kChangeCount> volume_m3{};  //!< between the tops, of either sign
  /** Area of a cell. */
  double cell_m2 = 0;

  /** Of all cells of a kind. */
  double area_m2(Change c) const
  {
    return cell_m2 * static_cast<double>(cells[static_cast<std::size_t>(c)]);
  }
  /** Those of another floor of the same sites. */
  void add(const ChangeSums& other);
};

/** Whether a tile of a floor is in both sites. */
bool have_common_tile(Site& from, Site& to, int floor);

/** Writes what changed on a floor from one site to another of the same map frame: a GeoTIFF with
 * the bands change_m and kind, NaN where either has not seen the cell, and a picture. An edge that
 * moved by one cell is no change. Each file whole or not at all. Throws std::runtime_error that
 * names the file. */
ChangeSums write_changes(
    const std::string& geotiff_path, const std::string& picture_path, Site& from, Site& to,
    int floor, double step_m);

}  // namespace talus::site
