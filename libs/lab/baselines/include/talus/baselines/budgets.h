#pragma once
#include <talus/baselines/evaluate.h>

namespace talus::baselines
{
/** A promise about one world, and what came out. */
struct BudgetResult
{
  std::string name;  //!< a figure of Score, or "fill_beats_NAME"
  double value = 0;  //!< NaN: nothing to judge
  double limit = 0;
  bool at_most = true;  //!< value <= limit, else value >= limit
  enum class Verdict
  {
    Pass,
    Fail,
    NotApplicable
  } verdict = Verdict::NotApplicable;
  std::string as_seen;  //!< the budget that asks the same of what a ray could show; or empty
};

/** What talus promises in a world with 15 mm of range noise and true poses. A budget applies when
 * there are enough cells to judge (20; one for posts). `fill_beats_NAME` is the RMSE of talus's
 * fill over that of the other one on the same cells, those whose ground a ray could have met, each
 * at least 1 mm, and must be at most 1. `..._hit`, `..._seen` and `obstacle_blocked_whole` leave
 * out what no ray could have shown. */
std::vector<BudgetResult> check_budgets(const Evaluation& evaluation);

}  // namespace talus::baselines
