#include <talus/site/site_files.h>

#include "kept_cell.h"
#include "known_cells.h"
#include "site_metadata.h"

#include <talus/site/islands.h>

#include <cstdint>
#include <filesystem>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace talus::site
{
namespace
{
constexpr std::size_t kMemoryOfPart_bytes = std::size_t{64} << 20;

/** "DIR/site_NAME_2.tif" for "DIR/site.tif". */
std::string with_number(const fs::path& file, const std::string& name, std::size_t number)
{
  if (number == 0) return file.string();
  const std::string named =
      file.stem().string() + "_" + name + "_" + std::to_string(number) + file.extension().string();
  return (file.parent_path() / named).string();
}

/** The numbers of the files that are named, and of those that are beside the first all the same. A
 * file that is named must be there. */
template <class F>
std::set<std::size_t> numbers_beside(
    const std::string& path, const std::set<std::size_t>& named, const std::string& what,
    const F& with)
{
  constexpr int kWidestGap = 16;
  std::error_code ec;
  for (const std::size_t n : named)
    if (n > 0 && !fs::exists(with(path, n), ec))
      throw std::runtime_error(
          with(path, n) + ": no such file, but " + path + " is the first of " +
          std::to_string(named.size()) + what + ": put those of the others beside it");
  std::set<std::size_t> beside = named;
  int missing = 0;
  for (std::size_t n = 1; missing < kWidestGap; ++n)
    if (missing = fs::exists(with(path, n), ec) ? 0 : missing + 1; missing == 0) beside.insert(n);
  return beside;
}

/** The file of a floor and its islands. What that file says. */
SiteInfo add_floor(const std::string& path, int floor, std::vector<SitePart>& parts)
{
  parts.push_back({path, floor});
  SiteInfo info = info_of_site(path);
  std::set<std::size_t> named;
  for (std::size_t i = 0; i <= info.islands; ++i) named.insert(i);
  for (const std::size_t i : numbers_beside(path, named, " islands", with_island))
    if (i > 0) parts.push_back({with_island(path, i), floor});
  return info;
}

/** Copies an island into a site of its own. */
void copy(const Island& island, Site& from, Site& to)
{
  to.name = from.name;
  to.origin = from.origin;
  to.ways = ways_on(island, from);
  to.channels = from.channels;
  for (const TileKey& key : island.tiles)
  {
    to.tiles.at(key) = *from.tiles.find(key);
    if (const ChannelTile* values = from.channel_tiles.find(key))
      to.channel_tiles.at(key) = *values;
  }
}

/** The first floor has the name of all. */
std::string file_of_floor(const std::string& path, const std::vector<int>& floors, int floor)
{
  return path.empty() || floor == floors.front() ? path : with_floor(path, floor);
}

/** A floor, its islands and its ways. */
void write_floor_files(
    const std::string& path, const std::string& picture, Site& site, int floor, Far far,
    const Progress& progress)
{
  const auto islands = far == Far::Apart ? islands_of(site, floor) : std::vector<Island>();
  if (islands.empty())
  {
    write_site(path, site, floor, progress);
    if (!picture.empty()) write_site_picture(picture, site, floor);
    write_way(way_file_of(path), site, floor);
    return;
  }
  const FileOfFloor first{floor, floors_of(site), islands.size() - 1};
  for (std::size_t i = 0; i < islands.size(); ++i)
  {
    Site part(site.resolution_m, kMemoryOfPart_bytes, fs::absolute(path).parent_path().string());
    copy(islands[i], site, part);
    write_site_file(
        with_island(path, i), part, i == 0 ? first : FileOfFloor{floor, {}, 0},
        [&](double done)
        {
          const auto before = static_cast<double>(i), all = static_cast<double>(islands.size());
          if (progress) progress((before + done) / all);
        });
    if (!picture.empty())
      write_site_picture(
          with_island(picture, i), part, floor,
          i > 0 ? "island " + std::to_string(i) : std::string());
  }
  write_way(way_file_of(path), site, floor);
}
}  // namespace

std::string with_floor(const std::string& path, int floor)
{
  return with_number(path, "floor", static_cast<std::size_t>(floor));
}

std::string with_island(const std::string& path, std::size_t island)
{
  return with_number(path, "island", island);
}

std::vector<int> floors_of(const Site& site)
{
  std::set<int> floors;
  for (const TileKey& key : site.tiles.keys()) floors.insert(key.floor);
  return {floors.begin(), floors.end()};
}

KnownCells known_cells(Site& site)
{
  KnownCells known;
  for (const TileKey& key : site.tiles.keys())
    for_each_known_of_tile(
        site, key,
        [&](std::int64_t, std::int64_t, const SiteCell& c)
        {
          if (c.cell.state < known.by_state.size() && !is_unproved(c.cell))
            ++known.by_state[c.cell.state];
        });
  const auto count = std::accumulate(known.by_state.begin(), known.by_state.end(), std::size_t{0});
  known.area_m2 = static_cast<double>(count) * site.resolution_m * site.resolution_m;
  return known;
}

void write_site_files(
    const std::string& path, const std::string& picture, Site& site, const Progress& progress,
    Far far)
{
  const std::vector<int> floors = floors_of(site);
  double written = 0;
  for (const int floor : floors)
  {
    write_floor_files(
        file_of_floor(path, floors, floor), file_of_floor(picture, floors, floor), site, floor, far,
        [&](double done)
        {
          if (progress) progress((written + done) / static_cast<double>(floors.size()));
        });
    written += 1;
  }
}

std::vector<std::string> texts_of_islands(const std::string& path, Site& site)
{
  std::vector<std::string> texts;
  const std::vector<int> floors = floors_of(site);
  for (const int floor : floors)
  {
    const auto islands = islands_of(site, floor);
    for (std::size_t i = 1; i < islands.size(); ++i)
      texts.push_back(
          text_of_island(islands[i], with_island(file_of_floor(path, floors, floor), i)));
  }
  return texts;
}

std::vector<SitePart> parts_of_site(const std::string& path, int floor)
{
  std::vector<SitePart> parts;
  const SiteInfo info = add_floor(path, floor, parts);
  const auto own = static_cast<std::size_t>(info.floor);
  const auto with = [own](const std::string& first, std::size_t n)
  { return n == own ? first : with_floor(first, static_cast<int>(n)); };
  for (const std::size_t n :
       numbers_beside(path, {info.floors.begin(), info.floors.end()}, " floors", with))
    if (n != own && n > 0) add_floor(with(path, n), static_cast<int>(n), parts);
  return parts;
}

void read_site_files(const std::string& path, Site& site, const MapShift& shift)
{
  for (const SitePart& part : parts_of_site(path, 0)) read_site(part.path, site, part.floor, shift);
}

}  // namespace talus::site
