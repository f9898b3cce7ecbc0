#include <talus/number_text.h>

#include <algorithm>
#include <cmath>

#include "report.h"

namespace talus::baselines
{
namespace
{
bool fails(const BudgetResult& r) { return r.verdict == BudgetResult::Verdict::Fail; }

bool is_unexpected(ExpectedFailures::Verdict v)
{
  return v == ExpectedFailures::Verdict::New || v == ExpectedFailures::Verdict::Worse;
}

bool is_rmse(const BudgetResult& r) { return r.name.find("rmse_m") != std::string::npos; }

std::string budget_value(const BudgetResult& r)
{
  return number(r.value, is_rmse(r) ? 4 : r.name == "inflation_cells" ? 0 : 3);
}
std::string budget_limit(const BudgetResult& r)
{
  return (r.at_most ? "<= " : ">= ") + number(r.limit, is_rmse(r) ? 3 : 2);
}

/** Of a value in a table. */
const char* mark(ExpectedFailures::Verdict v)
{
  return is_unexpected(v) ? "!" : v == ExpectedFailures::Verdict::Expected ? "*" : "";
}

/** One budget in all worlds. */
struct BudgetRow
{
  std::vector<std::pair<BudgetResult, std::string>> judged;  //!< and in which world
  int fail = 0, unexpected = 0, not_seen = 0;

  void add(
      const BudgetResult& r, const std::string& world, const std::vector<BudgetResult>& all,
      const ExpectedFailures& expected)
  {
    if (r.verdict == BudgetResult::Verdict::NotApplicable) return;
    judged.emplace_back(r, world);
    if (!fails(r)) return;
    fail++;
    unexpected += is_unexpected(expected.judge(world, r));
    for (const BudgetResult& other : all)
      not_seen += other.name == r.as_seen && other.verdict != BudgetResult::Verdict::Fail;
  }
  /** Best first. */
  void sort()
  {
    std::sort(
        judged.begin(), judged.end(),
        [](const auto& a, const auto& b) {
          return a.first.at_most ? a.first.value < b.first.value : a.first.value > b.first.value;
        });
  }
  std::vector<std::string> text() const
  {
    const auto& [worst, world] = judged.back();
    return {
        worst.name,
        budget_limit(worst),
        std::to_string(judged.size()),
        std::to_string(fail),
        std::to_string(unexpected),
        worst.as_seen.empty() ? "-" : std::to_string(not_seen),
        budget_value(judged[judged.size() / 2].first),
        budget_value(worst) + " (" + world + ")"};
  }
};

using Worlds = std::vector<const Evaluation*>;

/** Budgets in rows, over all worlds. */
Table budget_overview(const Worlds& worlds, const ExpectedFailures& expected)
{
  std::vector<BudgetRow> rows;
  for (const Evaluation* e : worlds)
  {
    const auto results = check_budgets(*e);
    rows.resize(std::max(rows.size(), results.size()));
    for (std::size_t i = 0; i < results.size(); ++i)
      rows[i].add(results[i], e->name, results, expected);
  }
  Table t;
  t.heading = {"all worlds",   "limit",    "judged", "fail",
               "new or worse", "not seen", "median", "worst"};
  for (BudgetRow& row : rows)
  {
    if (row.judged.empty()) continue;
    row.sort();
    t.rows.push_back(row.text());
  }
  return t.without_empty_columns();
}

constexpr std::size_t kWorldsPerTable = 8;

/** Budgets in rows, worlds first .. first + kWorldsPerTable in columns. */
Table budget_table(const Worlds& worlds, const ExpectedFailures& expected)
{
  Table t;
  t.heading = {"budget", "limit"};
  for (const Evaluation* e : worlds)
  {
    t.heading.push_back(e->name);
    const auto results = check_budgets(*e);
    t.rows.resize(results.size());
    for (std::size_t i = 0; i < results.size(); ++i)
    {
      const BudgetResult& r = results[i];
      if (t.rows[i].empty()) t.rows[i] = {r.name, budget_limit(r)};
      t.rows[i].push_back(budget_value(r) + mark(expected.judge(e->name, r)));
    }
  }
  return t;
}

Worlds judged_worlds(const Comparison& c)
{
  Worlds worlds;
  for (const Evaluation& e : c.evaluations)
    if (e.has_truth && !check_budgets(e).empty()) worlds.push_back(&e);
  return worlds;
}

std::vector<Table> budget_tables(const Comparison& c)
{
  const Worlds worlds = judged_worlds(c);
  std::vector<Table> tables;
  if (worlds.size() > 1) tables.push_back(budget_overview(worlds, c.expected));
  for (std::size_t first = 0; first < worlds.size(); first += kWorldsPerTable)
  {
    const auto from = worlds.begin() + static_cast<std::ptrdiff_t>(first);
    const auto count = std::min(kWorldsPerTable, worlds.size() - first);
    tables.push_back(budget_table({from, from + static_cast<std::ptrdiff_t>(count)}, c.expected));
  }
  return tables;
}

struct Judged
{
  const Evaluation* world;
  BudgetResult result;
  ExpectedFailures::Verdict verdict;
};
std::vector<Judged> judged_budgets(const Comparison& c)
{
  std::vector<Judged> judged;
  for (const Evaluation* e : judged_worlds(c))
    for (const BudgetResult& r : check_budgets(*e))
      judged.push_back({e, r, c.expected.judge(e->name, r)});
  return judged;
}

template <class Which>
int count_budgets(const Comparison& c, const Which& which)
{
  const auto judged = judged_budgets(c);
  return static_cast<int>(std::count_if(judged.begin(), judged.end(), which));
}

/** World, budget, value, and what is known of it. */
std::string surprise(const Evaluation& e, const BudgetResult& r, const ExpectedFailures& expected)
{
  const auto noted = expected.noted(e.name, r.name);
  return "- " + e.name + " " + r.name + ": " + budget_value(r) + ", limit " + budget_limit(r) +
         (noted ? ", noted " + number_text(noted->value, 4) : "") + "\n";
}
}  // namespace

std::string budget_text(const Comparison& c)
{
  std::string out;
  for (const Table& t : budget_tables(c)) out += t.text() + "\n";
  return out;
}

std::string budget_markdown(const Comparison& c)
{
  const std::string words = budget_words(c);
  std::string out = words.empty() ? "" : words + ".\n\n";
  out += surprises_text(c);
  for (const Table& t : budget_tables(c)) out += t.markdown() + "\n";
  return out;
}

std::string budget_words(const Comparison& c)
{
  if (judged_worlds(c).empty()) return {};
  const int failed = failed_budgets(c), unexpected = unexpected_failures(c);
  std::string all =
      std::to_string(failed) + (failed == 1 ? " budget does" : " budgets do") + " not hold";
  if (failed == 0) return all;
  if (unexpected == failed) return all + " (marked !)";
  return all + ": " + std::to_string(failed - unexpected) + " as expected (*), " +
         std::to_string(unexpected) + " new or clearly worse (!)";
}

std::string surprises_text(const Comparison& c)
{
  if (c.expected.empty()) return {};
  std::string wrong, right;
  for (const auto& [world, result, verdict] : judged_budgets(c))
  {
    if (is_unexpected(verdict)) wrong += surprise(*world, result, c.expected);
    if (verdict == ExpectedFailures::Verdict::NoLongerFails)
      right += surprise(*world, result, c.expected);
  }
  if (!wrong.empty()) wrong = "New or clearly worse:\n\n" + wrong + "\n";
  if (right.empty()) return wrong;
  return wrong + "No longer fails; take these out of the expected failures by --accept:\n\n" +
         right + "\n";
}

int failed_budgets(const Comparison& c)
{
  return count_budgets(c, [](const Judged& j) { return fails(j.result); });
}

int unexpected_failures(const Comparison& c)
{
  return count_budgets(c, [](const Judged& j) { return is_unexpected(j.verdict); });
}

}  // namespace talus::baselines
