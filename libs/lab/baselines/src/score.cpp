#include <talus/baselines/score.h>

#include <talus/io/quantile.h>

#include <algorithm>
#include <cmath>

#include "nan.h"

namespace talus::baselines
{
namespace
{
constexpr double kRingShare = 0.05, kRingCells = 20;

using Figures = std::vector<std::pair<std::string, double>>;

void add_errors(Figures& out, const std::string& name, const Errors& e)
{
  out.emplace_back(name + "_rmse_m", e.rmse_m());
  out.emplace_back(name + "_p95_m", e.quantile_m(0.95));
  out.emplace_back(name + "_n", static_cast<double>(e.count()));
}

void add_cost(Figures& out, const Score& s)
{
  out.emplace_back("update_median_ms", io::quantile(s.update_ms, 0.5));
  out.emplace_back("update_p99_ms", io::quantile(s.update_ms, 0.99));
  out.emplace_back("read_median_ms", io::quantile(s.read_ms, 0.5));
  out.emplace_back("memory_mb", s.memory_mb);
}

}  // namespace

double Share::value() const { return of > 0 ? part / of : kNan; }

double Errors::rmse_m() const
{
  if (abs_m.empty()) return kNan;
  double sum = 0;
  for (float e : abs_m) sum += static_cast<double>(e) * e;
  return std::sqrt(sum / static_cast<double>(abs_m.size()));
}

double Errors::quantile_m(double q) const { return io::quantile(abs_m, q); }

double Score::inflation_cells() const
{
  double cells = kNan;
  for (int k = 0; k < kRings; ++k)
  {
    const Share& ring = ring_blocked[static_cast<std::size_t>(k)];
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
  for (Errors Score::*e :
       {&Score::measured_elevation, &Score::two_sided_seen, &Score::two_sided_unseen,
        &Score::one_sided, &Score::presumed_ground, &Score::residue_frames})
    (this->*e).add(o.*e);
  for (Share Score::*s :
       {&Score::measured,
        &Score::filled_two_sided,
        &Score::filled_one_sided,
        &Score::presumed,
        &Score::unknown,
        &Score::hanging_wrong,
        &Score::hanging_wrong_seen,
        &Score::hanging_passable,
        &Score::obstacle_blocked,
        &Score::obstacle_blocked_whole,
        &Score::free_passable,
        &Score::free_passable_all,
        &Score::posts,
        &Score::ditch_found,
        &Score::leak,
        &Score::leak_hit,
        &Score::reach,
        &Score::reach_seen,
        &Score::beyond,
        &Score::mover_freed})
    (this->*s).add(o.*s);
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
  Figures out;
  add_cost(out, s);
  for (const auto& [name, share] : std::initializer_list<std::pair<const char*, Share>>{
           {"coverage_measured", s.measured},
           {"coverage_two_sided", s.filled_two_sided},
           {"coverage_one_sided", s.filled_one_sided},
           {"coverage_presumed", s.presumed},
           {"coverage_unknown", s.unknown}})
    out.emplace_back(name, share.value());
  add_errors(out, "measured_ground", s.all_measured_ground());
  for (std::size_t t = 0; t < kTerrainCount; ++t)
  {
    const std::string name = std::string("measured_ground_") + kTerrainNames[t];
    add_errors(out, name, s.measured_ground[t]);
    add_errors(out, name + "_hit", s.measured_ground_hit[t]);
  }
  add_errors(out, "measured_elevation", s.measured_elevation);
  add_errors(out, "two_sided_seen", s.two_sided_seen);
  add_errors(out, "two_sided_unseen", s.two_sided_unseen);
  add_errors(out, "one_sided", s.one_sided);
  add_errors(out, "presumed", s.presumed_ground);
  for (const auto& [name, share] : std::initializer_list<std::pair<const char*, Share>>{
           {"hanging_wrong", s.hanging_wrong},
           {"hanging_wrong_seen", s.hanging_wrong_seen},
           {"hanging_passable", s.hanging_passable},
           {"obstacle_blocked", s.obstacle_blocked},
           {"obstacle_blocked_whole", s.obstacle_blocked_whole},
           {"free_passable", s.free_passable},
           {"free_passable_all", s.free_passable_all},
           {"posts_kept", s.posts},
           {"ditch_found", s.ditch_found},
           {"leak", s.leak},
           {"leak_hit", s.leak_hit},
           {"reach", s.reach},
           {"reach_seen", s.reach_seen},
           {"beyond", s.beyond},
           {"mover_freed", s.mover_freed}})
    out.emplace_back(name, share.value());
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
