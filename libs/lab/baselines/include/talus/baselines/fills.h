#pragma once
#include <talus/baselines/method.h>

#include <string>
#include <utility>
#include <vector>

namespace talus::baselines
{
/** Heights of measured ground in a square window, NaN where nothing was measured: what every fill
 * starts from. */
struct SparseGround
{
  Window window;
  std::vector<float> ground_m;
};

/** The measured cells of a map. */
SparseGround measured_ground(const Surfaces& surfaces);

/** Sparse kernel (Melkumyan & Ramos 2009) of a distance, support `length_m`. */
double sparse_kernel(double distance_m, double length_m);

/** Neighbourhood Bayesian kernel inference (Shan et al. 2018): each unknown cell becomes the mean
 * of the measured cells in the square of half side `length_m` around it, weighted by the sparse
 * kernel. NaN where there is none. */
std::vector<float> fill_bgk(const SparseGround& sparse, double length_m = 1.0);

/** Iterated minimum filter (elevation_mapping_cupy): unknown cells take the lowest of their known
 * 3 x 3 neighbours, `iterations` times. */
std::vector<float> fill_min_filter(const SparseGround& sparse, int iterations = 30);

/** cv::inpaint on float heights in steps of 0.1 mm, radius in cells; unknown cells start at the
 * height of the nearest known one. All NaN when nothing is known. */
std::vector<float> fill_inpaint_navier_stokes(const SparseGround& sparse, double radius_cells = 3);
std::vector<float> fill_inpaint_telea(const SparseGround& sparse, double radius_cells = 3);

/** Filled heights by the name of the fill. */
using Fills = std::vector<std::pair<std::string, std::vector<float>>>;

/** The rivals of talus's fill, in the order of tables. */
struct FillMethod
{
  const char* name;
  const char* description;
  std::vector<float> (*fill)(const SparseGround&);
};
const std::vector<FillMethod>& fill_methods();

}  // namespace talus::baselines
