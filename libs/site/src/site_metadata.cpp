#include "site_metadata.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace talus::site
{
namespace
{
constexpr std::size_t kMaxPoints = 20000;
constexpr double kHighestFloor = 1e6;

/** Every n-th point, and the last of each. */
void thin(Ways& ways)
{
  std::size_t points = 0;
  for (const auto& way : ways) points += way.size();
  if (points <= kMaxPoints) return;
  const std::size_t ends = std::min(2 * ways.size(), kMaxPoints / 2);
  const std::size_t every = (points + kMaxPoints - ends - 1) / (kMaxPoints - ends);
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

}  // namespace

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
              fixed_text(p.z_m, 2) + (std::isnan(p.stamp_s) ? "" : " " + fixed_text(p.stamp_s, 1));
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
      const auto p = numbers(point);
      if (!p || p->size() < 3 || p->size() > 4) return std::nullopt;
      points.push_back(
          {static_cast<float>((*p)[0]), static_cast<float>((*p)[1]), static_cast<float>((*p)[2]),
           floor, p->size() == 4 ? (*p)[3] : NAN});
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

std::string text_of_sums(const TileSums& sums)
{
  std::string text;
  for (const auto& [tile, sum] : sums)
    text += (text.empty() ? "" : ";") + std::to_string(tile.first) + " " +
            std::to_string(tile.second) + " " + std::to_string(sum);
  return text;
}

std::optional<TileSums> sums_from(const std::string& text)
{
  TileSums sums;
  for (const auto tile : split(text, ';'))
  {
    const auto n = numbers(tile);
    if (!n || n->size() != 3 || std::abs((*n)[0]) > INT32_MAX || std::abs((*n)[1]) > INT32_MAX ||
        (*n)[2] < 0 || (*n)[2] > UINT32_MAX)
      return std::nullopt;
    sums[{static_cast<std::int32_t>((*n)[0]), static_cast<std::int32_t>((*n)[1])}] =
        static_cast<std::uint32_t>((*n)[2]);
  }
  return sums;
}

}  // namespace talus::site
