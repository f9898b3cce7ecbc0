#include <talus/site/merge.h>

#include <talus/site/site_files.h>

#include "changes.h"
#include "kept_cell.h"
#include "site_reader.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <tuple>

namespace talus::site
{
namespace
{
constexpr std::size_t kComparedWith = 4;  //!< maps of a tile, each
constexpr int kGroupTiles = 4;  //!< along each side: some blocks of the files, read together

/** A file, which of the sites it belongs to, and how that is moved. */
struct Input
{
  std::string path;
  MapShift shift;
  std::uint32_t site;
};

/** A tile of one of the files. */
struct Source
{
  SiteReader::TileIndex tile;
  std::uint32_t file;
};

int group_of(int tile) { return tile >= 0 ? tile / kGroupTiles : (tile + 1) / kGroupTiles - 1; }

auto order_of(const Source& s)
{
  const auto& p = s.tile;
  return std::make_tuple(group_of(p.y), group_of(p.x), p.y, p.x, s.file);
}
bool is_same_tile(const Source& a, const Source& b)
{
  return a.tile.x == b.tile.x && a.tile.y == b.tile.y;
}

/** In an order of their own, each once. */
void sort_ways(Ways& ways)
{
  const auto of_point = [](const WayPoint& p)
  {
    return std::make_tuple(
        p.x_m, p.y_m, p.z_m, std::isnan(p.stamp_s) ? -INFINITY : p.stamp_s, p.floor);
  };
  const auto less = [&](const auto& a, const auto& b)
  {
    return std::lexicographical_compare(
        a.begin(), a.end(), b.begin(), b.end(),
        [&](const WayPoint& p, const WayPoint& q) { return of_point(p) < of_point(q); });
  };
  std::sort(ways.begin(), ways.end(), less);
  const auto same = [&](const auto& a, const auto& b) { return !less(a, b) && !less(b, a); };
  ways.erase(std::unique(ways.begin(), ways.end(), same), ways.end());
}

/** Takes over the ways and the origin of all files; their tiles, neighbours near each other, those
 * of one tile together. */
std::vector<Source> open_all(const std::vector<Input>& inputs, Site& site, int floor)
{
  std::vector<Source> sources;
  for (std::size_t i = 0; i < inputs.size(); ++i)
  {
    const MovedReader reader(inputs[i].path, inputs[i].shift);
    if (i == 0 && site.tiles.keys().empty() && !site.origin) site.origin = reader.file().origin();
    reader.file().require_fits(site);
    reader.file().add_channels_to(site);
    for (auto& way : reader.ways(floor)) site.ways.push_back(std::move(way));
    for (const auto& tile : reader.tiles())
      sources.push_back({tile, static_cast<std::uint32_t>(i)});
  }
  sort_ways(site.ways);
  std::sort(
      sources.begin(), sources.end(),
      [](const Source& a, const Source& b) { return order_of(a) < order_of(b); });
  return sources;
}

/** How many files may be open at once. */
std::size_t max_open_files()
{
  constexpr std::size_t kEnough = 256;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return kEnough;
  return std::min<std::size_t>(kEnough, limit.rlim_cur / 2);
}

/** Of one thread: files, and what it reads of them. */
class TileMerger
{
 public:
  /** `channels`: of the merged site. */
  TileMerger(
      const std::vector<Input>& inputs, const std::vector<Channel>& channels, double step_m,
      std::size_t max_open)
      : inputs_(inputs),
        channels_(channels),
        step_m_(step_m),
        max_open_(std::max<std::size_t>(1, max_open))
  {
  }

  /** One tile of the merged site from those of one tile, and the values of its channels if there
   * are any; false where no cell is known. */
  bool merge(const Source* sources, std::size_t count, Tile& to, ChannelTile& values)
  {
    files_.clear();
    for (std::size_t i = 0; i < count; ++i)
      if (read(sources[i])) compare_last();
    const std::size_t found = files_.size();
    std::vector<SiteCell> of_all(found);
    std::vector<ChannelRecord> values_of_all(found);
    for (std::size_t i = 0; found > 0 && i < to.cells.size(); ++i)
    {
      for (std::size_t k = 0; k < found; ++k) of_all[k] = tiles_[k]->cells[i];
      to.cells[i] = merge_cells(of_all.data(), static_cast<int>(found), step_m_);
      if (channels_.empty()) continue;
      for (std::size_t k = 0; k < found; ++k) values_of_all[k] = values_[k]->cells[i];
      values.cells[i] = merge_values(of_all, values_of_all);
    }
    return found > 0;
  }

  const FitsOfPairs& fits() const { return fits_; }

 private:
  struct Open
  {
    std::uint32_t file;
    std::unique_ptr<MovedReader> reader;
  };

  /** One more tile, and its values by layer of the merged site; false where no cell is known. */
  bool read(const Source& source)
  {
    const std::size_t found = files_.size();
    if (found == tiles_.size())
    {
      tiles_.push_back(std::make_unique<Tile>());
      values_.push_back(channels_.empty() ? nullptr : std::make_unique<ChannelTile>());
    }
    MovedReader& file = reader(source.file);
    const auto& channels = file.file().channels();
    if (!channels.empty() && !read_) read_ = std::make_unique<ChannelTile>();
    ChannelTile* const values = channels.empty() ? nullptr : read_.get();
    if (!file.read(source.tile, *tiles_[found], values)) return false;
    if (!channels_.empty()) *values_[found] = {};
    if (values) put_values(*values, channel_indices(channels, channels_), *values_[found]);
    files_.push_back(source.file);
    return true;
  }

  /** The tile that was read last with those before it. */
  void compare_last()
  {
    const std::size_t last = files_.size() - 1;
    for (std::size_t i = last > kComparedWith ? last - kComparedWith : 0; i < last; ++i)
      if (inputs_[files_[i]].site != inputs_[files_[last]].site)
        fits_[{inputs_[files_[i]].site, inputs_[files_[last]].site}].add(*tiles_[i], *tiles_[last]);
  }

  /** Those used last come first; the last is closed where there are too many. */
  MovedReader& reader(std::uint32_t file)
  {
    const auto found =
        std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.file == file; });
    if (found != open_.end())
      std::rotate(open_.begin(), found, found + 1);
    else
    {
      if (open_.size() >= max_open_) open_.pop_back();
      const Input& input = inputs_[file];
      open_.insert(open_.begin(), {file, std::make_unique<MovedReader>(input.path, input.shift)});
    }
    return *open_.front().reader;
  }

  const std::vector<Input>& inputs_;
  const std::vector<Channel>& channels_;
  double step_m_;
  std::size_t max_open_;
  std::vector<Open> open_;
  std::vector<std::uint32_t> files_;  //!< of the tiles
  FitsOfPairs fits_;
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<std::unique_ptr<ChannelTile>> values_;  //!< of the tiles; null without channels
  std::unique_ptr<ChannelTile> read_;  //!< as in a file
};

/** Where the threads meet. */
struct Shared
{
  const std::vector<Input>& inputs;
  const std::vector<Source>& sources;
  const std::vector<std::size_t>& begins;  //!< of the sources of each tile, and the end
  const Progress& progress;
  Site& site;
  int floor;
  double step_m;
  std::size_t max_open;  //!< by each
  std::atomic<std::size_t> next{0};
  std::mutex mutex{};
  std::exception_ptr failure{};
  FitsOfPairs fits{};

  std::size_t tiles() const { return begins.size() - 1; }
};

void merge_some(Shared& s)
{
  TileMerger merger(s.inputs, s.site.channels, s.step_m, s.max_open);
  const auto tile = std::make_unique<Tile>();
  const auto values = std::make_unique<ChannelTile>();
  constexpr std::size_t kAtOnce = std::size_t{kGroupTiles} * kGroupTiles;
  for (std::size_t first; (first = s.next.fetch_add(kAtOnce)) < s.tiles();)
    for (std::size_t i = first; i < std::min(first + kAtOnce, s.tiles()); ++i)
    {
      const Source* sources = s.sources.data() + s.begins[i];
      if (!merger.merge(sources, s.begins[i + 1] - s.begins[i], *tile, *values)) continue;
      const std::lock_guard<std::mutex> lock(s.mutex);
      const TileKey key{s.floor, sources->tile.x, sources->tile.y};
      s.site.tiles.at(key) = *tile;
      if (!s.site.channels.empty()) s.site.channel_tiles.at(key) = *values;
      if (s.progress) s.progress(static_cast<double>(i) / static_cast<double>(s.tiles()));
    }
  const std::lock_guard<std::mutex> lock(s.mutex);
  for (const auto& [pair, sums] : merger.fits()) s.fits[pair].add(sums);
}

void merge_or_keep_failure(Shared& s)
{
  try
  {
    merge_some(s);
  }
  catch (...)
  {
    s.next = s.tiles();  // the others need not go on
    const std::lock_guard<std::mutex> lock(s.mutex);
    if (!s.failure) s.failure = std::current_exception();
  }
}

/** By the floor that they become. */
std::map<int, std::vector<Input>> inputs_of(
    const std::vector<std::string>& paths, int floor, const MergeOptions& options)
{
  std::map<int, std::vector<Input>> inputs;
  for (std::size_t i = 0; i < paths.size(); ++i)
    for (const SitePart& part : parts_of_site(paths[i], floor))
      inputs[part.floor].push_back(
          {part.path, options.shifts.empty() ? MapShift{} : options.shifts.at(i),
           static_cast<std::uint32_t>(i)});
  return inputs;
}

/** Of the pairs that overlap. */
std::vector<MapFit> fits_of(const FitsOfPairs& pairs, double resolution_m)
{
  std::vector<MapFit> fits;
  for (const auto& [pair, sums] : pairs)
  {
    MapFit fit = sums.fit(resolution_m);
    std::tie(fit.first, fit.second) = pair;
    if (fit.overlap_m2 > 0) fits.push_back(fit);
  }
  return fits;
}

void merge_floor(
    const std::vector<Input>& inputs, Site& site, int floor, const MergeOptions& options,
    const Progress& progress, FitsOfPairs& fits)
{
  const std::vector<Source> sources = open_all(inputs, site, floor);
  std::vector<std::size_t> begins;
  begins.reserve(sources.size() + 1);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (i == 0 || !is_same_tile(sources[i - 1], sources[i])) begins.push_back(i);
  begins.push_back(sources.size());
  const auto cores = std::max(1U, std::thread::hardware_concurrency());
  const auto wanted = options.threads > 0 ? static_cast<unsigned>(options.threads) : cores;
  Shared shared{inputs, sources, begins,         progress,
                site,   floor,   options.step_m, max_open_files() / wanted};
  std::vector<std::thread> others;
  others.reserve(wanted);
  for (unsigned i = 1; i < wanted; ++i) others.emplace_back([&] { merge_or_keep_failure(shared); });
  merge_or_keep_failure(shared);
  for (std::thread& t : others) t.join();
  if (shared.failure) std::rethrow_exception(shared.failure);
  for (const auto& [pair, sums] : shared.fits) fits[pair].add(sums);
}
}  // namespace

std::vector<MapFit> merge_sites(
    const std::vector<std::string>& paths, Site& site, int floor, const MergeOptions& options,
    const Progress& progress)
{
  const io::GdalCacheLimit limit;
  FitsOfPairs fits;
  const auto inputs = inputs_of(paths, floor, options);
  double merged = 0;
  for (const auto& [of_floor, files] : inputs)
  {
    merge_floor(
        files, site, of_floor, options,
        [&](double done)
        {
          if (progress) progress((merged + done) / static_cast<double>(inputs.size()));
        },
        fits);
    merged += 1;
  }
  return fits_of(fits, site.resolution_m);
}

}  // namespace talus::site
