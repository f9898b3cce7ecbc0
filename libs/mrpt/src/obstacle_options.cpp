#include <mrpt/config/CConfigFileBase.h>
#include <talus/mrpt/obstacles.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

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
constexpr std::array<const char*, 3> kPolicyNames{"free", "near", "obstacle"};

struct Number
{
  const char* name;
  double ObstacleOptions::*value;
  double min, max;
  const char* meaning;
};
constexpr double kAny = std::numeric_limits<double>::max();
constexpr std::array<Number, 8> kNumbers{{
    {"blocked_at", &ObstacleOptions::blocked_at, 0, 1,
     "cells whose traversability is this or less are obstacles"},
    {"risky_below", &ObstacleOptions::risky_below, 0, 1, "sparsity below which a guess is risky"},
    {"near_m", &ObstacleOptions::near_m, 0, kAny, "[m] what 'near' means"},
    {"body_radius_m", &ObstacleOptions::body_radius_m, 0, kAny,
     "[m] around the base nothing is an obstacle"},
    {"own_radius_m", &ObstacleOptions::own_radius_m, 0, kAny,
     "[m] around the base the policies count nothing"},
    {"range_m", &ObstacleOptions::range_m, 1e-3, kAny, "[m] farther obstacles are left out"},
    {"spacing_m", &ObstacleOptions::spacing_m, 0, kAny, "[m] one point a square; 0: all"},
    {"z_m", &ObstacleOptions::z_m, -kAny, kAny, "[m] height of 2D obstacles, robot frame"},
}};

struct Choice
{
  const char* name;
  CellPolicy ObstacleOptions::*value;
  const char* meaning;
};
constexpr std::array<Choice, 4> kChoices{{
    {"unknown", &ObstacleOptions::unknown, "free, near, obstacle: cells without ground"},
    {"one_sided", &ObstacleOptions::one_sided, "the same: ground that is a guess"},
    {"risky", &ObstacleOptions::risky, "the same: a guess that may be a ditch"},
    {"inferred", &ObstacleOptions::inferred, "the same: blocked only by comparison with a fill"},
}};

CellPolicy policy_from(
    const mrpt::config::CConfigFileBase& c, const std::string& section, const std::string& key)
{
  const std::string text = ini_value(c, section, key);
  for (std::size_t i = 0; i < kPolicyNames.size(); i++)
    if (text == kPolicyNames[i]) return static_cast<CellPolicy>(i);
  detail::refuse_value(c, section, key, "free, near or obstacle");
}

/** The name, or the number where there is none. */
std::string text_of(CellPolicy policy)
{
  const auto i = static_cast<std::size_t>(policy);
  return i < kPolicyNames.size() ? kPolicyNames[i] : std::to_string(static_cast<int>(policy));
}

std::string allowed(const Number& n)
{
  if (n.max == 1) return "from 0 to 1";
  return n.min == -kAny ? "a finite number" : "a finite number, " + number_text(n.min) + " or more";
}

std::vector<std::string> known_keys()
{
  std::vector<std::string> keys{"boundary_only"};
  for (const auto& n : kNumbers) keys.push_back(n.name);
  for (const auto& c : kChoices) keys.push_back(c.name);
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
  for (const auto& choice : kChoices)
    if (c.keyExists(s, choice.name)) this->*choice.value = policy_from(c, s, choice.name);
  boundary_only = detail::ini_flag(c, s, "boundary_only", boundary_only);
}

void ObstacleOptions::saveToConfigFile(mrpt::config::CConfigFileBase& c, const std::string& s) const
{
  for (const auto& n : kNumbers) c.write(s, n.name, number_text(this->*n.value), -1, 12, n.meaning);
  for (const auto& choice : kChoices)
    c.write(s, choice.name, text_of(this->*choice.value), -1, 12, choice.meaning);
  c.write(s, "boundary_only", boundary_only, -1, 12, "leave out the inside of obstacles");
}

}  // namespace talus
