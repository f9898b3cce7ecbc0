#include "traffic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>

namespace talus::site
{
namespace
{
/// @name What is one thing, and the same thing in the next scan
/// @{
constexpr double kGap_m = 0.5;  //!< what is so near in one scan is of one thing
constexpr double kLost_s = 1.2;  //!< after so long without a hit another thing begins
constexpr double kFastest_mps = 20;
constexpr double kNear_m = 0.6;  //!< so far off where it is looked for, and
constexpr double kOffPerWay = 0.5;  //!< so much of the way since the last scan
/// @}
/// @name The velocity by which a thing is looked for: of so long, at least
/// @{
constexpr double kLately_s = 0.8, kShortest_s = 0.25;
/// @}
/// @name The speed of a thing in a scan: of the scans so long before and after it, so many and so
/// long at least, which scatter around a line by so much of the way at most
/// @{
constexpr double kAround_s = 0.75, kMin_s = 0.4, kMaxScatter = 0.25;
constexpr std::size_t kMinScans = 3;
/// @}

struct Vector
{
  double x = 0, y = 0;
  double length() const { return std::hypot(x, y); }
};
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y}; }
Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y}; }
Vector operator*(const Vector& a, double b) { return {a.x * b, a.y * b}; }

struct HitCell
{
  TileKey tile;
  int place;
  std::int64_t x, y;  //!< of the global grid
};

/** What a scan hit of one thing. */
struct Sight
{
  double stamp_s;
  std::vector<HitCell> cells;
  /** Corners of the box around it, and its middle. Where one end is hidden, another corner tells
   * how it moves. */
  std::array<Vector, 3> corners;
  double speed_mps = NAN;

  const Vector& middle() const { return corners[1]; }
};
using Track = std::vector<Sight>;  //!< of one thing, in the order of time

Sight sight_of(double stamp_s, std::vector<HitCell> cells, double resolution_m)
{
  const auto [west, east] = std::minmax_element(
      cells.begin(), cells.end(), [](const HitCell& a, const HitCell& b) { return a.x < b.x; });
  const auto [south, north] = std::minmax_element(
      cells.begin(), cells.end(), [](const HitCell& a, const HitCell& b) { return a.y < b.y; });
  const auto corner = [&](std::int64_t x, std::int64_t y) {
    return Vector{static_cast<double>(x), static_cast<double>(y)} * resolution_m;
  };
  const Vector low = corner(west->x, south->y), high = corner(east->x + 1, north->y + 1);
  return {stamp_s, std::move(cells), {low, (low + high) * 0.5, high}};
}

/** What one scan hit, parted into things. */
std::vector<Sight> parted(double stamp_s, const std::vector<HitCell>& cells, double resolution_m)
{
  using Square = std::pair<std::int64_t, std::int64_t>;
  const double square_cells = kGap_m / 2 / resolution_m;
  const auto square = [&](std::int64_t cell) {
    return static_cast<std::int64_t>(std::floor((static_cast<double>(cell) + 0.5) / square_cells));
  };
  std::map<Square, std::vector<HitCell>> left;
  for (const HitCell& c : cells) left[{square(c.x), square(c.y)}].push_back(c);
  std::vector<Sight> things;
  while (!left.empty())
  {
    std::vector<HitCell> thing;
    std::vector<Square> open{left.begin()->first};
    while (!open.empty())
    {
      const auto found = left.find(open.back());
      const auto [x, y] = open.back();
      open.pop_back();
      if (found == left.end()) continue;
      thing.insert(thing.end(), found->second.begin(), found->second.end());
      left.erase(found);
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) open.push_back({x + dx, y + dy});
    }
    things.push_back(sight_of(stamp_s, std::move(thing), resolution_m));
  }
  return things;
}

/** The line over time through one of the corners. */
struct Line
{
  Vector velocity_mps;
  double scatter_m = 0;

  Line(Track::const_iterator first, Track::const_iterator last, std::size_t corner)
  {
    const auto n = static_cast<double>(last - first);
    double mean_s = 0;
    Vector mean;
    for (auto s = first; s != last; ++s)
      mean_s += (s->stamp_s - first->stamp_s) / n, mean = mean + s->corners[corner] * (1 / n);
    double squares_s2 = 0;
    for (auto s = first; s != last; ++s)
    {
      const double t = s->stamp_s - first->stamp_s - mean_s;
      squares_s2 += t * t;
      velocity_mps = velocity_mps + (s->corners[corner] - mean) * t;
    }
    velocity_mps = velocity_mps * (1 / squares_s2);
    for (auto s = first; s != last; ++s)
    {
      const double t = s->stamp_s - first->stamp_s - mean_s;
      const double off_m = (s->corners[corner] - mean - velocity_mps * t).length();
      scatter_m += off_m * off_m / n;
    }
    scatter_m = std::sqrt(scatter_m);
  }
};

/** How well a sight is the next of a track: how far it is from where that should be now. */
std::optional<double> off_m(const Track& track, const Sight& next)
{
  const Sight& last = track.back();
  const double since_s = next.stamp_s - last.stamp_s;
  if (since_s > kLost_s) return std::nullopt;
  const auto lately = std::find_if(
      track.begin(), track.end(),
      [&](const Sight& s) { return last.stamp_s - s.stamp_s <= kLately_s; });
  Vector from = last.middle();
  double most_m = kNear_m + kFastest_mps * since_s;
  if (last.stamp_s - lately->stamp_s >= kShortest_s)
  {
    const Vector way = Line(lately, track.end(), 1).velocity_mps * since_s;
    from = from + way;
    most_m = kNear_m + kOffPerWay * way.length();
  }
  const double off = (next.middle() - from).length();
  return off <= most_m ? std::optional(off) : std::nullopt;
}

/** Adds what a scan saw to the tracks, the nearest first; what is of none begins one. */
void follow(std::vector<Track>& tracks, std::vector<Sight> things)
{
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    for (std::size_t i = 0; i < things.size(); ++i)
      if (const auto off = off_m(tracks[t], things[i])) pairs.emplace_back(*off, t, i);
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> has_next(tracks.size()), is_taken(things.size());
  for (const auto& [off, t, i] : pairs)
  {
    if (has_next[t] || is_taken[i]) continue;
    has_next[t] = is_taken[i] = true;
    tracks[t].push_back(std::move(things[i]));
  }
  for (std::size_t i = 0; i < things.size(); ++i)
    if (!is_taken[i]) tracks.push_back({std::move(things[i])});
}

/** Where an end is hidden or out of sight its corner is slower: the fastest counts. */
void find_speeds(Track& track)
{
  for (Sight& sight : track)
  {
    const auto is_before = [&](const Sight& s) { return s.stamp_s < sight.stamp_s - kAround_s; };
    const auto is_near = [&](const Sight& s) { return s.stamp_s <= sight.stamp_s + kAround_s; };
    const auto first = std::partition_point(track.cbegin(), track.cend(), is_before);
    const auto last = std::partition_point(first, track.cend(), is_near);
    const double long_s = std::prev(last)->stamp_s - first->stamp_s;
    if (static_cast<std::size_t>(last - first) < kMinScans || long_s < kMin_s) continue;
    for (std::size_t corner = 0; corner < sight.corners.size(); ++corner)
    {
      const Line line(first, last, corner);
      const double speed_mps = line.velocity_mps.length();
      if (line.scatter_m <= kMaxScatter * speed_mps * long_s)
        sight.speed_mps = std::fmax(sight.speed_mps, speed_mps);
    }
  }
}

/** What each scan hit, in the order of time. */
std::map<double, std::vector<HitCell>> hits_of(
    const Traffic& traffic, const std::vector<TileKey>& tiles)
{
  std::map<double, std::vector<HitCell>> hits;
  for (const TileKey& key : tiles)
    for (const auto& [stamp_s, places] : traffic.at(key).hits)
      for (const int place : places)
        hits[stamp_s].push_back(
            {key, place, cell_of_tile(key.x, place % kTileCells),
             cell_of_tile(key.y, place / kTileCells)});
  return hits;
}
}  // namespace

std::map<TileKey, std::map<int, float>> speeds_of(
    const Traffic& traffic, const std::vector<TileKey>& tiles, double resolution_m)
{
  std::vector<Track> tracks;
  for (const auto& [stamp_s, cells] : hits_of(traffic, tiles))
    follow(tracks, parted(stamp_s, cells, resolution_m));
  std::map<TileKey, std::map<int, std::vector<float>>> all;
  for (Track& track : tracks)
  {
    find_speeds(track);
    for (const Sight& sight : track)
      for (const HitCell& c : sight.cells)
        if (!std::isnan(sight.speed_mps))
          all[c.tile][c.place].push_back(static_cast<float>(sight.speed_mps));
  }
  std::map<TileKey, std::map<int, float>> medians;
  for (auto& [key, places] : all)
    for (auto& [place, speeds] : places)
    {
      const auto middle = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() / 2);
      std::nth_element(speeds.begin(), middle, speeds.end());
      medians[key][place] = *middle;
    }
  return medians;
}

}  // namespace talus::site
