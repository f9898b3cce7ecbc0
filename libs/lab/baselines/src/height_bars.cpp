#include <talus/baselines/height_bars.h>

#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>

namespace talus::baselines
{
namespace
{
constexpr double kOneDeviation = 0.6827;  //!< of a normal distribution, within one deviation

/** The deviations that hold `probability` of a normal distribution, by bisection. */
double deviations_of(double probability)
{
  double low = 0, high = 10;
  for (int i = 0; i < 60; ++i)
  {
    const double middle = (low + high) / 2;
    (std::erf(middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return low;
}
}  // namespace

void EstimateErrors::add(float error_m, float variance_m2)
{
  if (!(variance_m2 >= 0) || std::isnan(error_m)) return;
  abs_m.push_back(std::abs(error_m));
  estimated_m.push_back(std::sqrt(variance_m2));
}

void EstimateErrors::add(const EstimateErrors& o)
{
  abs_m.insert(abs_m.end(), o.abs_m.begin(), o.abs_m.end());
  estimated_m.insert(estimated_m.end(), o.estimated_m.begin(), o.estimated_m.end());
}

double EstimateErrors::within(double deviations) const
{
  if (abs_m.empty()) return NAN;
  std::size_t inside = 0;
  for (std::size_t i = 0; i < abs_m.size(); ++i)
    inside += static_cast<double>(abs_m[i]) <= deviations * static_cast<double>(estimated_m[i]);
  return static_cast<double>(inside) / static_cast<double>(abs_m.size());
}

double EstimateErrors::share_within(double probability) const
{
  return within(deviations_of(probability));
}

double EstimateErrors::median_estimated_m() const { return io::quantile(estimated_m, 0.5); }
double EstimateErrors::true_m() const { return io::quantile(abs_m, kOneDeviation); }

void HeightBars::add(const Surfaces& map, std::size_t k, float error_m, float reference_m2)
{
  const auto state = static_cast<CellState>(map.state[k]);
  if (map.variance_m2.empty() || state == CellState::Unknown) return;
  const int n = map.window.cells, cell = static_cast<int>(k);
  const double x = cell % n + 0.5 - 0.5 * n, y = static_cast<int>(cell / n) + 0.5 - 0.5 * n;
  const bool is_far = std::hypot(x, y) > 0.25 * n;
  const auto kind = static_cast<std::size_t>(state) - static_cast<std::size_t>(CellState::Measured);
  of_[kind][is_far ? 1 : 0].add(error_m, map.variance_m2[k] + reference_m2);
}

void HeightBars::add(const HeightBars& o)
{
  for (std::size_t kind = 0; kind < of_.size(); ++kind)
    for (std::size_t i = 0; i < of_[kind].size(); ++i) of_[kind][i].add(o.of_[kind][i]);
}

EstimateErrors HeightBars::all(int kind) const
{
  EstimateErrors both = near(kind);
  both.add(far(kind));
  return both;
}

bool HeightBars::empty() const
{
  for (const auto& kind : of_)
    for (const EstimateErrors& errors : kind)
      if (errors.count() > 0) return false;
  return true;
}

}  // namespace talus::baselines
