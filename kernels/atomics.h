#pragma once
#include "kernels/math.h"

#if defined(__CUDACC__)
#include <cooperative_groups.h>
#include <cooperative_groups/scan.h>
#endif

namespace talus::kernels
{
/** Read-modify-write on integers that many points may change. They are integers because their
 * result does not depend on the order. Each executor names the policy that its threads need. */
struct SerialAtomics
{
  /** Adds one, where many points share few counters. */
  static TALUS_HD void count(std::uint32_t* where) { *where += 1; }
  static TALUS_HD std::uint32_t add(std::uint32_t* where, std::uint32_t value)
  {
    const std::uint32_t before = *where;
    *where = before + value;
    return before;
  }
  static TALUS_HD void add(std::uint64_t* where, std::uint64_t value) { *where += value; }
  template <class T>
  static TALUS_HD void min(T* where, T value)
  {
    if (value < *where) *where = value;
  }
  static TALUS_HD void max(std::int32_t* where, std::int32_t value)
  {
    if (value > *where) *where = value;
  }
  /** Stores `value` if the old value is `expected`; returns the old value. */
  static TALUS_HD std::uint64_t compare_exchange(
      std::uint64_t* where, std::uint64_t expected, std::uint64_t value)
  {
    const std::uint64_t before = *where;
    if (before == expected) *where = value;
    return before;
  }
};

struct ThreadAtomics
{
  static void count(std::uint32_t* where) { add(where, 1); }
  static std::uint32_t add(std::uint32_t* where, std::uint32_t value)
  {
    return __atomic_fetch_add(where, value, __ATOMIC_RELAXED);
  }
  static void add(std::uint64_t* where, std::uint64_t value)
  {
    __atomic_fetch_add(where, value, __ATOMIC_RELAXED);
  }
  template <class T>
  static void min(T* where, T value)
  {
    T seen = __atomic_load_n(where, __ATOMIC_RELAXED);
    while (value < seen && !__atomic_compare_exchange_n(
                               where, &seen, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
    {
    }
  }
  static void max(std::int32_t* where, std::int32_t value)
  {
    std::int32_t seen = __atomic_load_n(where, __ATOMIC_RELAXED);
    while (value > seen && !__atomic_compare_exchange_n(
                               where, &seen, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
    {
    }
  }
  static std::uint64_t compare_exchange(
      std::uint64_t* where, std::uint64_t expected, std::uint64_t value)
  {
    __atomic_compare_exchange_n(where, &expected, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
    return expected;
  }
};

#if defined(__CUDACC__)
/** A warp whose threads change the same number does so in one operation. */
struct DeviceAtomics
{
  static __device__ void count(std::uint32_t* where)
  {
    const unsigned same =
        __match_any_sync(__activemask(), reinterpret_cast<unsigned long long>(where));
    const unsigned lane = threadIdx.x & 31u;
    if ((same & ((1u << lane) - 1u)) == 0) atomicAdd(where, static_cast<unsigned>(__popc(same)));
  }
  /** Adds to one counter that all threads share; returns its old value. */
  static __device__ std::uint64_t reserve(std::uint64_t* where, std::uint64_t value)
  {
    const auto together = cooperative_groups::coalesced_threads();
    const std::uint64_t before = cooperative_groups::exclusive_scan(together, value);
    const auto last = together.num_threads() - 1;
    unsigned long long begin = 0;
    if (together.thread_rank() == last)
      begin = atomicAdd(
          reinterpret_cast<unsigned long long*>(where),
          static_cast<unsigned long long>(before + value));
    return before + together.shfl(begin, last);
  }
  static __device__ std::uint32_t add(std::uint32_t* where, std::uint32_t value)
  {
    return atomicAdd(where, value);
  }
  static __device__ void add(std::uint64_t* where, std::uint64_t value)
  {
    atomicAdd(reinterpret_cast<unsigned long long*>(where), static_cast<unsigned long long>(value));
  }
  static __device__ void min(std::int32_t* where, std::int32_t value) { atomicMin(where, value); }
  static __device__ void max(std::int32_t* where, std::int32_t value) { atomicMax(where, value); }
  static __device__ void min(std::uint64_t* where, std::uint64_t value)
  {
    atomicMin(reinterpret_cast<unsigned long long*>(where), static_cast<unsigned long long>(value));
  }
  static __device__ std::uint64_t compare_exchange(
      std::uint64_t* where, std::uint64_t expected, std::uint64_t value)
  {
    return atomicCAS(
        reinterpret_cast<unsigned long long*>(where), static_cast<unsigned long long>(expected),
        static_cast<unsigned long long>(value));
  }
};
#endif

}  // namespace talus::kernels
