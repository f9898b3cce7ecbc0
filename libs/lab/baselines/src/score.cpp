#include <talus/baselines/score.h>

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

constexpr double kRingShare = 0.05, kRingCells = 20;

void add_errors(Figures& out, const std::string& name, const Errors& e)
{
  out.emplace_back(name + "_rmse_m", e.rmse_m());
  out.emplace_back(name + "_p95_m", e.quantile_m(0.95));
  out.emplace_back(name + "_n", static_cast<double>(e.count()));
}

template <class Figure>
struct Named
{
  const char* name;
  Figure Score::*figure;
};
/** In the order of CellState from Measured on; the last one is of unknown cells. */
constexpr Named<Share> kCoverage[]{
    {"coverage_measured", &Score::measured},
    {"coverage_two_sided", &Score::filled_two_sided},
    {"coverage_one_sided", &Score::filled_one_sided},
    {"coverage_presumed", &Score::presumed},
    {"coverage_unknown", &Score::unknown}};
constexpr Named<Errors> kErrors[]{
    {"measured_elevation", &Score::measured_elevation},
    {"two_sided_seen", &Score::two_sided_seen},
    {"two_sided_unseen", &Score::two_sided_unseen},
    {"one_sided", &Score::one_sided},
    {"presumed", &Score::presumed_ground}};
constexpr Named<Share> kShares[]{
    {"hanging_wrong", &Score::hanging_wrong},
    {"hanging_wrong_seen", &Score::hanging_wrong_seen},
    {"hanging_passable", &Score::hanging_passable},
    {"obstacle_blocked", &Score::obstacle_blocked},
    {"obstacle_blocked_whole", &Score::obstacle_blocked_whole},
    {"free_passable", &Score::free_passable},
    {"free_passable_all", &Score::free_passable_all},
    {"posts_kept", &Score::posts},
    {"ditch_found", &Score::ditch_found},
    {"leak", &Score::leak},
    {"leak_hit", &Score::leak_hit},
    {"reach", &Score::reach},
    {"reach_seen", &Score::reach_seen},
    {"beyond", &Score::beyond},
    {"mover_freed", &Score::mover_freed}};

}  // namespace

double Share::value() const { return of > 0 ? part / of : NAN; }

double Errors::rmse_m() const
{
  if (abs_m.empty()) return NAN;
  double sum = 0;
  for (float e : abs_m) sum += static_cast<double>(e) * e;
  return std::sqrt(sum / static_cast<double>(abs_m.size()));
}

double Errors::quantile_m(double q) const { return io::quantile(abs_m, q); }

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

void Score::cover(CellState state)
{
  const auto own =
      (static_cast<std::size_t>(state) + std::size(kCoverage) - 1) % std::size(kCoverage);
  for (std::size_t i = 0; i < std::size(kCoverage); ++i) (this->*kCoverage[i].figure).add(i == own);
}

double Score::inflation_cells() const
{
  double cells = NAN;
  for (int k = 0; k < kRings; ++k)
  {
    const Share& ring = ring_blocked[k];
    if (ring.of < kRingCells) continue;
    if (std::isnan(cells)) cells = 0;
    if (ring.value() > kRingShare) cells = k + 1;
  }
  return cells;
}

Errors Score::all_measured_ground() const
{
  Errors all;
  for (const Errors& e : measured_ground) all.add(e);
  return all;
}

void Score::add(const Score& o)
{
  method = o.method;
  for (std::size_t t = 0; t < kTerrainCount; ++t)
  {
    measured_ground[t].add(o.measured_ground[t]);
    measured_ground_hit[t].add(o.measured_ground_hit[t]);
  }
  bars.add(o.bars);
  for (std::size_t i = 0; i < kTenths; ++i) risky[i].add(o.risky[i]);
  for (std::size_t k = 0; k < kRings; ++k) ring_blocked[k].add(o.ring_blocked[k]);
  for (const auto& e : kErrors) (this->*e.figure).add(o.*e.figure);
  residue_frames.add(o.residue_frames);
  for (const auto& share : kCoverage) (this->*share.figure).add(o.*share.figure);
  for (const auto& share : kShares) (this->*share.figure).add(o.*share.figure);
  update_ms.insert(update_ms.end(), o.update_ms.begin(), o.update_ms.end());
  read_ms.insert(read_ms.end(), o.read_ms.begin(), o.read_ms.end());
  memory_mb = std::max(memory_mb, o.memory_mb);
}

void FillScore::add(const FillScore& o)
{
  fill = o.fill;
  all.add(o.all);
  two_sided.add(o.two_sided);
  one_sided.add(o.one_sided);
  seen.add(o.seen);
  coverage.add(o.coverage);
  ms.insert(ms.end(), o.ms.begin(), o.ms.end());
}

Figures figures(const Score& s)
{
  Figures out{
      {"update_median_ms", io::quantile(s.update_ms, 0.5)},
      {"update_p99_ms", io::quantile(s.update_ms, 0.99)},
      {"read_median_ms", io::quantile(s.read_ms, 0.5)},
      {"memory_mb", s.memory_mb}};
  for (const auto& share : kCoverage) out.emplace_back(share.name, (s.*share.figure).value());
  add_errors(out, "measured_ground", s.all_measured_ground());
  for (std::size_t t = 0; t < kTerrainCount; ++t)
  {
    const std::string name = std::string("measured_ground_") + kTerrainNames[t];
    add_errors(out, name, s.measured_ground[t]);
    add_errors(out, name + "_hit", s.measured_ground_hit[t]);
  }
  for (const auto& e : kErrors) add_errors(out, e.name, s.*e.figure);
  for (const auto& share : kShares) out.emplace_back(share.name, (s.*share.figure).value());
  out.emplace_back("mover_cells", s.mover_freed.of);
  out.emplace_back("residue_median_frames", s.residue_frames.quantile_m(0.5));
  out.emplace_back("residue_max_frames", s.residue_frames.quantile_m(1.0));
  out.emplace_back("inflation_cells", s.inflation_cells());
  return out;
}

Figures figures(const FillScore& s)
{
  Figures out;
  out.emplace_back("ms", io::quantile(s.ms, 0.5));
  out.emplace_back("coverage", s.coverage.value());
  add_errors(out, "all", s.all);
  out.emplace_back("all_median_m", s.all.quantile_m(0.5));
  add_errors(out, "seen", s.seen);
  add_errors(out, "two_sided", s.two_sided);
  add_errors(out, "one_sided", s.one_sided);
  return out;
}

}  // namespace talus::baselines
