#include <talus/baselines/budgets.h>

#include <algorithm>
#include <cmath>

#include "nan.h"

namespace talus::baselines
{
namespace
{
constexpr double kMinCount = 20;
/** Fills err by so much at least: less is a fifteenth of the noise of a range. */
constexpr double kMinError_m = 0.001;
using Results = std::vector<BudgetResult>;

void judge(Results& out, const std::string& name, double value, double limit, bool at_most)
{
  BudgetResult r{name, value, limit, at_most, BudgetResult::Verdict::NotApplicable, ""};
  if (!std::isnan(value))
    r.verdict = (at_most ? value <= limit : value >= limit) ? BudgetResult::Verdict::Pass
                                                            : BudgetResult::Verdict::Fail;
  out.push_back(r);
}

void judge(Results& out, const std::string& name, const Errors& e, double limit_m)
{
  judge(out, name, static_cast<double>(e.count()) >= kMinCount ? e.rmse_m() : kNan, limit_m, true);
}

void judge(
    Results& out, const std::string& name, const Share& s, double limit, bool at_most,
    double fewest = kMinCount)
{
  judge(out, name, s.of >= fewest ? s.value() : kNan, limit, at_most);
}

/** All, and then what of it a ray could show. */
template <class What, class... Limit>
void judge_with_seen(
    Results& out, const std::string& name, const What& all, const std::string& name_seen,
    const What& seen, Limit... limit)
{
  judge(out, name, all, limit...);
  out.back().as_seen = name_seen;
  judge(out, name_seen, seen, limit...);
}

void judge_measured_ground(Results& out, const Score& s)
{
  constexpr double kLimits_m[kTerrainCount] = {0.003, 0.003, 0.008, 0.030};
  for (std::size_t t = 0; t < kTerrainCount; ++t)
  {
    const std::string name = std::string("measured_ground_") + kTerrainNames[t];
    judge_with_seen(
        out, name + "_rmse_m", s.measured_ground[t], name + "_hit_rmse_m", s.measured_ground_hit[t],
        kLimits_m[t]);
  }
}

void judge_fills(Results& out, const std::vector<FillScore>& fills)
{
  for (std::size_t f = 1; f < fills.size(); ++f)
  {
    const Errors &own = fills[0].seen, &other = fills[f].seen;
    const bool enough = static_cast<double>(own.count()) >= kMinCount;
    const auto error_m = [](const Errors& e) { return std::max(e.rmse_m(), kMinError_m); };
    judge(
        out, "fill_beats_" + fills[f].fill, enough ? error_m(own) / error_m(other) : kNan, 1.0,
        true);
  }
}

}  // namespace

Results check_budgets(const Evaluation& e)
{
  Results out;
  for (const Score& s : e.maps)
  {
    if (s.method != "talus") continue;
    judge_measured_ground(out, s);
    judge(out, "two_sided_seen_rmse_m", s.two_sided_seen, 0.03);
    judge_with_seen(
        out, "hanging_wrong", s.hanging_wrong, "hanging_wrong_seen", s.hanging_wrong_seen, 0.02,
        true);
    judge(out, "hanging_passable", s.hanging_passable, 0.98, false);
    judge_with_seen(
        out, "obstacle_blocked", s.obstacle_blocked, "obstacle_blocked_whole",
        s.obstacle_blocked_whole, 0.98, false);
    judge(out, "free_passable", s.free_passable, 0.99, false);
    judge_with_seen(out, "leak", s.leak, "leak_hit", s.leak_hit, 0.01, true);
    judge_with_seen(out, "reach", s.reach, "reach_seen", s.reach_seen, 0.98, false);
    judge(out, "inflation_cells", s.inflation_cells(), 1, true);
    judge(out, "mover_freed", s.mover_freed, 0.98, false);
    judge(out, "posts_kept", s.posts, 1.0, false, 1);
    judge_fills(out, e.fills);
  }
  return out;
}

}  // namespace talus::baselines
