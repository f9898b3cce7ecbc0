#pragma once
#include <talus/site/site.h>

#include <string>
#include <vector>

namespace talus::site
{
/** Tiles that lie far from all that a floor has else: a pose jumped, and came back. */
struct Island
{
  /** All of it. */
  std::vector<TileKey> tiles;
  /** the middle of one of them, map frame */
  double x_m = 0, y_m = 0;
};

/** Distance from all other tiles that makes an island [m]. */
constexpr double kFar_m = 2000;

/** Those of a floor that would make its file enormous: the rectangle around all tiles has more than
 * 500,000 blocks of 256 x 256 cells, which take some minutes to write, and an island has less than
 * a tenth of the tiles that the largest has. */
std::vector<Island> far_islands(const Site& site, int floor);

/** What to tell of one that is left out. */
std::string text_of_left_out(const Island& island);

/** Takes the tiles of an island out of a site, and the points of its ways there. */
void leave_out(const Island& island, Site& site);

}  // namespace talus::site
