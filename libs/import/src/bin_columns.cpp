#include "label_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "point_fields.h"

namespace talus::import
{
namespace
{
constexpr std::size_t kFeatures = 3, kFloat_bytes = 4;
using Features = std::array<double, kFeatures>;

/** In what the numbers of different fields differ: sign, size, and whether they are whole. */
Features features_of(double value)
{
  if (!std::isfinite(value)) return {0, 0, 2};
  constexpr double kSmallest = 1e-3, kLargest = 1e3;
  const double size = std::clamp(std::abs(value), kSmallest, kLargest);
  return {
      value < 0 ? 1.0 : 0.0, std::trunc(value) == value ? 1.0 : 0.0,
      std::log10(size) / 3};  // from -1 to 1
}

std::vector<Features> features_of(std::string_view bytes)
{
  constexpr std::size_t kEnough = 840 * 60;  // 840: a multiple of 3 to 8
  const bool swapped = is_big_endian_host();
  std::vector<Features> all(std::min(bytes.size() / kFloat_bytes, kEnough));
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = features_of(number_at(bytes.data() + kFloat_bytes * i, NumberType::Float32, swapped));
  return all;
}

/** The share of the variance of a feature that lies between the columns, not in them: 0 to 1. */
double explained(const std::vector<Features>& all, std::size_t columns, std::size_t feature)
{
  std::vector<double> sums(columns);
  double sum = 0, squares = 0;
  const std::size_t count = all.size() / columns * columns;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double value = all[i][feature];
    sums[i % columns] += value;
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(count);
  const double total = squares - sum * sum / n;
  double between = -sum * sum / n;
  for (const double column : sums) between += column * column * static_cast<double>(columns) / n;
  constexpr double kSame = 1e-9;
  return total > kSame * n ? between / total : 0;
}

double explained(const std::vector<Features>& all, std::size_t columns)
{
  double sum = 0;
  for (std::size_t f = 0; f < kFeatures; ++f) sum += explained(all, columns, f);
  return sum / kFeatures;
}
}  // namespace

std::size_t floats_a_point(std::string_view bytes, std::size_t expected)
{
  constexpr std::size_t kMinCount = 3, kMax = 8, kMinPoints = 500;
  constexpr double kClearly = 0.05;  // that much better; chance gives 0.01 with the fewest
  if (bytes.size() < kMinPoints * kMax * kFloat_bytes) return expected;
  const auto all = features_of(bytes);
  std::size_t best = expected;
  double most = explained(all, expected) + kClearly;
  for (std::size_t columns = kMinCount; columns <= kMax; ++columns)
  {
    if (bytes.size() % (columns * kFloat_bytes) != 0 || columns % expected == 0) continue;
    // A multiple of the right one explains as much, and more where two beams take turns.
    const bool is_multiple = best != expected && columns % best == 0;
    if (const double share = explained(all, columns); share > most + (is_multiple ? kClearly : 0))
    {
      best = columns;
      most = share;
    }
  }
  return best;
}

}  // namespace talus::import
