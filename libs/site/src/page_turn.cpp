#include "site_raster.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace talus::site
{
namespace
{
constexpr double kWorthTurning = 0.5;  //!< of the area that the page has north up

/** The corners of the outermost cells of each row of a tile. */
void add_outline(Site& site, const TileKey& key, std::vector<cv::Point2f>& points)
{
  struct Ends
  {
    std::int64_t first = std::numeric_limits<std::int64_t>::max(), last = -first;
  };
  std::array<Ends, kTileCells> rows;
  for_each_known_of_tile(
      site, key,
      [&](std::int64_t x, std::int64_t y, const SiteCell&)
      {
        Ends& row = rows[static_cast<std::size_t>(index_in_tile(y))];
        row = {std::min(row.first, x), std::max(row.last, x)};
      });
  for (int row = 0; row < kTileCells; ++row)
  {
    const Ends& ends = rows[static_cast<std::size_t>(row)];
    if (ends.last < ends.first) continue;
    for (const int side : {row, row + 1})
    {
      const auto y = static_cast<float>(std::int64_t{key.y} * kTileCells + side);
      points.emplace_back(static_cast<float>(ends.first), y);
      points.emplace_back(static_cast<float>(ends.last + 1), y);
    }
  }
}

/** Whether all of a tile lies within the hull, so that it cannot widen it. */
bool is_inside(const std::vector<cv::Point2f>& hull, const TileKey& key)
{
  if (hull.size() < 3) return false;
  const std::array<float, 2> xs{
      static_cast<float>(key.x) * kTileCells, static_cast<float>(key.x + 1) * kTileCells};
  const std::array<float, 2> ys{
      static_cast<float>(key.y) * kTileCells, static_cast<float>(key.y + 1) * kTileCells};
  for (const float x : xs)
    for (const float y : ys)
      if (cv::pointPolygonTest(hull, {x, y}, false) < 0) return false;
  return true;
}

std::vector<cv::Point2f> hull_of(Site& site, int floor)
{
  std::vector<cv::Point2f> hull;
  for (const TileKey& key : site.tiles.keys())
  {
    if (key.floor != floor || is_inside(hull, key)) continue;
    std::vector<cv::Point2f> points = hull;
    add_outline(site, key, points);
    if (!points.empty()) cv::convexHull(points, hull);
  }
  return hull;
}

PageTurn turned(const std::vector<cv::Point2f>& hull, double rad)
{
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PageTurn t{rad, kFar, -kFar, kFar, -kFar};
  for (const cv::Point2f& p : hull)
  {
    const double x = std::cos(rad) * p.x - std::sin(rad) * p.y;
    const double y = std::sin(rad) * p.x + std::cos(rad) * p.y;
    t.min_x = std::min(t.min_x, x);
    t.max_x = std::max(t.max_x, x);
    t.min_y = std::min(t.min_y, y);
    t.max_y = std::max(t.max_y, y);
  }
  return t;
}

double area(const PageTurn& t) { return (t.max_x - t.min_x) * (t.max_y - t.min_y); }
}  // namespace

PageTurn page_turn(Site& site, int floor)
{
  constexpr double kRight_rad = 1.57079632679489661923;
  const auto hull = hull_of(site, floor);
  PageTurn best = turned(hull, 0);
  const double as_it_is = area(best);
  for (std::size_t i = 0; i < hull.size(); ++i)  // the smallest box has a side along the hull
  {
    const cv::Point2f along = hull[(i + 1) % hull.size()] - hull[i];
    const double rad = -std::remainder(std::atan2(along.y, along.x), kRight_rad);
    const PageTurn t = turned(hull, rad);
    if (area(t) < area(best) && area(t) < kWorthTurning * as_it_is) best = t;
  }
  return best;
}

}  // namespace talus::site
