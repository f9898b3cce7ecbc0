#pragma once
#include <talus/map_view.h>
#include <talus/nav/obstacles.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace talus::nav
{
/** The highest known surface of a cell [m]; NaN where nothing is known. */
inline double top_of(float ground_m, float elevation_m)
{
  return elevation_m > ground_m || std::isnan(ground_m) ? elevation_m : ground_m;
}

/** The layers of a map by cell, and the cell below a point of the map frame. Valid until the map
 * changes. */
struct SurfaceView
{
  explicit SurfaceView(const MapView& map)
      : window(map.window()),
        ground(map.layer(Layer::GroundElevation)),
        elevation(map.layer(Layer::Elevation)),
        variance(map.layer(Layer::Variance)),
        state(map.layer(Layer::State)),
        traversability(map.layer(Layer::Traversability))
  {
  }

  std::size_t index(int ix, int iy) const
  {
    return static_cast<std::size_t>(iy) * window.cells + ix;
  }

  /** Centre of a column or row of cells, map frame [m]. */
  double x_m(int ix) const { return window.min_x_m() + (ix + 0.5) * window.resolution_m; }
  double y_m(int iy) const { return window.min_y_m() + (iy + 0.5) * window.resolution_m; }

  double top(std::size_t cell) const { return top_of(ground[cell], elevation[cell]); }

  /** Vertical distance [m] of a height z in a cell to what a sensor can see there: the ground, the
   * elevation, and in between the side of an object where it is exposed. NaN where nothing is
   * known. */
  double distance(std::size_t cell, double z) const
  {
    const double high = top(cell);
    if (std::isnan(high)) return high;
    const double low = std::isnan(ground[cell]) ? high : ground[cell];
    if (z >= high) return z - high;
    if (z <= low) return low - z;
    return exposed(cell, z) ? 0.0 : std::min(high - z, z - low);
  }

  Window window;
  const std::vector<float>&ground, &elevation, &variance, &state, &traversability;

 private:
  /** Whether one of the four neighbours ends below z, is unknown, or is outside of the window. */
  bool exposed(std::size_t cell, double z) const
  {
    const auto n = static_cast<std::size_t>(window.cells);
    const std::size_t ix = cell % n, iy = cell / n;
    if (ix == 0 || iy == 0 || ix + 1 == n || iy + 1 == n) return true;
    for (const std::size_t neighbour : {cell - 1, cell + 1, cell - n, cell + n})
      if (!(top(neighbour) >= z)) return true;
    return false;
  }
};

/** What classify_cells() and find_doubtful() say, judged once. */
struct JudgedCells
{
  std::vector<Passage> passages;
  std::vector<bool> doubtful;
};
JudgedCells judge_cells(const MapView& map, const Pose& T_map_base, const ObstacleOptions& o);

}  // namespace talus::nav
