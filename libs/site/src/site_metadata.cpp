#include "site_metadata.h"

#include <gdal_support.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace talus::site
{
namespace
{
constexpr std::size_t kMostPoints = 20000;
constexpr double kHighestFloor = 1e6;

/** The runs of points on one floor. */
Ways on_floor(const Ways& ways, int floor)
{
  Ways runs;
  for (const auto& way : ways)
  {
    bool goes_on = false;
    for (const WayPoint& p : way)
    {
      if (p.floor == floor && !goes_on) runs.emplace_back();
      goes_on = p.floor == floor;
      if (goes_on) runs.back().push_back(p);
    }
  }
  return runs;
}

/** Every so many-th point, and the last of each. */
void thin(Ways& ways)
{
  std::size_t points = 0;
  for (const auto& way : ways) points += way.size();
  if (points <= kMostPoints) return;
  const std::size_t ends = std::min(2 * ways.size(), kMostPoints / 2);
  const std::size_t every = (points + kMostPoints - ends - 1) / (kMostPoints - ends);
  for (auto& way : ways)
  {
    std::vector<WayPoint> kept;
    kept.reserve(way.size() / every + 2);
    for (std::size_t i = 0; i < way.size(); i += every) kept.push_back(way[i]);
    if ((way.size() - 1) % every != 0) kept.push_back(way.back());
    way = std::move(kept);
  }
}

/** The parts between the separators; none of an empty text. */
std::vector<std::string_view> split(std::string_view text, char separator)
{
  std::vector<std::string_view> parts;
  while (!text.empty())
  {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    text = at == text.npos ? std::string_view() : text.substr(at + 1);
  }
  return parts;
}

/** Finite numbers with blanks between. */
std::optional<std::vector<double>> numbers(std::string_view text)
{
  std::vector<double> values;
  for (const auto part : split(text, ' '))
  {
    if (part.empty()) continue;
    const auto v = number_from(part);
    if (!v || !std::isfinite(*v)) return std::nullopt;
    values.push_back(*v);
  }
  return values;
}

/** The same of so many. */
std::optional<std::vector<double>> numbers(std::string_view text, std::size_t count)
{
  auto values = numbers(text);
  return values && values->size() == count ? values : std::nullopt;
}
}  // namespace

std::string text_of_ways(const Ways& ways, int floor)
{
  Ways runs = on_floor(ways, floor);
  thin(runs);
  std::vector<std::string> texts;
  texts.reserve(runs.size());
  for (const auto& run : runs)
  {
    std::string& text = texts.emplace_back();
    for (const WayPoint& p : run)
      text += (text.empty() ? "" : ", ") + fixed_text(p.x_m, 2) + " " + fixed_text(p.y_m, 2) + " " +
              fixed_text(p.z_m, 2);
  }
  std::sort(texts.begin(), texts.end());
  texts.erase(std::unique(texts.begin(), texts.end()), texts.end());
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "; ") + text;
  return all;
}

std::optional<Ways> ways_from(const std::string& text, int floor)
{
  Ways ways;
  for (const auto way : split(text, ';'))
  {
    auto& points = ways.emplace_back();
    for (const auto point : split(way, ','))
    {
      const auto p = numbers(point, 3);
      if (!p) return std::nullopt;
      points.push_back(
          {static_cast<float>((*p)[0]), static_cast<float>((*p)[1]), static_cast<float>((*p)[2]),
           floor});
    }
  }
  return ways;
}

std::string text_of_floors(const std::vector<int>& floors)
{
  std::string text;
  for (const int floor : floors) text += (text.empty() ? "" : " ") + std::to_string(floor);
  return text;
}

std::optional<std::vector<int>> floors_from(const std::string& text)
{
  const auto values = numbers(text);
  if (!values) return std::nullopt;
  std::vector<int> floors;
  floors.reserve(values->size());
  for (const double v : *values)
  {
    if (v != std::floor(v) || v < 0 || v > kHighestFloor) return std::nullopt;
    floors.push_back(static_cast<int>(v));
  }
  return floors;
}

std::string text_of_origin(const GeoOrigin& o)
{
  return exact_number_text(o.latitude_deg) + " " + exact_number_text(o.longitude_deg) + " " +
         exact_number_text(o.altitude_m) + " " + exact_number_text(o.heading_deg);
}

std::optional<GeoOrigin> origin_from(const std::string& text)
{
  const auto n = numbers(text, 4);
  if (!n || std::abs((*n)[0]) > 90 || std::abs((*n)[1]) > 360) return std::nullopt;
  return GeoOrigin{(*n)[0], (*n)[1], (*n)[2], (*n)[3]};
}

OGRSpatialReference crs_of(const std::optional<GeoOrigin>& origin)
{
  if (!origin) return io::map_frame();
  OGRSpatialReference crs;
  const bool made =
      crs.SetProjCS("talus map: metres east and north of its origin") == OGRERR_NONE &&
      crs.SetWellKnownGeogCS("WGS84") == OGRERR_NONE &&
      crs.SetTM(origin->latitude_deg, origin->longitude_deg, 1, 0, 0) == OGRERR_NONE &&
      crs.SetLinearUnits(SRS_UL_METER, 1.0) == OGRERR_NONE;
  if (!made)
    throw std::runtime_error(
        "PROJ cannot make a coordinate system around the origin; is its proj.db installed?");
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

std::array<double, 6> transform_of(
    double min_x_m, double max_y_m, double resolution_m, const std::optional<GeoOrigin>& origin)
{
  constexpr double kPi = 3.14159265358979323846;
  const double heading_rad = origin ? origin->heading_deg * (kPi / 180) : 0;
  const auto clean = [](double v) { return std::abs(v) < 1e-12 ? 0.0 : v; };  // of 90 degrees
  const double c = clean(std::cos(heading_rad)), s = clean(std::sin(heading_rad));
  return {min_x_m * c - max_y_m * s, resolution_m * c, resolution_m * s,
          min_x_m * s + max_y_m * c, resolution_m * s, -resolution_m * c};
}

}  // namespace talus::site
