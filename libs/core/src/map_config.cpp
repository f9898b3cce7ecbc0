#include "backend.h"
#include <talus/parameters.h>
#include "kernels/6_fill.h"
#include "kernels/9_channels.h"
#include "kernels/rule_constants.h"
#include "kernels/rule_switches.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>

namespace talus
{
namespace
{
static_assert(kMaxBodyBoxes == kernels::kMaxBodyBoxes);

kernels::Body body_of(const std::vector<BodyBox>& boxes)
{
  kernels::Body body{};
  for (const BodyBox& b : boxes)
  {
    const double ends[3][2] = {
        {b.min_x_m, b.max_x_m}, {b.min_y_m, b.max_y_m}, {b.min_z_m, b.max_z_m}};
    for (int axis = 0; axis < 3; axis++)
    {
      body.min_m[body.boxes][axis] = static_cast<float>(ends[axis][0]);
      body.max_m[body.boxes][axis] = static_cast<float>(ends[axis][1]);
    }
    body.boxes++;
  }
  return body;
}

kernels::Config stages_config(const Parameters& p)
{
  const auto f = [](double v) { return static_cast<float>(v); };
  kernels::Config k{};
#define TALUS_TAKE(type, name) k.name = static_cast<type>(p.name);
  TALUS_TAKEN_PARAMETERS(TALUS_TAKE)
#undef TALUS_TAKE
  k.cells = p.cells();
  k.inverse_resolution = f(1 / p.resolution_m);
  k.min_range2_m2 = f(p.min_range_m * p.min_range_m);
  k.max_range2_m2 = f(p.max_range_m * p.max_range_m);
  k.inverse_voxel = p.voxel_m > 0 ? f(1 / p.voxel_m) : 0;
  k.gate2 = f(p.mahalanobis_gate * p.mahalanobis_gate);
  k.start_automatic = p.start_radius_m < 0;
  k.start_radius_m = k.start_automatic ? kernels::kStartsWithin_m : f(p.start_radius_m);
  k.object_radius = static_cast<int>(std::lround(p.object_size_m / (4 * p.resolution_m)));
  k.max_slope = f(std::tan(p.slope_threshold_rad));
  k.fill_search_m = f(std::min(p.fill_search_m, kernels::kInferred * p.resolution_m));
  k.inverse_fill_kernel = f(1 / p.fill_kernel_m);
  k.feature_radius_cells =
      std::max(1, static_cast<int>(std::lround(p.feature_radius_m / p.resolution_m)));
  k.inverse_slope_threshold = f(1 / p.slope_threshold_rad);
  k.inverse_step_threshold = f(1 / p.step_threshold_m);
  k.inverse_roughness_threshold = f(1 / p.roughness_threshold_m);
  return k;
}
}  // namespace

#if defined(TALUS_RULE_SWITCHES)
namespace
{
/** The rules that TALUS_WITHOUT_RULES names, "27,30", as bits of Config::rules_off. */
std::uint64_t rules_off()
{
  const char* const named = std::getenv(kWithoutRulesVariable);
  std::istringstream numbers(named ? named : "");
  std::uint64_t off = 0;
  for (std::string number; std::getline(numbers, number, ',');)
  {
    const int rule = std::atoi(number.c_str());
    const auto is = [rule](kernels::Rule known) { return known == rule; };
    if (std::none_of(std::begin(kernels::kRules), std::end(kernels::kRules), is))
      throw std::invalid_argument(
          std::string(kWithoutRulesVariable) + ": rule '" + number + "' has no switch");
    off |= std::uint64_t{1} << rule;
  }
  return off;
}

/** Switches off the rules that are parameters. */
void switch_off(MapConfig& c)
{
  c.config.rules_off = rules_off();
  if (!kernels::on(kernels::kHeightBand, c.config)) c.config.min_height_m = -1.0f;  // paper
  if (!kernels::on(kernels::kBodyBoxes, c.config)) c.body = {};
}
}  // namespace
#endif

std::vector<int> switchable_rules()
{
#if defined(TALUS_RULE_SWITCHES)
  return {std::begin(kernels::kRules), std::end(kernels::kRules)};
#else
  return {};
#endif
}

MapConfig make_config(const Parameters& p)
{
  MapConfig c{stages_config(p), body_of(p.body_boxes_m), {}, {}};
  for (const Channel& channel : p.channels) c.channels.push_back(channel.rule);
  if (!p.channel_cost.empty())
    c.class_scores.assign(p.channels.size() * kChannelClasses, kernels::kInfinity);
  for (const ChannelCost& cost : p.channel_cost)
  {
    const std::size_t of_channel =
        kChannelClasses * channel_layer(p.channels, cost.channel, "map") / kChannelSurfaces;
    c.class_scores[of_channel + static_cast<std::size_t>(cost.class_of)] =
        static_cast<float>(cost.score);
  }
#if defined(TALUS_RULE_SWITCHES)
  switch_off(c);
#endif
  return c;
}

}  // namespace talus
