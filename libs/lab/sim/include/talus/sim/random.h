#pragma once
#include <cmath>
#include <cstdint>

namespace talus::sim
{
/** Random numbers as a function of what they are for (seed, frame, ray, ...): the same on every
 * platform with IEEE arithmetic, and independent of the order in which they are asked for. */
inline std::uint64_t mix(std::uint64_t v)
{
  v += 0x9E3779B97F4A7C15ull;  // splitmix64
  v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9ull;
  v = (v ^ (v >> 27)) * 0x94D049BB133111EBull;
  return v ^ (v >> 31);
}
inline std::uint64_t mix(std::uint64_t seed, std::uint64_t value) { return mix(mix(seed) ^ value); }

/** Uniform in [0, 1). */
inline double uniform(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

/** A sequence of numbers from one seed. */
class Random
{
 public:
  explicit Random(std::uint64_t seed) : state_(mix(seed)) {}

  /** Uniform in [0, 1). */
  double uniform() { return sim::uniform(mix(state_++)); }
  /** Uniform in [low, high). */
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /** Mean 0, standard deviation 1 (Box-Muller). */
  double normal()
  {
    const double u = 1.0 - uniform();  // (0, 1]
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace talus::sim
