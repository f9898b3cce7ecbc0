#include <talus/formats/page.h>

#include "needed_layer.h"
#include "page_parts.h"
#include "page_tiles.h"

#include <mrpt/system/md5.h>
#include <picture_relief.h>
#include <picture_style.h>
#include <talus/channels.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace talus::formats
{
namespace
{
using nlohmann::json;

const std::string kLeaflet = "/usr/share/javascript/leaflet/";
constexpr int kMinCells = 64;  // along a side: coarser a page tells nothing

/** The first of these files that is there. */
std::string leaflet_file(const std::vector<std::string>& names)
{
  for (const std::string& name : names)
    if (std::ifstream file(kLeaflet + name, std::ios::binary); file)
      return {std::istreambuf_iterator<char>(file), {}};
  throw std::runtime_error(
      kLeaflet + names.front() +
      ": cannot be read; a page brings Leaflet along, install the package libjs-leaflet");
}

std::string leaflet_style() { return leaflet_file({"leaflet.css"}); }
std::string leaflet_script() { return leaflet_file({"leaflet.min.js", "leaflet.js"}); }

/** Red, green, blue of 256 steps. */
json rgb_of(io::Palette palette)
{
  const cv::Mat scale = io::colours_of(palette);
  json colours = json::array();
  for (int k = 0; k < scale.rows; ++k)
  {
    const auto& c = scale.at<cv::Vec3b>(k);
    colours.push_back({c[2], c[1], c[0]});
  }
  return colours;
}

json json_of(const io::NamedColour& c) { return {{"word", c.name}, {"rgb", c.rgb}}; }

template <class Colours>
json list_of(const Colours& colours)
{
  json list = json::array();
  for (const io::NamedColour& c : colours) list.push_back(json_of(c));
  return list;
}

json palette()
{
  namespace p = io::palette;
  return {{"blocked", json_of(p::kBlocked)},      {"free", json_of(p::kFree)},
          {"stands", json_of(p::kStands)},        {"inferred", json_of(p::kInferred)},
          {"not_judged", json_of(p::kNotJudged)}, {"guessed", json_of(p::kGuessed)},
          {"may_drop", json_of(p::kMayDrop)},     {"path", json_of(p::kPath)}};
}

/** When, how far, how much. */
std::string about(double area_m2, const PageOptions& o)
{
  double driven_m = 0;
  for (const auto& way : o.ways)
    for (std::size_t i = 1; i < way.size(); ++i)
      driven_m += std::hypot(way[i].x_m - way[i - 1].x_m, way[i].y_m - way[i - 1].y_m);
  std::string text = o.date.empty() ? "" : o.date + ", ";
  if (driven_m > 0) text += fixed_text(driven_m, 0) + " m driven, ";
  return text + fixed_text(area_m2, area_m2 < 100 ? 1 : 0) + " m\u00b2 known";
}

json ways_of(const PageOptions& o)
{
  json ways = json::array();
  for (const auto& way : o.ways)
  {
    json points = json::array();
    for (const PagePoint& p : way)
      points.push_back(
          {std::round(100 * p.x_m) / 100, std::round(100 * p.y_m) / 100,
           std::round(100 * p.z_m) / 100});
    ways.push_back(points);
  }
  return ways;
}

json channels_of(const PageCode& code)
{
  json channels = json::array();
  for (const PageCode::Channel& c : code.channels)
    channels.push_back(
        {{"name", c.name},
         {"lowest", c.lowest},
         {"highest", c.highest},
         {"step", c.step},
         {"is_class", c.is_class}});
  return channels;
}

/** What all pages have. */
json data_of(const std::string& title, const io::LayerStack& place, int tile_cells)
{
  return {
      {"title", title},
      {"about", ""},
      {"resolution_m", place.resolution_m},
      {"min_x_m", place.min_x_m},
      {"min_y_m", place.min_y_m},
      {"cells_x", place.cells_x},
      {"cells_y", place.cells_y},
      {"tile_cells", tile_cells},
      {"tall_step_m", PageCode::kTallStep_m},
      {"change_step_m", PageCode::kChangeStep_m},
      {"age_steps", PageCode::kAgeSteps},
      {"oldest_s", 0},
      {"has_drops", false},
      {"has_age", false},
      {"has_changes", false},
      {"channels", json::array()},
      {"scores", rgb_of(io::Palette::Scores)},
      {"heights", rgb_of(io::Palette::Heights)},
      {"palette", palette()},
      {"states", list_of(io::palette::kStates)},
      {"changes", list_of(io::palette::kChanges)},
      {"ways", json::array()}};
}

/** A text in which no tag begins, whatever it says. */
std::string script_text(const json& j)
{
  std::string text = j.dump(-1, ' ', false, json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; at += 6)
    text.replace(at, 1, "\\u003c");
  return text;
}

/** The page with each of the marks, which are in its order, replaced: what replaces one has none.
 */
std::string filled(const std::vector<std::pair<std::string, std::string>>& marks)
{
  const std::string page = kPage;
  std::string text;
  std::size_t from = 0;
  for (const auto& [mark, by] : marks)
  {
    const std::size_t at = page.find(mark, from);
    if (at == std::string::npos) throw std::logic_error("the page has no place for " + mark);
    text += page.substr(from, at - from) + by;
    from = at + mark.size();
  }
  return text + page.substr(from);
}

std::string escaped(const std::string& text)
{
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

/** `live`: what else its script does; `events`: from where its own site may be asked. */
std::string page_of(
    const std::string& title, const std::string& data, const std::string& live,
    const std::string& events)
{
  const std::string leaflet = leaflet_script();
  std::string script = kScript;
  const std::string mark = "  /* live.js */\n";
  script.replace(script.find(mark), mark.size(), live);
  // Scripts run that say it, and none that came with a name or a title: none tells it beforehand.
  const std::pair<std::string, std::string> nonce{
      "/* nonce */", mrpt::system::md5(leaflet + data + script)};
  return filled(
      {nonce,
       {"/* events */", events},
       {"<!-- title -->", escaped(title)},
       {"/* leaflet.css */", leaflet_style()},
       {"/* page.css */", kStyle},
       nonce,
       {"/* licence */", kLeafletLicence},
       {"/* leaflet.js */", leaflet},
       nonce,
       {"/* data */", data},
       nonce,
       {"/* page.js */", script}});
}

/** Where cells of a map are. */
struct Part
{
  int x, y, cells_x, cells_y;
};

io::LayerStack place_of(const io::LayerStack& map, const Part& part)
{
  io::LayerStack place;
  place.cells_x = part.cells_x;
  place.cells_y = part.cells_y;
  place.resolution_m = map.resolution_m;
  place.min_x_m = map.min_x_m + part.x * map.resolution_m;
  place.min_y_m = map.min_y_m + part.y * map.resolution_m;
  return place;
}

void require_changes_of(const io::LayerStack& map, const io::LayerStack& changes)
{
  const auto has = [&](const char* name)
  { return std::count(changes.names.begin(), changes.names.end(), name) > 0; };
  if (!has("kind") || !has("change_m"))
    throw std::runtime_error(
        "the changes have no band 'kind' or 'change_m': give a changes.tif of talus-merge");
  if (std::abs(changes.resolution_m - map.resolution_m) > 1e-6)
    throw std::runtime_error("the cells of the changes have another size than those of the map");
}

/** The cells of `changes` at the places of those of `map`. */
io::LayerStack on_cells_of(const io::LayerStack& map, const PageMap& changes)
{
  io::LayerStack out = place_of(map, {0, 0, map.cells_x, map.cells_y});
  out.names = {"kind", "change_m"};
  out.layers.assign(
      2, std::vector<float>(
             static_cast<std::size_t>(map.cells_x) * map.cells_y,
             std::numeric_limits<float>::quiet_NaN()));
  const auto dx = std::lround((map.min_x_m - changes.place.min_x_m) / map.resolution_m),
             dy = std::lround((map.min_y_m - changes.place.min_y_m) / map.resolution_m);
  const auto min_x = std::max(0L, dx),
             end_x = std::min<long>(changes.place.cells_x, dx + map.cells_x);
  const auto min_y = std::max(0L, dy),
             end_y = std::min<long>(changes.place.cells_y, dy + map.cells_y);
  if (min_x >= end_x || min_y >= end_y) return out;
  const auto from = changes.read(
      static_cast<int>(min_x), static_cast<int>(min_y), static_cast<int>(end_x - min_x),
      static_cast<int>(end_y - min_y), out.names);
  for (std::size_t k = 0; k < out.names.size(); ++k)
    for (int y = 0; y < from.cells_y; ++y)
    {
      const auto row = from.find(out.names[k])->begin() + std::ptrdiff_t{y} * from.cells_x;
      std::copy(
          row, row + from.cells_x,
          out.layers[k].begin() + (min_y - dy + y) * out.cells_x + (min_x - dx));
    }
  return out;
}

/** A map in the cells of a page: `joins` times 2 x 2 of its own are one. */
class PageCells
{
 public:
  PageCells(const PageMap& map, const PageMap* changes, int joins)
      : map_(map), changes_(changes), joins_(joins)
  {
    const int side = 1 << joins;
    place_ = map.place;
    place_.resolution_m *= side;
    place_.cells_x = (place_.cells_x + side - 1) / side;
    place_.cells_y = (place_.cells_y + side - 1) / side;
    names_ = map.place.names;
    look_through();
  }
  const io::LayerStack& place() const { return place_; }
  const PageCode& code() const { return code_; }
  bool has(const std::string& layer) const
  {
    return std::count(names_.begin(), names_.end(), layer) > 0;
  }

  /** A tile, and what lies around it. */
  PagePart part(int column, int row) const
  {
    const int margin = io::reach_of_shade(place_.resolution_m);
    const int west = column * kPageTile_cells, north = row * kPageTile_cells;
    PagePart part;
    part.west = std::min(margin, west);
    part.north = std::min(margin, north);
    part.cells_x = std::min(kPageTile_cells, place_.cells_x - west);
    part.cells_y = std::min(kPageTile_cells, place_.cells_y - north);
    const int end_x = std::min(west + part.cells_x + margin, place_.cells_x);
    const int south = std::min(north + part.cells_y + margin, place_.cells_y);
    const int first_x = west - part.west, first_row = north - part.north;
    const Part cells =
        of_map({first_x, place_.cells_y - south, end_x - first_x, south - first_row});
    part.cells = map_.read(cells.x, cells.y, cells.cells_x, cells.cells_y, names_);
    if (changes_) part.changes = on_cells_of(part.cells, *changes_);
    for (int i = 0; i < joins_; ++i)
    {
      part.cells = joined_cells(part.cells);
      if (changes_) part.changes = joined_cells(part.changes);
    }
    return part;
  }

 private:
  /** Of the cells of the page. */
  Part of_map(const Part& part) const
  {
    const int side = 1 << joins_;
    return {
        part.x * side, part.y * side,
        std::min(part.cells_x * side, map_.place.cells_x - part.x * side),
        std::min(part.cells_y * side, map_.place.cells_y - part.y * side)};
  }

  /** What is needed of all cells before the first tile. */
  void look_through()
  {
    const std::string reached = layer_name(Layer::Reached);
    const auto channels = channel_bands(names_);
    for (const auto& name : channels) code_.channels.emplace_back().name = name;
    bool is_reached = !has(reached);
    const auto& all = map_.place;
    for (int y = 0; y < all.cells_y; y += kPageTile_cells)
      for (int x = 0; x < all.cells_x; x += kPageTile_cells)
      {
        auto names = channels;
        if (!is_reached) names.push_back(reached);
        if (names.empty()) return;
        const auto part = map_.read(
            x, y, std::min(kPageTile_cells, all.cells_x - x),
            std::min(kPageTile_cells, all.cells_y - y), names);
        if (!is_reached)
        {
          const auto& layer = *part.find(reached);
          is_reached = std::count(layer.begin(), layer.end(), 1.0F) > 0;
        }
        for (auto& channel : code_.channels) channel.add(*part.find(channel.name));
      }
    for (auto& channel : code_.channels) channel.finish();
    // Nothing is reached where a single scan tells nothing of the ground around the robot.
    if (!is_reached) names_.erase(std::find(names_.begin(), names_.end(), reached));
  }

  const PageMap& map_;
  const PageMap* changes_;
  int joins_;
  io::LayerStack place_;
  std::vector<std::string> names_;
  PageCode code_;
};

/** Nothing where it would be larger than wanted. */
std::optional<std::string> page_of(
    const std::string& path, const PageCells& cells, const PageOptions& o)
{
  const auto& place = cells.place();
  std::string tiles;
  std::size_t bytes = 0, known = 0;
  double oldest_s = 0;
  for (int row = 0; row * kPageTile_cells < place.cells_y; ++row)
    for (int column = 0; column * kPageTile_cells < place.cells_x; ++column)
    {
      auto tile = page_tile(cells.part(column, row), cells.code());
      if (!tile) continue;
      tile->column = column;
      tile->row = row;
      known += tile->known_cells;
      oldest_s = std::max(oldest_s, tile->oldest_s);
      bytes += tile->bytes();
      if (bytes > o.max_bytes / 4 * 3) return std::nullopt;  // before base64
      tiles += (tiles.empty() ? "" : ",\n") + text_of(*tile);
    }
  if (known == 0) throw std::runtime_error(path + ": no cell of the map is known");
  json data = data_of(o.title, place, kPageTile_cells);
  data["about"] = about(static_cast<double>(known) * place.resolution_m * place.resolution_m, o);
  data["oldest_s"] = oldest_s;
  data["has_drops"] = cells.has(layer_name(Layer::Sparsity));
  data["has_age"] = cells.has("age");
  data["has_changes"] = o.changes != nullptr;
  data["channels"] = channels_of(cells.code());
  data["ways"] = ways_of(o);
  if (o.origin)
    data["origin"] = {
        {"latitude_deg", o.origin->latitude_deg},
        {"longitude_deg", o.origin->longitude_deg},
        {"heading_deg", o.origin->heading_deg}};
  auto page = page_of(
      o.title, "const map_data = " + script_text(data) + ";\nmap_data.tiles = [" + tiles + "];", "",
      "");
  return page.size() > o.max_bytes ? std::nullopt : std::optional<std::string>(std::move(page));
}
}  // namespace

namespace
{
/** A stranger's file has bands of any name. */
bool is_channel(const std::string& name)
{
  try
  {
    validate_channels({{name, ChannelRule::Mean}});
    return true;
  }
  catch (const std::invalid_argument&)
  {
    return false;
  }
}
}  // namespace

std::vector<std::string> channel_bands(const std::vector<std::string>& names)
{
  std::vector<std::string> found;
  for (const std::string& name : names)
  {
    if (!is_channel(name)) continue;
    for (const std::string& layer : channel_layer_names({{name, ChannelRule::Mean}}))
      if (layer != name && std::find(names.begin(), names.end(), layer) != names.end())
        found.insert(found.end(), {name, layer});
  }
  return found;
}

void require_leaflet()
{
  leaflet_style();
  leaflet_script();
}

PageMap page_map(const io::LayerStack& map)
{
  map.require_sound();
  PageMap page{map, {}};
  page.place.layers.clear();
  page.read = [&map](int x, int y, int cells_x, int cells_y, const std::vector<std::string>& names)
  {
    io::LayerStack part = place_of(map, {x, y, cells_x, cells_y});
    for (const auto& name : names)
    {
      const auto* from = map.find(name);
      if (!from) continue;
      part.names.push_back(name);
      auto& to = part.layers.emplace_back();
      for (int row = y; row < y + cells_y; ++row)
      {
        const auto first = from->begin() + std::ptrdiff_t{row} * map.cells_x + x;
        to.insert(to.end(), first, first + cells_x);
      }
    }
    return part;
  };
  return page;
}

void write_page(const std::string& path, const PageMap& map, const PageOptions& options)
{
  if (options.changes) require_changes_of(map.place, options.changes->place);
  for (int joins = 0;; ++joins)
  {
    const PageCells cells(map, options.changes, joins);
    if (const auto page = page_of(path, cells, options)) return io::write_file(path, *page);
    if (std::min(cells.place().cells_x, cells.place().cells_y) < kMinCells) break;
  }
  throw std::runtime_error(path + ": no page is as small as that: give more with --max-mb");
}

std::string live_page(const LivePage& page)
{
  constexpr int kMaxSide = 1 << 16;  // how far it zooms out, in cells
  io::LayerStack place;
  place.resolution_m = page.resolution_m;
  place.cells_x = place.cells_y = kMaxSide;
  place.min_y_m = -kMaxSide * page.resolution_m;  // so that rows count from the origin
  json data = data_of(page.title, place, page.tile_cells);
  data["run"] = page.run;
  data["tiles"] = json::array();
  return page_of(
      page.title, "const map_data = " + script_text(data) + ";", kLive, "; connect-src 'self'");
}

int live_margin_cells(double resolution_m) { return io::reach_of_shade(resolution_m); }

std::string live_cells(const io::LayerStack& map, int margin_cells, int column, int row)
{
  PagePart part;
  part.cells = map;
  part.west = part.north = margin_cells;
  part.cells_x = map.cells_x - 2 * margin_cells;
  part.cells_y = map.cells_y - 2 * margin_cells;
  auto tile = page_tile(part, PageCode());
  if (!tile) return "";
  tile->column = column;
  tile->row = row;
  return text_of(*tile);
}

}  // namespace talus::formats
