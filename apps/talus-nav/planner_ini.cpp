#include "planner_ini.h"

#include "builtin_configs.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

namespace talus::nav
{
namespace
{
using mrpt::config::CConfigFileBase;

/** What the shipped files leave out. */
constexpr const char* kOptional = R"(
[CAbstractPTGBasedReactive]
robotMinCurvRadius = 1
speedfilter_tau = 0
max_dist_for_timebased_path_prediction = 2
[CReactiveNavigationSystem]
RobotModel_circular_shape_radius = 0.3
PTG0_turningRadiusReference = 0.1
PTG0_T_ramp_max = 1
[CReactiveNavigationSystem3D]
LEVEL1_RADIUS = 0.3
PTG1_turningRadiusReference = 0.1
PTG1_T_ramp_max = 1
)";

/** Numbers that must be above 0, without digits. */
const std::set<std::string> kPositive{"robotmax_v_mps", "robotmax_w_degps", "ref_distance",
                                      "ptg_v_max_mps",  "ptg_w_max_dps",    "ptg_resolution",
                                      "ptg_num_paths",  "ptg_refdistance",  "level_height"};

enum class Kind
{
  Text,
  Number,
  Numbers,
  YesNo
};

bool is_number(const std::string& text)
{
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value);
}

/** The parts of "[1, 2, 3]" or "1 2 3". */
std::vector<std::string> parts_of(const std::string& text)
{
  std::vector<std::string> parts;
  mrpt::system::tokenize(text, "[], \t", parts);
  return parts;
}

bool is_yes_no(const std::string& text)
{
  const std::string word = mrpt::system::lowerCase(text);
  return word == "true" || word == "false" || word == "yes" || word == "no";
}

Kind kind_of(const std::string& text)
{
  if (is_number(text)) return Kind::Number;
  if (is_yes_no(text)) return Kind::YesNo;
  const auto parts = parts_of(text);
  const bool are_numbers = std::all_of(parts.begin(), parts.end(), is_number);
  return parts.empty() || !are_numbers ? Kind::Text : Kind::Numbers;
}

bool fits(const std::string& text, Kind wanted)
{
  const Kind kind = kind_of(text);
  return wanted == Kind::Text || kind == wanted ||
         (wanted == Kind::Numbers && kind == Kind::Number) ||
         (wanted == Kind::YesNo && (text == "0" || text == "1"));
}

std::string name_of(Kind kind)
{
  return kind == Kind::Number ? "a number" : kind == Kind::Numbers ? "numbers" : "true or false";
}

[[noreturn]] void refuse(
    const CConfigFileBase& ini, const std::string& section, const std::string& key,
    const std::string& allowed)
{
  const std::string found =
      ini.keyExists(section, key) ? " = '" + ini_value(ini, section, key) + "'" : " is missing";
  throw std::runtime_error(key + found + ": must be " + allowed + " (in section " + section + ")");
}

std::string without_digits(std::string key)
{
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  key.erase(std::remove_if(key.begin(), key.end(), is_digit), key.end());
  return mrpt::system::lowerCase(key);
}

void check_kinds(
    const CConfigFileBase& ini, const CConfigFileBase& shipped, const std::string& section)
{
  std::vector<std::string> keys;
  std::map<std::string, Kind> kinds;
  shipped.getAllKeys(section, keys);
  for (const auto& key : keys)
    kinds[without_digits(key)] = kind_of(ini_value(shipped, section, key));
  ini.getAllKeys(section, keys);
  for (const auto& key : keys)
  {
    const std::string name = without_digits(key), text = ini_value(ini, section, key);
    const auto kind = kinds.find(name);
    if (kind == kinds.end()) continue;
    if (!fits(text, kind->second)) refuse(ini, section, key, name_of(kind->second));
    if (kPositive.count(name) > 0 && !(std::strtod(text.c_str(), nullptr) > 0))
      refuse(ini, section, key, "above 0");
  }
}

/** The corners of the robot, or of one of its prisms; or it is round. */
void check_outline(
    const CConfigFileBase& ini, const std::string& section, const std::string& key_x,
    const std::string& key_y, const std::string& key_radius)
{
  if (ini.keyExists(section, key_radius)) return;
  const auto corners = parts_of(ini_value(ini, section, key_x)).size();
  if (corners < 3) refuse(ini, section, key_x, "the x of three corners or more");
  if (parts_of(ini_value(ini, section, key_y)).size() != corners)
    refuse(ini, section, key_y, "as many numbers as " + key_x);
}

int count_at(const CConfigFileBase& ini, const std::string& section, const std::string& key)
{
  constexpr int kMost = 100;
  const double count = std::strtod(ini_value(ini, section, key).c_str(), nullptr);
  if (!(count >= 1 && count <= kMost && count == std::floor(count)))
    refuse(ini, section, key, "a whole number from 1 to " + std::to_string(kMost));
  return static_cast<int>(count);
}
}  // namespace

std::string planner_name(bool in_3d)
{
  return in_3d ? "CReactiveNavigationSystem3D" : "CReactiveNavigationSystem";
}

std::string shipped_ini(bool in_3d)
{
  return std::string("datasets/configs/reactive") + (in_3d ? "3d" : "2d") + "_config.ini";
}

void check_planner_ini(const CConfigFileBase& ini, bool in_3d)
{
  mrpt::config::CConfigFileMemory shipped;
  shipped.setContent(std::string(in_3d ? kReactive3D : kReactive2D) + kOptional);
  const std::string own = planner_name(in_3d);
  std::vector<std::string> sections;
  shipped.getAllSections(sections);
  for (const auto& section : sections)
    if (section != planner_name(!in_3d)) check_kinds(ini, shipped, section);
  count_at(ini, own, "PTG_COUNT");
  if (!in_3d)
    return check_outline(
        ini, own, "RobotModel_shape2D_xs", "RobotModel_shape2D_ys",
        "RobotModel_circular_shape_radius");
  const int levels = count_at(ini, own, "HEIGHT_LEVELS");
  for (int i = 1; i <= levels; i++)
  {
    const std::string level = "LEVEL" + std::to_string(i);
    if (!ini.keyExists(own, level + "_HEIGHT")) refuse(ini, own, level + "_HEIGHT", "above 0");
    check_outline(ini, own, level + "_VECTORX", level + "_VECTORY", level + "_RADIUS");
  }
}

}  // namespace talus::nav
