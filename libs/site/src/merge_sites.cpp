#include <talus/site/merge.h>

#include "site_reader.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <tuple>

namespace talus::site
{
namespace
{
constexpr int kGroupTiles = 4;  //!< along each side: some blocks of the files, read together

using Places = std::vector<SiteReader::Place>;

int group_of(int tile) { return tile >= 0 ? tile / kGroupTiles : (tile + 1) / kGroupTiles - 1; }

auto order_of(const SiteReader::Place& p)
{
  return std::make_tuple(group_of(p.y), group_of(p.x), p.y, p.x);
}

/** Of all files, in groups. */
Places tiles_of(const std::vector<SiteReader>& readers)
{
  Places all;
  for (const SiteReader& reader : readers)
  {
    const Places some = reader.tiles();
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(
      all.begin(), all.end(),
      [](const auto& a, const auto& b) { return order_of(a) < order_of(b); });
  all.erase(
      std::unique(
          all.begin(), all.end(),
          [](const auto& a, const auto& b) { return a.x == b.x && a.y == b.y; }),
      all.end());
  return all;
}

/** One tile of the merged site, if a file knows a cell of it. */
class TileMerger
{
 public:
  TileMerger(const std::vector<std::string>& paths, double step_m) : step_m_(step_m)
  {
    readers_.reserve(paths.size());
    for (const std::string& path : paths) readers_.emplace_back(path);
    tiles_.resize(paths.size());
  }

  bool merge(SiteReader::Place place, Tile& to)
  {
    std::size_t found = 0;
    for (SiteReader& reader : readers_)
      if (reader.covers(place) && reader.read(place, tiles_[found])) ++found;
    std::vector<SiteCell> of_all(found);
    for (std::size_t i = 0; found > 0 && i < to.cells.size(); ++i)
    {
      for (std::size_t k = 0; k < found; ++k) of_all[k] = tiles_[k].cells[i];
      to.cells[i] = merge_cells(of_all.data(), static_cast<int>(found), step_m_);
    }
    return found > 0;
  }

 private:
  double step_m_;
  std::vector<SiteReader> readers_;
  std::vector<Tile> tiles_;
};

/** Where the threads meet. */
struct Shared
{
  const std::vector<std::string>& paths;
  const Places& places;
  const MergeOptions& options;
  const Progress& progress;
  Site& site;
  int floor;
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
};

void merge_some(Shared& s)
{
  TileMerger merger(s.paths, s.options.step_m);
  const auto tile = std::make_unique<Tile>();
  constexpr std::size_t kAtOnce = kGroupTiles * kGroupTiles;
  for (std::size_t first; (first = s.next.fetch_add(kAtOnce)) < s.places.size();)
    for (std::size_t i = first; i < std::min(first + kAtOnce, s.places.size()); ++i)
    {
      if (!merger.merge(s.places[i], *tile)) continue;
      const std::lock_guard<std::mutex> lock(s.mutex);
      s.site.tiles.at({s.floor, s.places[i].x, s.places[i].y}) = *tile;
      if (s.progress) s.progress(static_cast<double>(i) / static_cast<double>(s.places.size()));
    }
}

void merge_or_keep_failure(Shared& s)
{
  try
  {
    merge_some(s);
  }
  catch (...)
  {
    s.next = s.places.size();  // the others need not go on
    const std::lock_guard<std::mutex> lock(s.mutex);
    if (!s.failure) s.failure = std::current_exception();
  }
}

/** In an order of their own, each once. */
void add_ways(const std::vector<SiteReader>& readers, Site& site, int floor)
{
  for (const SiteReader& reader : readers)
    for (auto& way : reader.ways(floor)) site.ways.push_back(std::move(way));
  const auto of_point = [](const WayPoint& p) { return std::make_tuple(p.x_m, p.y_m, p.z_m); };
  const auto less = [&](const auto& a, const auto& b)
  {
    return std::lexicographical_compare(
        a.begin(), a.end(), b.begin(), b.end(),
        [&](const WayPoint& p, const WayPoint& q) { return of_point(p) < of_point(q); });
  };
  std::sort(site.ways.begin(), site.ways.end(), less);
  const auto same = [&](const auto& a, const auto& b) { return !less(a, b) && !less(b, a); };
  site.ways.erase(std::unique(site.ways.begin(), site.ways.end(), same), site.ways.end());
}
}  // namespace

void merge_sites(
    const std::vector<std::string>& paths, Site& site, int floor, const MergeOptions& options,
    const Progress& progress)
{
  const GdalCacheLimit limit;
  std::vector<SiteReader> readers;
  readers.reserve(paths.size());
  for (const std::string& path : paths)
  {
    readers.emplace_back(path);
    if (!site.origin && readers.size() == 1) site.origin = readers.front().origin();
    readers.back().require_fits(site);
  }
  add_ways(readers, site, floor);
  const Places places = tiles_of(readers);
  readers.clear();
  Shared shared{paths, places, options, progress, site, floor, {}, {}, {}};
  const auto cores = std::max(1U, std::thread::hardware_concurrency());
  const auto wanted = options.threads > 0 ? static_cast<unsigned>(options.threads) : cores;
  std::vector<std::thread> others;
  others.reserve(wanted);
  for (unsigned i = 1; i < wanted; ++i) others.emplace_back([&] { merge_or_keep_failure(shared); });
  merge_or_keep_failure(shared);
  for (std::thread& t : others) t.join();
  if (shared.failure) std::rethrow_exception(shared.failure);
}

}  // namespace talus::site
