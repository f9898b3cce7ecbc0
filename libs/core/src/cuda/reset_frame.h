#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
/** Hands over the counters and resets the memory for the next frame; one of `workers` threads. */
struct ResetFrame
{
  std::int32_t* rays;
  int n_rays;
  std::uint32_t* cell_count;
  std::uint32_t* kept_count;
  int n_cells, n_kept;
  std::uint32_t* counters;
  std::uint32_t* reported;
  int n_counters;
  std::uint64_t* cursor;
  int workers;

  TALUS_HD void operator()(int worker) const
  {
    reset(worker, workers);
    if (worker != 0) return;
    for (int i = 0; i < n_counters; i++) reported[i] = counters[i], counters[i] = 0;
    *cursor = 0;
  }

 private:
  TALUS_HD void reset(int first, int step) const
  {
    for (int i = first; i < n_rays; i += step) rays[i] = kNoRay;
    for (int i = first; i < n_cells; i += step) cell_count[i] = 0;
    for (int i = first; i < n_kept; i += step) kept_count[i] = 0;
  }
};

}  // namespace talus::kernels
