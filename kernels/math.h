#pragma once
// One source for host and device: IEEE-exact operations only (+ - * / sqrt, comparisons, integers),
// compiled without contraction, so that every backend computes the same bits.

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__CUDACC__)
#define TALUS_HD __host__ __device__ inline
#else
#define TALUS_HD inline
#endif

namespace talus::kernels
{
constexpr float kNan = __builtin_nanf("");
constexpr float kInfinity = __builtin_inff();

TALUS_HD bool is_known(float v) { return v == v; }
TALUS_HD bool is_finite(float v) { return v - v == 0.0f; }
TALUS_HD float min_of(float a, float b) { return b < a ? b : a; }
TALUS_HD float max_of(float a, float b) { return a < b ? b : a; }
TALUS_HD int min_of(int a, int b) { return b < a ? b : a; }
TALUS_HD int max_of(int a, int b) { return a < b ? b : a; }
TALUS_HD std::int64_t min_of(std::int64_t a, std::int64_t b) { return b < a ? b : a; }
TALUS_HD std::int64_t max_of(std::int64_t a, std::int64_t b) { return a < b ? b : a; }
TALUS_HD int abs_of(int a) { return a < 0 ? -a : a; }

/** floor() as an integer; |v| < 2^31. */
TALUS_HD int floor_to_int(float v)
{
  const int i = static_cast<int>(v);
  return i - (v < static_cast<float>(i));
}

/** Integer quotient rounded down; b > 0, quotients below 2^20. `inverse` = 1 / b: the float is off
 * by at most one. Use it where integer division is slow: on devices and in vectors. */
TALUS_HD int floor_div(int a, int b, float inverse)
{
  const int q = floor_to_int(static_cast<float>(a) * inverse);
  const int rest = a - q * b;
  return q + (rest >= b) - (rest < 0);
}

/** Integer quotient rounded down; b > 0. */
TALUS_HD int floor_div(int a, int b)
{
#if defined(__CUDA_ARCH__)
  return floor_div(a, b, 1.0f / static_cast<float>(b));
#else
  return a >= 0 ? a / b : -((-a + b - 1) / b);
#endif
}

/** The double nearest to an integer. Vectors of most processors do not convert 64 bits. */
TALUS_HD double double_of(std::int64_t v)
{
#if defined(__CUDA_ARCH__)
  return static_cast<double>(v);
#else
  // Both halves are exact, and their sum is rounded once.
  const auto high = static_cast<std::int32_t>(v >> 32);
  const auto low = static_cast<std::uint32_t>(v);
  return static_cast<double>(high) * 4294967296.0 + static_cast<double>(low);
#endif
}

/** Heights are summed as integers relative to the sensor within +-32 m. In units of 1/4096 m, sums
 * of 31 x 31 cells, times an offset of 15 cells, are exact in 32 bits. */
constexpr float kHeightUnits = 4096.0f, kMaxHeight_m = 32.0f;

TALUS_HD int quantise_height(float height_m, float reference_m, float units_per_m = kHeightUnits)
{
  const float units = (height_m - reference_m) * units_per_m + 0.5f;
  const float limit = kMaxHeight_m * units_per_m;
  return floor_to_int(min_of(max_of(units, -limit), limit));
}

TALUS_HD std::uint32_t bits_of(float v)
{
  std::uint32_t bits;
  std::memcpy(&bits, &v, sizeof bits);
  return bits;
}

TALUS_HD float float_of_bits(std::uint32_t bits)
{
  float v;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

/** c ? a : b with both values computed, so that compilers vectorise loops. */
TALUS_HD std::int32_t select(bool c, std::int32_t a, std::int32_t b) { return c ? a : b; }
TALUS_HD std::int64_t select(bool c, std::int64_t a, std::int64_t b) { return c ? a : b; }
TALUS_HD float select(bool c, float a, float b) { return c ? a : b; }
TALUS_HD bool select(bool c, bool a, bool b) { return (c & a) | (!c & b); }

TALUS_HD float clamp01(float v) { return select(v < 0.0f, 0.0f, select(v > 1.0f, 1.0f, v)); }

TALUS_HD float abs_of(float a) { return float_of_bits(bits_of(a) & 0x7fffffffu); }

/** An integer with the order of the floats, so that an integer minimum is a minimum of floats. */
TALUS_HD std::int32_t ordered_from_float(float v)
{
  const auto bits = static_cast<std::int32_t>(bits_of(v));
  return bits >= 0 ? bits : bits ^ 0x7fffffff;
}

TALUS_HD float float_from_ordered(std::int32_t ordered)
{
  return float_of_bits(static_cast<std::uint32_t>(ordered >= 0 ? ordered : ordered ^ 0x7fffffff));
}

/** atan(t) for t >= 0 [rad], error below 2e-6 rad (polynomial of Abramowitz & Stegun 4.4.49). */
TALUS_HD float arctangent(float t)
{
  const bool beyond_one = t > 1.0f;
  const float u = select(beyond_one, 1.0f / t, t);
  // Pairs of terms need not wait for each other.
  const float s = u * u, s2 = s * s;
  const float low = 0.1999355085f * s - 0.3333314528f + (0.1065626393f * s - 0.1420889944f) * s2;
  const float high = 0.0429096138f * s - 0.0752896400f + (0.0028662257f * s - 0.0161657367f) * s2;
  const float a = u + u * s * (low + high * (s2 * s2));
  return select(beyond_one, 1.57079632679f - a, a);
}

}  // namespace talus::kernels
