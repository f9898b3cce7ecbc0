#pragma once
#include <talus/site/map_fit.h>

#include <cstddef>
#include <map>
#include <utility>

namespace talus::site
{
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
