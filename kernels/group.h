#pragma once
#include "kernels/math.h"

#include <cstdint>

namespace talus::kernels
{
// A group shares the points or directions of a cell: each member takes every size()-th, then all
// get the minimum, maximum or sum. These are exact, so that the group's size does not matter.

struct SerialGroup
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
/** A warp, or one thread for itself: one code for both is less to fetch. */
struct WarpGroup
{
  bool is_warp;

  __device__ int rank() const { return is_warp ? static_cast<int>(threadIdx.x % 32) : 0; }
  __device__ int size() const { return is_warp ? 32 : 1; }
  /** Makes the writes of each member visible to all. */
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
  __device__ std::int32_t sum(std::int32_t v) const { return is_warp ? warp_sum(v) : v; }
  /** Adds parts whose sums fit into a word. */
  __device__ std::int64_t sum(std::int64_t v) const
  {
    if (!is_warp) return v;
    constexpr std::uint32_t kLow = (1u << 26) - 1;
    const auto low = static_cast<std::uint32_t>(v) & kLow;
    const auto middle = static_cast<std::uint32_t>(v >> 26) & kLow;
    return static_cast<std::int64_t>(warp_sum(static_cast<std::int32_t>(v >> 52))) * (1ll << 52) +
           (static_cast<std::int64_t>(warp_sum(middle)) << 26) + warp_sum(low);
  }

 private:
  template <class T>
  static __device__ T warp_sum(T v)
  {
#if __CUDA_ARCH__ >= 800
    return __reduce_add_sync(0xffffffffu, v);
#else
    return WarpGroup{true}.combine(v, [](T a, T b) { return a + b; });
#endif
  }
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
