#include "bands.h"

#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace talus::io
{
namespace
{
struct Known
{
  const char* name;
  const char* unit;
};
constexpr Known kKnown[] = {
    {"traversability", ""},
    {"ground_elevation", "m"},
    {"elevation", "m"},
    {"variance", "m2"},
    {"state", ""},
    {"reached", ""},
    // Of one window:
    {"slope", ""},
    {"step", ""},
    {"roughness", ""},
    {"sparsity", ""},
    {"risk", ""},
    // Of a site:
    {"age", "s"},
    {"elevation_variance", "m2"},
    {"evidence", ""},
    {"shape", ""},
    // Of what changed:
    {"change_m", "m"},
    {"kind", ""},
    // Of what moved:
    {"times", ""},
    {"scans", ""},
    {"speed_mps", "m/s"}};

struct Classes
{
  const char* band;
  const char* text;
};
constexpr Classes kClasses[] = {
    {"state", "0 unknown, 1 measured, 2 filled from two sides, 3 filled from one side, 4 presumed"},
    {"reached", "0 the robot does not get there over passable cells, 1 it does"},
    {"kind", "0 none, 1 built, 2 dug, 3 object gone, 4 object new"}};

const Known* find(const std::string& name)
{
  return std::find_if(
      std::begin(kKnown), std::end(kKnown), [&](const Known& k) { return name == k.name; });
}
}  // namespace

std::size_t place_of_band(const std::string& name)
{
  return static_cast<std::size_t>(find(name) - std::begin(kKnown));
}

const char* unit_of_band(const std::string& name)
{
  const Known* known = find(name);
  return known == std::end(kKnown) ? "" : known->unit;
}

std::map<std::string, std::string> BandStatistics::items(double cells) const
{
  if (count_ == 0) return {};
  return {
      {"STATISTICS_MINIMUM", exact_number_text(min_)},
      {"STATISTICS_MAXIMUM", exact_number_text(max_)},
      {"STATISTICS_MEAN", exact_number_text(mean_)},
      {"STATISTICS_STDDEV", exact_number_text(std::sqrt(squares_ / count_))},
      {"STATISTICS_VALID_PERCENT", fixed_text(100 * count_ / cells, 2)}};
}

std::map<std::string, std::string> band_items(
    const std::string& name, const BandStatistics& statistics, double cells)
{
  auto items = statistics.items(cells);
  for (const Classes& c : kClasses)
    if (name == c.band) items["TALUS_CLASSES"] = c.text;
  return items;
}

}  // namespace talus::io
