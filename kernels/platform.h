#pragma once
// One source for host and device: IEEE-exact operations only (+ - * / sqrt, comparisons, integers),
// compiled without contraction, so that every backend computes the same bits.

#include <cstdint>

#if defined(__CUDACC__)
#define TALUS_HD __host__ __device__ inline
#else
#define TALUS_HD inline
#endif
