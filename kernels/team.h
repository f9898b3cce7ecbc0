#pragma once
#include "kernels/platform.h"

namespace talus::kernels
{
// The points of a cell, or its directions, are looked through by a team: each member takes every
// size()-th, then all learn the team's minimum, maximum or sum. These are exact on what they are
// used for, so that the size of the team does not matter.

struct LoneTeam
{
  TALUS_HD int rank() const { return 0; }
  TALUS_HD int size() const { return 1; }
  TALUS_HD void sync() const {}
  template <class T>
  TALUS_HD T min(T v) const
  {
    return v;
  }
  template <class T>
  TALUS_HD T max(T v) const
  {
    return v;
  }
  template <class T>
  TALUS_HD T sum(T v) const
  {
    return v;
  }
};

#if defined(__CUDACC__)
/** A warp, or each of its threads for itself: one code for both is less to fetch. */
struct DeviceTeam
{
  bool is_warp;

  __device__ int rank() const { return is_warp ? static_cast<int>(threadIdx.x % 32) : 0; }
  __device__ int size() const { return is_warp ? 32 : 1; }
  /** What one member wrote the others read. */
  __device__ void sync() const
  {
    if (is_warp) __syncwarp();
  }
  template <class T>
  __device__ T min(T v) const
  {
    return combine(v, [](T a, T b) { return b < a ? b : a; });
  }
  template <class T>
  __device__ T max(T v) const
  {
    return combine(v, [](T a, T b) { return a < b ? b : a; });
  }
  template <class T>
  __device__ T sum(T v) const
  {
    return combine(v, [](T a, T b) { return a + b; });
  }

 private:
  template <class T, class F>
  __device__ T combine(T v, F f) const
  {
    if (!is_warp) return v;
    for (int other = 16; other; other /= 2) v = f(v, __shfl_xor_sync(0xffffffffu, v, other));
    return v;
  }
};
#endif

}  // namespace talus::kernels
