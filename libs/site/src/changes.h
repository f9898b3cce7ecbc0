#pragma once
#include <talus/site/changes.h>
#include <talus/site/merge.h>

#include <cstddef>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "site_raster.h"

namespace talus::site
{
using OnTile = std::function<void(const TileKey&, const std::vector<CellChange>&)>;

/** Calls f for each tile that both sites have on a floor, with a change for each of its cells. An
 * edge that moved by one cell is none. */
void for_each_compared_tile(Site& from, Site& to, int floor, double step_m, const OnTile& f);

void write_changes_picture(
    const std::string& path, Site& from, Site& to, int floor, double step_m,
    const ChangeSums& sums);

/** What is counted of two maps, tile by tile; the order makes no difference. */
class FitSums
{
 public:
  /** Two tiles of one place. */
  void add(const Tile& first, const Tile& second);
  void add(const FitSums& other);
  MapFit fit(double resolution_m) const;

 private:
  void add_standing(const Tile& first, const Tile& second);
  double median_m() const;

  std::size_t both_ = 0, ground_ = 0, ground_disagrees_ = 0;
  std::size_t standing_ = 0, standing_disagrees_ = 0;
  std::map<int, std::size_t> offsets_;  //!< how many of each, in 0.1 mm
};

/** Of each two maps that were compared. */
using FitsOfPairs = std::map<std::pair<std::size_t, std::size_t>, FitSums>;

}  // namespace talus::site
