#include <talus/align/align.h>

#include "registration.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

namespace talus::align
{
namespace
{
constexpr double kMargin_m = 3;  //!< more than maps are moved by
constexpr int kWidest = 3000;  //!< pixels of a grid: 36 MB a layer
constexpr double kPi = 3.14159265358979323846;
constexpr double kMinHeight_m = 5e-4;  //!< less is no offset
constexpr double kMinRest = 0.1;  //!< of a cell, of which to tell
constexpr double kMinCells = 0.5;  //!< that no cell moves is no offset

using site::MapShift;
using site::MovedReader;
using Places = std::set<std::pair<std::int32_t, std::int32_t>>;

/** A map, and where it lies. */
struct Map
{
  std::string path;
  Places tiles;  //!< of the file
  double resolution_m;
  bool is_placed = false;
  Alignment alignment{};
};

Map open(const std::string& path)
{
  const MovedReader reader(path, {});
  Map map{path, {}, reader.file().info().resolution_m};
  for (const auto& tile : reader.tiles()) map.tiles.insert({tile.x, tile.y});
  return map;
}

void require_one_frame(const std::vector<std::string>& paths)
{
  const site::SiteReader first(paths.front());
  site::Site site(first.info().resolution_m, 0, "");
  site.origin = first.origin();
  for (const std::string& path : paths) site::SiteReader(path).require_fits(site);
}

/** Around the tiles of some maps. */
struct Box
{
  double min_x_m = INFINITY, min_y_m = INFINITY, max_x_m = -INFINITY, max_y_m = -INFINITY;

  void add(const Map& map)
  {
    const double side_m = site::kTileCells * map.resolution_m;
    for (const auto& [x, y] : map.tiles)
    {
      min_x_m = std::min(min_x_m, x * side_m - kMargin_m);
      max_x_m = std::max(max_x_m, (x + 1) * side_m + kMargin_m);
      min_y_m = std::min(min_y_m, y * side_m - kMargin_m);
      max_y_m = std::max(max_y_m, (y + 1) * side_m + kMargin_m);
    }
  }
  double side_m() const { return std::max(max_x_m - min_x_m, max_y_m - min_y_m); }
  /** Its pixels are whole cells. */
  Grid grid(double pixel_m) const
  {
    Grid g;
    g.pixel_m = pixel_m;
    g.min_x_m = std::floor(min_x_m / pixel_m) * pixel_m;
    g.min_y_m = std::floor(min_y_m / pixel_m) * pixel_m;
    g.width = static_cast<int>(std::ceil((max_x_m - g.min_x_m) / pixel_m)) + 1;
    g.height = static_cast<int>(std::ceil((max_y_m - g.min_y_m) / pixel_m)) + 1;
    return g;
  }
};

std::size_t common_tiles(const Map& a, const Map& b)
{
  std::size_t common = 0;
  for (const auto& place : a.tiles) common += b.tiles.count(place);
  return common;
}

/** The map that shares the most tiles with those that are placed; the first of several. */
Map& next(std::vector<Map>& maps)
{
  Map* best = nullptr;
  std::size_t most = 0;
  for (Map& map : maps)
  {
    if (map.is_placed) continue;
    std::size_t shared = 0;
    for (const Map& other : maps) shared += other.is_placed ? common_tiles(map, other) : 0;
    if (best && shared <= most) continue;
    best = &map;
    most = shared;
  }
  return *best;
}

/** Without a move that changes no cell; whole cells where there is no turn. */
MapShift rounded(Pose pose, const Box& box, double cell_m)
{
  const double reach_m = std::hypot(box.max_x_m - pose.middle.x(), box.max_y_m - pose.middle.y()) +
                         std::hypot(box.min_x_m - pose.middle.x(), box.min_y_m - pose.middle.y());
  if (std::abs(pose.yaw_rad()) * reach_m / 2 < kMinCells * cell_m) pose.v[2] = 0;
  if (std::abs(pose.v[3]) < kMinHeight_m) pose.v[3] = 0;
  MapShift shift = pose.shift();
  if (pose.v[2] != 0) return shift;
  shift.x_m = std::round(shift.x_m / cell_m) * cell_m;
  shift.y_m = std::round(shift.y_m / cell_m) * cell_m;
  return shift;
}

std::string name_of(const Eigen::Vector3d& direction)
{
  if (direction[2] != 0) return "yaw";
  double degrees = std::atan2(direction[1], direction[0]) * 180 / kPi;
  degrees = std::round(degrees < 0 ? degrees + 180 : degrees);
  if (degrees < 10 || degrees > 170) return "x";
  if (std::abs(degrees - 90) < 10) return "y";
  return "the direction at " + number_text(degrees) + " degrees";
}

std::vector<std::string> names_of(const Directions& unobservable)
{
  std::vector<std::string> names;
  names.reserve(unobservable.size());
  const auto turns = std::count_if(
      unobservable.begin(), unobservable.end(), [](const Eigen::Vector3d& d) { return d[2] != 0; });
  if (unobservable.size() - static_cast<std::size_t>(turns) == 2)  // any two directions are all
    names = {"x", "y"};
  if (!names.empty() && turns > 0) names.emplace_back("yaw");
  if (!names.empty()) return names;
  for (const Eigen::Vector3d& direction : unobservable) names.push_back(name_of(direction));
  std::sort(names.begin(), names.end());
  return names;
}

/** Lays a map onto what is placed. */
Alignment aligned(const Map& map, const Reference& placed, double pixel_m)
{
  Box box;
  box.add(map);
  Sketch sketch(box.grid(pixel_m));
  MovedReader reader(map.path, {});
  sketch.add(reader);
  const Samples samples(sketch);
  const Registration r = registered({placed, samples, pixel_m});
  Alignment a;
  a.overlaps = r.overlaps;
  if (!r.overlaps) return a;
  a.shift = rounded(r.pose, box, map.resolution_m);
  a.unobservable = names_of(r.unobservable);
  if (a.shift.yaw_rad != r.pose.turn_rad) return a;  // and moves as estimated
  Pose fine = r.fine;
  fine.v[2] = 0;
  const MapShift estimate = fine.shift();
  const double x_m = estimate.x_m - a.shift.x_m, y_m = estimate.y_m - a.shift.y_m;
  if (std::hypot(x_m, y_m) < kMinRest * map.resolution_m) return a;
  a.rest_x_m = x_m;
  a.rest_y_m = y_m;
  return a;
}

double pixel_for(const Box& all, double resolution_m)
{
  return std::max(1.0, std::ceil(all.side_m() / resolution_m / kWidest)) * resolution_m;
}
}  // namespace

std::vector<Alignment> align_sites(
    const std::vector<std::string>& paths, const site::Progress& progress)
{
  require_one_frame(paths);
  std::vector<Map> maps;
  Box all;
  for (const std::string& path : paths) all.add(maps.emplace_back(open(path)));
  const double pixel_m = pixel_for(all, maps.front().resolution_m);
  Sketch placed(all.grid(pixel_m));
  const auto place = [&](Map& map)
  {
    MovedReader reader(map.path, map.alignment.shift);
    placed.add(reader);
    map.is_placed = true;
  };
  place(maps.front());
  for (std::size_t i = 1; i < maps.size(); ++i)
  {
    if (progress) progress(static_cast<double>(i) / static_cast<double>(maps.size()));
    Map& map = next(maps);
    map.alignment = aligned(map, Reference(placed), pixel_m);
    place(map);
  }
  std::vector<Alignment> alignments;
  alignments.reserve(maps.size());
  for (Map& map : maps) alignments.push_back(std::move(map.alignment));
  return alignments;
}

}  // namespace talus::align
