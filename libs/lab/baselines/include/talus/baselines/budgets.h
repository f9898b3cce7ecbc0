#pragma once
#include <talus/baselines/evaluate.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/** Budgets that are known not to hold in some worlds, each with the value that it had and a reason.
 * In a file: one line each, world, budget, value and reason with tabs between them, sorted. Lines
 * that begin with # are comments. */
class ExpectedFailures
{
 public:
  struct Row
  {
    double value = 0;
    std::string reason;
  };
  enum class Verdict
  {
    Holds,  //!< or does not apply
    Expected,
    New,
    Worse,  //!< than noted: a share by more than 0.01, an error or ratio by more than a tenth
    NoLongerFails
  };

  /** Throws std::runtime_error that names the file, the line and the remedy. */
  static ExpectedFailures read(const std::string& path);
  /** The bytes of such a file. */
  std::string text() const;

  bool empty() const { return rows_.empty(); }
  Verdict judge(const std::string& world, const BudgetResult& result) const;
  /** What is known of a budget of a world. */
  std::optional<Row> noted(const std::string& world, const std::string& budget) const;

  /** From now on exactly those of these budgets are expected in a world that fail. A reason that is
   * known stays; a new row gets the usual one of its budget. Throws std::runtime_error for a name
   * that no line can hold. */
  void accept(const std::string& world, const std::vector<BudgetResult>& results);
  /** Adds the rows of another file; where both know a budget of a world, the other counts. */
  void add(const ExpectedFailures& other);

 private:
  std::map<std::pair<std::string, std::string>, Row> rows_;  //!< by world and budget
};

}  // namespace talus::baselines
