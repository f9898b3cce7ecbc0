#include <talus/formats/page.h>

#include "needed_layer.h"
#include "page_parts.h"
#include "page_tiles.h"

#include <mrpt/system/md5.h>
#include <mrpt/system/string_utils.h>
#include <picture_style.h>
#include <talus/channels.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
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

std::string base64(const std::vector<unsigned char>& bytes)
{
  std::string text;
  if (!bytes.empty()) mrpt::system::encodeBase64(bytes, text);
  text.erase(  // it is broken into lines
      std::remove_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }),
      text.end());
  return text;
}

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
std::string about(const io::LayerStack& map, const PageCode& code, const PageOptions& o)
{
  double driven_m = 0;
  for (const auto& way : o.ways)
    for (std::size_t i = 1; i < way.size(); ++i)
      driven_m += std::hypot(way[i].x_m - way[i - 1].x_m, way[i].y_m - way[i - 1].y_m);
  const double area_m2 =
      static_cast<double>(code.known_cells) * map.resolution_m * map.resolution_m;
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

json data_of(const io::LayerStack& map, const PageCode& code, const PageOptions& o)
{
  json data = {
      {"title", o.title},
      {"about", about(map, code, o)},
      {"resolution_m", map.resolution_m},
      {"min_x_m", map.min_x_m},
      {"min_y_m", map.min_y_m},
      {"cells_x", map.cells_x},
      {"cells_y", map.cells_y},
      {"tile_cells", kPageTile_cells},
      {"lowest_m", code.lowest_m},
      {"step_m", code.step_m},
      {"tall_step_m", PageCode::kTallStep_m},
      {"change_step_m", PageCode::kChangeStep_m},
      {"age_steps", PageCode::kAgeSteps},
      {"oldest_s", code.oldest_s},
      {"has_drops", map.find(layer_name(Layer::Sparsity)) != nullptr},
      {"has_age", map.find("age") != nullptr},
      {"has_changes", o.changes != nullptr},
      {"channels", channels_of(code)},
      {"scores", rgb_of(io::Palette::Scores)},
      {"heights", rgb_of(io::Palette::Heights)},
      {"palette", palette()},
      {"states", list_of(io::palette::kStates)},
      {"changes", list_of(io::palette::kChanges)},
      {"ways", ways_of(o)}};
  if (o.origin)
    data["origin"] = {
        {"latitude_deg", o.origin->latitude_deg},
        {"longitude_deg", o.origin->longitude_deg},
        {"heading_deg", o.origin->heading_deg}};
  return data;
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

std::string pictures_text(const std::vector<std::vector<unsigned char>>& pictures)
{
  std::string text;
  for (const auto& picture : pictures)
    text += (text.empty() ? "\"" : ",\"") + base64(picture) + "\"";
  return text;
}

std::string tiles_text(const std::vector<PageTile>& tiles)
{
  std::string text = "[";
  for (const PageTile& t : tiles)
    text += (text.size() > 1 ? ",\n" : "") + std::string("[") + std::to_string(t.column) + "," +
            std::to_string(t.row) + ",\"" + base64(t.ground) + "\",\"" + base64(t.more) + "\",\"" +
            base64(t.changes) + "\",[" + pictures_text(t.channels) + "]]";
  return text + "]";
}

/** Nothing where it would be larger than wanted. */
std::optional<std::string> page_of(
    const io::LayerStack& map, const io::LayerStack* changes, const PageOptions& o)
{
  PageCode code;
  const auto tiles = page_tiles(map, changes, o.max_bytes / 4 * 3, code);  // before base64
  if (!tiles) return std::nullopt;
  const std::string leaflet = leaflet_script();
  const std::string data = "const map_data = " + script_text(data_of(map, code, o)) +
                           ";\nmap_data.tiles = " + tiles_text(*tiles) + ";";
  // Scripts run that say it, and none that came with a name or a title: none tells it beforehand.
  const std::pair<std::string, std::string> nonce{
      "/* nonce */", mrpt::system::md5(leaflet + data + kScript)};
  std::string page = filled(
      {nonce,
       {"<!-- title -->", escaped(o.title)},
       {"/* leaflet.css */", leaflet_style()},
       {"/* page.css */", kStyle},
       nonce,
       {"/* licence */", kLeafletLicence},
       {"/* leaflet.js */", leaflet},
       nonce,
       {"/* data */", data},
       nonce,
       {"/* page.js */", kScript}});
  return page.size() > o.max_bytes ? std::nullopt : std::optional<std::string>(std::move(page));
}

/** The cells of `changes` at the places of those of `map`. */
io::LayerStack on_cells_of(const io::LayerStack& map, const io::LayerStack& changes)
{
  changes.require_sound();
  if (!changes.find("kind") || !changes.find("change_m"))
    throw std::runtime_error(
        "the changes have no band 'kind' or 'change_m': give a changes.tif of talus-merge");
  if (std::abs(changes.resolution_m - map.resolution_m) > 1e-6)
    throw std::runtime_error("the cells of the changes have another size than those of the map");
  const auto dx = std::lround((map.min_x_m - changes.min_x_m) / map.resolution_m),
             dy = std::lround((map.min_y_m - changes.min_y_m) / map.resolution_m);
  io::LayerStack out;
  out.cells_x = map.cells_x;
  out.cells_y = map.cells_y;
  out.resolution_m = map.resolution_m;
  out.min_x_m = map.min_x_m;
  out.min_y_m = map.min_y_m;
  out.names = changes.names;
  out.layers.assign(
      changes.layers.size(),
      std::vector<float>(map.layers.front().size(), std::numeric_limits<float>::quiet_NaN()));
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        const long x = ix + dx, y = iy + dy;
        if (x < 0 || y < 0 || x >= changes.cells_x || y >= changes.cells_y) return;
        const auto from =
            static_cast<std::size_t>(y) * changes.cells_x + static_cast<std::size_t>(x);
        for (std::size_t k = 0; k < out.layers.size(); ++k)
          out.layers[k][i] = changes.layers[k][from];
      });
  return out;
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

void write_page(const std::string& path, const io::LayerStack& map, const PageOptions& options)
{
  io::LayerStack coarse, changes;
  const io::LayerStack* shown = &map;
  if (options.changes) changes = on_cells_of(map, *options.changes);
  for (;;)
  {
    if (const auto page = page_of(*shown, options.changes ? &changes : nullptr, options))
      return io::write_file(path, *page);
    if (std::min(shown->cells_x, shown->cells_y) < kMinCells) break;
    coarse = joined_cells(*shown);
    if (options.changes) changes = joined_cells(changes);
    shown = &coarse;
  }
  throw std::runtime_error(path + ": no page is as small as that: give more with --max-mb");
}

}  // namespace talus::formats
