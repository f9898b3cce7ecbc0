#include "site_reader.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace talus::site
{
namespace
{
void raise(SiteCell& s, double by_m)
{
  if (by_m == 0 || !s.known()) return;
  const auto raised = [&](float height_m) { return static_cast<float>(height_m + by_m); };
  s.cell.ground_m = raised(s.cell.ground_m);
  s.cell.elevation_m = raised(s.cell.elevation_m);
}
}  // namespace

MovedReader::MovedReader(const std::string& path, const MapShift& shift)
    : file_(path), shift_(shift)
{
}

Ways MovedReader::ways(int floor) const
{
  Ways ways = file_.ways(floor);
  if (!shift_.moves()) return ways;
  for (auto& way : ways)
    for (WayPoint& p : way)
    {
      double x_m = p.x_m, y_m = p.y_m;
      shift_.apply(x_m, y_m);
      p.x_m = static_cast<float>(x_m);
      p.y_m = static_cast<float>(y_m);
      p.z_m = static_cast<float>(p.z_m + shift_.z_m);
    }
  return ways;
}

std::set<MovedReader::Key> MovedReader::below(SiteReader::TileIndex tile, bool of_file) const
{
  const double side_m = kTileCells * file_.info().resolution_m;
  double min_x = INFINITY, min_y = INFINITY, max_x = -INFINITY, max_y = -INFINITY;
  for (const int dx : {0, 1})
    for (const int dy : {0, 1})
    {
      double x_m = (tile.x + dx) * side_m, y_m = (tile.y + dy) * side_m;
      of_file ? shift_.undo(x_m, y_m) : shift_.apply(x_m, y_m);
      min_x = std::min(min_x, x_m);
      max_x = std::max(max_x, x_m);
      min_y = std::min(min_y, y_m);
      max_y = std::max(max_y, y_m);
    }
  const auto index = [&](double at_m)
  { return static_cast<std::int32_t>(std::floor(at_m / side_m)); };
  std::set<Key> tiles;
  for (std::int32_t x = index(min_x); x <= index(max_x); ++x)
    for (std::int32_t y = index(min_y); y <= index(max_y); ++y) tiles.insert({x, y});
  return tiles;
}

std::vector<SiteReader::TileIndex> MovedReader::tiles() const
{
  auto of_file = file_.tiles();
  if (!shift_.moves_cells()) return of_file;
  std::set<Key> all;
  for (const auto& tile : of_file) all.merge(below(tile, false));
  std::vector<SiteReader::TileIndex> places;
  places.reserve(all.size());
  for (const auto& [x, y] : all) places.push_back({x, y});
  return places;
}

void MovedReader::list_tiles()
{
  if (!there_.empty()) return;
  for (const auto& tile : file_.tiles()) there_.insert({tile.x, tile.y});
}

bool MovedReader::read(SiteReader::TileIndex tile, Tile& to, ChannelTile* values)
{
  if (shift_.moves_cells()) return read_moved(tile, to, values);
  const bool any = file_.read(tile, to, values);
  if (shift_.z_m != 0)
    for (SiteCell& s : to.cells) raise(s, shift_.z_m);
  return any;
}

bool MovedReader::read_moved(SiteReader::TileIndex tile, Tile& to, ChannelTile* values)
{
  struct Source
  {
    Tile tile;
    ChannelTile values;
  };
  list_tiles();
  std::map<Key, std::unique_ptr<Source>> from;
  for (const Key& key : below(tile, true))
    if (there_.count(key) > 0)
    {
      auto& source = from[key] = std::make_unique<Source>();
      file_.read({key.first, key.second}, source->tile, values ? &source->values : nullptr);
    }
  const double resolution_m = file_.info().resolution_m;
  bool any = false;
  for (int i = 0; i < kTileCells * kTileCells; ++i)
  {
    double x_m = middle_of_cell_m(cell_of_tile(tile.x, i % kTileCells), resolution_m);
    double y_m = middle_of_cell_m(cell_of_tile(tile.y, i / kTileCells), resolution_m);
    shift_.undo(x_m, y_m);
    const auto x = static_cast<std::int64_t>(std::floor(x_m / resolution_m));
    const auto y = static_cast<std::int64_t>(std::floor(y_m / resolution_m));
    const auto found = from.find({tile_of(x), tile_of(y)});
    const auto in_to = static_cast<std::size_t>(i);
    const auto at = static_cast<std::size_t>(index_in_tile(y) * kTileCells + index_in_tile(x));
    const Source* const source = found == from.end() ? nullptr : found->second.get();
    to.cells[in_to] = source ? source->tile.cells[at] : SiteCell{};
    if (values) values->cells[in_to] = source ? source->values.cells[at] : ChannelRecord{};
    raise(to.cells[in_to], shift_.z_m);
    any |= to.cells[in_to].known();
  }
  return any;
}

}  // namespace talus::site
