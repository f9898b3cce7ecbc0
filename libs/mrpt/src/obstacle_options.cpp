#include <mrpt/config/CConfigFileBase.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "ini_sections.h"
#include "warn_once.h"

namespace talus
{
namespace
{
constexpr std::array<const char*, 2> kUnseenNames{"obstacle", "free"};
constexpr std::array<const char*, 3> kDropsNames{"avoid", "slope", "ignore"};
constexpr const char* kUnseenAllowed = "obstacle or free";
constexpr const char* kDropsAllowed = "avoid, slope or ignore";

struct Number
{
  const char* name;
  double ObstacleOptions::*value;
  double min, max;
  const char* meaning;
};
constexpr double kAny = std::numeric_limits<double>::max();
constexpr std::array<Number, 7> kNumbers{{
    {"blocked_at", &ObstacleOptions::blocked_at, 0, 1,
     "cells whose traversability is this or less are obstacles"},
    {"risk_at", &ObstacleOptions::risk_at, 0, 1, "so are cells with a larger risk; 1: none"},
    {"seen_within_m", &ObstacleOptions::seen_within_m, 0, kAny,
     "[m] this near to the base, ground must be known and judged"},
    {"body_radius_m", &ObstacleOptions::body_radius_m, 0, kAny,
     "[m] around the base nothing is an obstacle"},
    {"range_m", &ObstacleOptions::range_m, 1e-3, kAny, "[m] farther obstacles are left out"},
    {"spacing_m", &ObstacleOptions::spacing_m, 0, kAny, "[m] one point a square; 0: all"},
    {"z_m", &ObstacleOptions::z_m, -kAny, kAny, "[m] height of 2D obstacles, robot frame"},
}};

/** Reads a choice by its name; its values are numbered in the order of the names. */
template <class Choice, std::size_t kNames>
void load_choice(
    const mrpt::config::CConfigFileBase& c, const std::string& section, const char* key,
    const std::array<const char*, kNames>& names, const char* allowed, Choice& choice)
{
  if (!c.keyExists(section, key)) return;
  const auto at = std::find(names.begin(), names.end(), ini_value(c, section, key));
  if (at == names.end()) detail::refuse_value(c, section, key, allowed);
  choice = static_cast<Choice>(at - names.begin());
}

/** The name, or the number where there is none. */
template <class Choice, std::size_t kNames>
std::string text_of(Choice choice, const std::array<const char*, kNames>& names)
{
  const auto i = static_cast<std::size_t>(choice);
  return i < names.size() ? names[i] : std::to_string(static_cast<int>(choice));
}

std::string allowed(const Number& n)
{
  if (n.max == 1) return "from 0 to 1";
  return n.min == -kAny ? "a finite number" : "a finite number, " + number_text(n.min) + " or more";
}

std::vector<std::string> known_keys()
{
  std::vector<std::string> keys{"boundary_only", "drops", "unseen"};
  keys.reserve(keys.size() + kNumbers.size());
  for (const auto& n : kNumbers) keys.emplace_back(n.name);
  return keys;
}
}  // namespace

void ObstacleOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& c, const std::string& s)
{
  require_sound_ini(c, {s});
  std::vector<std::string> warnings;
  warn_unknown_keys(c, s, known_keys(), warnings);
  for (const auto& w : warnings) detail::warn_once(w);
  for (const auto& n : kNumbers)
  {
    const double v = detail::ini_number(c, s, n.name, this->*n.value);
    if (!(v >= n.min && v <= n.max)) detail::refuse_value(c, s, n.name, allowed(n));
    this->*n.value = v;
  }
  load_choice(c, s, "unseen", kUnseenNames, kUnseenAllowed, unseen);
  load_choice(c, s, "drops", kDropsNames, kDropsAllowed, drops);
  boundary_only = detail::ini_flag(c, s, "boundary_only", boundary_only);
}

void ObstacleOptions::saveToConfigFile(mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  for (const auto& n : kNumbers) c.write(s, n.name, number_text(this->*n.value), -1, 12, n.meaning);
  c.write(
      s, "unseen", text_of(unseen, kUnseenNames), -1, 12,
      std::string(kUnseenAllowed) + ": what is not known there");
  c.write(
      s, "drops", text_of(drops, kDropsNames), -1, 12,
      std::string(kDropsAllowed) + ": ground that may drop");
  c.write(s, "boundary_only", boundary_only, -1, 12, "leave out the inside of obstacles");
}

}  // namespace talus
