#include <talus/site/site_files.h>

#include "known_cells.h"
#include "site_file.h"

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

/** The floors whose files are beside that of floor 0, which need not be all up to the last. */
std::vector<int> floors_beside(const std::string& file)
{
  constexpr int kMost = 1000;
  std::vector<int> floors;
  std::error_code ec;
  for (int floor = 1; floor < kMost; ++floor)
    if (fs::exists(with_floor(file, floor), ec)) floors.push_back(floor);
  return floors;
}

/** A file that another one names must be there. */
void require_part(const std::string& part, const std::string& of, const std::string& what)
{
  std::error_code ec;
  if (!fs::exists(part, ec))
    throw std::runtime_error(
        part + ": no such file, but " + of + " is the first of " + what +
        ": put those of the others beside it");
}

void require_parts(const std::string& path)
{
  const SiteInfo info = info_of_site(path);
  for (const int floor : info.floors)
    require_part(with_floor(path, floor), path, std::to_string(info.floors.size()) + " floors");
  for (std::size_t i = 1; i <= info.islands; ++i)
    require_part(with_island(path, i), path, std::to_string(info.islands + 1) + " islands");
}

void read_floor_files(const std::string& path, Site& site, int floor)
{
  require_parts(path);
  read_site(path, site, floor);
  for (std::size_t i = info_of_site(path).islands; i > 0; --i)
    read_site(with_island(path, i), site, floor);
}

/** Copies an island into a site of its own. */
void copy(const Island& island, Site& from, Site& to)
{
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

std::string title_of(int floor, std::size_t island)
{
  if (island == 0) return "";
  return (floor > 0 ? "Site map, floor " + std::to_string(floor) : "Site map") + ", island " +
         std::to_string(island);
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
          if (c.cell.state < known.by_state.size()) ++known.by_state[c.cell.state];
        });
  const auto count = std::accumulate(known.by_state.begin(), known.by_state.end(), std::size_t{0});
  known.area_m2 = static_cast<double>(count) * site.resolution_m * site.resolution_m;
  return known;
}

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
      write_site_picture(with_island(picture, i), part, floor, title_of(floor, i));
  }
  write_way(way_file_of(path), site, floor);
}

void write_site_files(const std::string& path, Site& site, const Progress& progress, Far far)
{
  const std::vector<int> floors = floors_of(site);
  double written = 0;
  for (const int floor : floors)
  {
    const std::string tif = with_floor(path, floor);
    write_floor_files(
        tif, fs::path(tif).replace_extension(".png").string(), site, floor, far,
        [&](double done)
        {
          if (progress) progress((written + done) / static_cast<double>(floors.size()));
        });
    written += 1;
  }
}

void read_site_files(const std::string& path, Site& site)
{
  read_floor_files(path, site, 0);
  for (const int floor : floors_beside(path))
    read_floor_files(with_floor(path, floor), site, floor);
}

}  // namespace talus::site
