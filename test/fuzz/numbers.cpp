// For binary formats, beside libFuzzer's own mutations: numbers that readers stumble over, where a
// number may be.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
extern "C" std::size_t LLVMFuzzerCustomMutator(
    std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

namespace
{
template <class T>
void put(std::uint8_t* data, std::size_t size, std::size_t at, T value)
{
  if (at + sizeof value <= size) std::memcpy(data + at, &value, sizeof value);
}

double stumbling_block(std::minstd_rand& random)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNumbers[] = {0,   -1,  1,    2,   7,     77,   255,     1000,      65536,
                                 1e6, 1e9, -1e9, 3e9, 1e-30, 1e19, 1.7e308, kInfinity, -kInfinity};
  const auto which = random() % (std::size(kNumbers) + 1);
  return which < std::size(kNumbers) ? kNumbers[which] : std::nan("");
}

/** Of any size and sign, small ones as often as large ones. */
std::uint64_t whole_number(std::minstd_rand& random)
{
  const std::uint64_t bits = std::uint64_t{random()} << 32 ^ std::uint64_t{random()} << 8;
  return random() % 8 == 0 ? ~std::uint64_t{0} : bits >> random() % 64;
}
}  // namespace

std::size_t LLVMFuzzerCustomMutator(
    std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed)
{
  std::minstd_rand random(seed);
  if (size < sizeof(double) || random() % 2) return LLVMFuzzerMutate(data, size, most);
  const std::size_t at = random() % size;
  switch (random() % 4)
  {
    case 0:
      put(data, size, at, stumbling_block(random));
      break;
    case 1:
      put(data, size, at, static_cast<float>(stumbling_block(random)));
      break;
    case 2:
      put(data, size, at, whole_number(random));
      break;
    default:
      put(data, size, at, static_cast<std::uint32_t>(whole_number(random)));
  }
  return size;
}
