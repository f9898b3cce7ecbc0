#include "config.h"

#include <algorithm>
#include <cmath>

namespace talus
{
namespace
{
/** At the end of the kernel's support samples weigh nothing: the prior alone says what is there. */
constexpr double kLeastLambda = 1e-6;
}  // namespace

kernels::Config make_config(const Parameters& p)
{
  const auto f = [](double v) { return static_cast<float>(v); };
  kernels::Config k{};
  k.cells = p.cells();
  k.resolution_m = f(p.resolution_m);
  k.inverse_resolution = f(1 / p.resolution_m);
  k.min_range2_m2 = f(p.min_range_m * p.min_range_m);
  k.max_range2_m2 = f(p.max_range_m * p.max_range_m);
  k.min_height_m = f(p.min_height_m);
  k.max_height_m = f(p.max_height_m);
  const double low[3] = {p.body_min_x_m, p.body_min_y_m, p.body_min_z_m};
  const double high[3] = {p.body_max_x_m, p.body_max_y_m, p.body_max_z_m};
  k.has_body = low[0] < high[0] && low[1] < high[1] && low[2] < high[2];
  for (int i = 0; i < 3; i++) k.body_min_m[i] = f(low[i]), k.body_max_m[i] = f(high[i]);
  k.inverse_voxel = p.voxel_m > 0 ? f(1 / p.voxel_m) : 0;
  k.c_beam_m = f(p.c_beam_m);
  k.a_beam = f(p.a_beam);
  k.gate2 = f(p.mahalanobis_gate * p.mahalanobis_gate);
  k.min_variance_m2 = f(p.min_variance_m2);
  k.clearance_m = f(p.clearance_m);
  k.cleanup_margin_m = f(p.cleanup_margin_m);
  k.cleanup_frames = p.cleanup_frames;
  k.object_radius = static_cast<int>(std::lround(p.object_size_m / (4 * p.resolution_m)));
  k.max_slope = f(std::tan(p.slope_threshold_rad));
  k.fill_search_m = f(p.fill_search_m);
  k.fill_lambda = f(std::max(p.fill_lambda, kLeastLambda));
  k.inverse_fill_kernel = f(1 / p.fill_kernel_m);
  k.fill_variance_per_m = f(p.fill_variance_per_m);
  k.fill_samples = p.fill_samples;
  k.fill_rule = static_cast<int>(p.fill_rule);
  k.fill_use_ray_bound = p.fill_use_ray_bound;
  k.feature_radius_cells =
      std::max(1, static_cast<int>(std::lround(p.feature_radius_m / p.resolution_m)));
  k.inverse_slope_threshold = f(1 / p.slope_threshold_rad);
  k.step_threshold_m = f(p.step_threshold_m);
  k.inverse_step_threshold = f(1 / p.step_threshold_m);
  k.inverse_roughness_threshold = f(1 / p.roughness_threshold_m);
  k.weight_slope = f(p.weight_slope);
  k.weight_step = f(p.weight_step);
  k.weight_roughness = f(p.weight_roughness);
  k.sparsity_range_m = f(p.sparsity_range_m);
  k.sparsity_distance_m = f(p.sparsity_distance_m);
  k.sparsity_search_m = f(p.sparsity_search_m);
  return k;
}

}  // namespace talus
