#include <talus/site/site_files.h>

#include "known_cells.h"

#include <talus/site/site_picture.h>

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
/** "DIR/site_floor_2.tif" for "DIR/site.tif". */
fs::path with_floor(const fs::path& file, int floor)
{
  if (floor == 0) return file;
  const std::string name =
      file.stem().string() + "_floor_" + std::to_string(floor) + file.extension().string();
  return file.parent_path() / name;
}

/** The floors whose files are beside that of floor 0, which need not be all up to the last. */
std::vector<int> floors_beside(const fs::path& file)
{
  constexpr int kMost = 1000;
  std::vector<int> floors;
  std::error_code ec;
  for (int floor = 1; floor < kMost; ++floor)
    if (fs::exists(with_floor(file, floor), ec)) floors.push_back(floor);
  return floors;
}

/** Those that the file names must be there. */
void require_floors(const std::string& path)
{
  const std::vector<int> floors = floors_of_site(path);
  std::error_code ec;
  for (const int floor : floors)
    if (const fs::path file = with_floor(path, floor); floor > 0 && !fs::exists(file, ec))
      throw std::runtime_error(
          file.string() + ": no such file, but " + path + " is the first of " +
          std::to_string(floors.size()) + " floors: put those of the others beside it");
}
}  // namespace

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

void write_site_files(const std::string& path, Site& site, const Progress& progress)
{
  const std::vector<int> floors = floors_of(site);
  double written = 0;
  for (const int floor : floors)
  {
    const fs::path tif = with_floor(path, floor);
    write_site(
        tif.string(), site, floor,
        [&](double done)
        {
          if (progress) progress((written + done) / static_cast<double>(floors.size()));
        });
    written += 1;
    write_site_picture(fs::path(tif).replace_extension(".png").string(), site, floor);
  }
}

void read_site_files(const std::string& path, Site& site)
{
  require_floors(path);
  read_site(path, site, 0);
  for (const int floor : floors_beside(path))
    read_site(with_floor(path, floor).string(), site, floor);
}

}  // namespace talus::site
