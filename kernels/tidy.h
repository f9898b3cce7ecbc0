#pragma once
#include "kernels/rays.h"

namespace talus::kernels
{
/** Hands the counters out, and leaves what the next frame expects to find. */
struct TidyUp
{
  std::int32_t* rays;
  int n_rays;
  std::uint32_t* cell_count;
  int n_cells;
  std::uint32_t* rejected;
  std::uint32_t* reported;
  int n_reasons;
  std::uint64_t* cursor;

  TALUS_HD void operator()(int i) const
  {
    if (i < n_rays) rays[i] = kNoRay;
    if (i < n_cells) cell_count[i] = 0;
    if (i < n_reasons) reported[i] = rejected[i];
    if (i < n_reasons) rejected[i] = 0;
    if (i == 0) *cursor = 0;
  }
};

}  // namespace talus::kernels
