#include "planner_ini.h"

#include "builtin_configs.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>
#include <talus/mrpt/parameters_ini.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
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

enum class Kind
{
  Text,
  Number,
  Numbers,
  YesNo
};

struct Limits
{
  double min, max;
};

/** The numbers at these keys, without digits. MRPT works with any: beyond these it computes without
 * an end, takes all memory, or crashes. */
struct LimitsOf
{
  Limits limits;
  const char* keys;
};
constexpr LimitsOf kLimits[]{
    {{0, 1},
     "clearance_threshold_ratio factornormalizeornot gap_width_ratio_threshold max_deletion_ratio "
     "max_sector_dist_for_d_percent min_normalized_free_space_for_ptg_continuation "
     "obstacle_slow_down_distance phase_threshold risk_evaluation_distance "
     "risk_evaluation_sectors_percent secure_distance_end secure_distance_start "
     "too_close_obstacle wide_gap_size_percent"},
    {{0, 7}, "phase_factors"},
    {{0, 100}, "speedfilter_tau target_slow_approaching_distance"},
    {{0, 360}, "angle_tolerance waypoint_angle_tolerance"},
    {{0, 1000},
     "dist_check_target_is_blocked dist_to_target_for_sending_event factorweights "
     "max_dist_for_timebased_path_prediction max_distance_predicted_actual_path min_dist "
     "multitarget_look_ahead ptg_score_priority robotmincurvradius"},
    {{0, 1e6},
     "alarm_seems_not_approaching_target_timeout hysteresis_check_target_is_blocked "
     "min_timesteps_confirm_skip_waypoints target_attractive_force too_old_seconds"},
    {{-1, 1}, "ptg_k"},
    {{-1, 1e6}, "max_distance_to_allow_skip_waypoint"},
    {{-5, 5}, "level_vectorx level_vectory robotmodel_shaped_xs robotmodel_shaped_ys"},
    {{-100, 100}, "max_obstacles_height min_obstacles_height"},
    {{0.005, 1}, "ptg_resolution"},
    {{0.01, 10},
     "level_height level_radius ptg_turningradiusreference robotmodel_circular_shape_radius"},
    {{0.01, 50}, "ptg_v_max_mps robotmax_v_mps"},
    {{0.01, 100}, "ptg_t_ramp_max"},
    {{0.1, 10000}, "hysteresis_sector_count"},
    {{0.5, 50}, "ptg_refdistance ref_distance"},
    {{1, 10}, "phase_count"},
    {{1, 100}, "height_levels previous_keyframes ptg_count"},
    {{1, 180}, "ptg_cte_av_deg ptg_cte_aw_deg"},
    {{1, 1000}, "ptg_w_max_dps robotmax_w_degps"},
    {{3, 1000}, "ptg_num_paths"}};

Limits limits_of(const std::string& key)
{
  for (const LimitsOf& of : kLimits)
    if ((" " + std::string(of.keys) + " ").find(" " + key + " ") != std::string::npos)
      return of.limits;
  return {-1e6, 1e6};
}

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

void check_limits(
    const CConfigFileBase& ini, const std::string& section, const std::string& key,
    const std::string& name)
{
  const Limits limits = limits_of(name);
  const auto is_inside = [&](const std::string& number)
  {
    const double value = std::strtod(number.c_str(), nullptr);
    return value >= limits.min && value <= limits.max;
  };
  const auto numbers = parts_of(ini_value(ini, section, key));
  if (!std::all_of(numbers.begin(), numbers.end(), is_inside))
    refuse(ini, section, key, mrpt::format("from %g to %g", limits.min, limits.max));
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
    if (kind->second == Kind::Number || kind->second == Kind::Numbers)
      check_limits(ini, section, key, name);
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
  constexpr int kMax = 100;
  const double count = std::strtod(ini_value(ini, section, key).c_str(), nullptr);
  if (!(count >= 1 && count <= kMax && count == std::floor(count)))
    refuse(ini, section, key, "a whole number from 1 to " + std::to_string(kMax));
  return static_cast<int>(count);
}
/** The grid in which a family of paths looks up what it hits grows with the square of its reach. */
void check_paths(const CConfigFileBase& ini, const std::string& section, const std::string& ptg)
{
  constexpr double kMaxCells = 1e6;
  const auto number = [&](const char* key)
  { return std::strtod(ini_value(ini, section, ptg + key).c_str(), nullptr); };
  if (ini.keyExists(section, ptg + "_K") && std::abs(number("_K")) != 1)
    refuse(ini, section, ptg + "_K", "1 or -1");
  if (!ini.keyExists(section, ptg + "_resolution")) return;
  const double side = 2 * number("_refDistance") / number("_resolution");
  if (side * side > kMaxCells)
    refuse(
        ini, section, ptg + "_resolution",
        mrpt::format(
            "%g or more, or %s_refDistance less: its grid would have %.3g cells, the limit is %g",
            2 * number("_refDistance") / std::sqrt(kMaxCells), ptg.c_str(), side * side,
            kMaxCells));
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
  const int ptgs = count_at(ini, own, "PTG_COUNT"), first = in_3d ? 1 : 0;
  for (int i = first; i < first + ptgs; i++) check_paths(ini, own, "PTG" + std::to_string(i));
  if (!in_3d)
    return check_outline(
        ini, own, "RobotModel_shape2D_xs", "RobotModel_shape2D_ys",
        "RobotModel_circular_shape_radius");
  const int levels = count_at(ini, own, "HEIGHT_LEVELS");
  for (int i = 1; i <= levels; i++)
  {
    const std::string level = "LEVEL" + std::to_string(i);
    if (!ini.keyExists(own, level + "_HEIGHT"))
      refuse(ini, own, level + "_HEIGHT", "from 0.01 to 10");
    check_outline(ini, own, level + "_VECTORX", level + "_VECTORY", level + "_RADIUS");
  }
}

}  // namespace talus::nav
