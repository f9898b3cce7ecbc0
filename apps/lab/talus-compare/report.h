#pragma once
#include <nlohmann/json.hpp>
#include <talus/baselines/evaluate.h>
#include <talus/baselines/budgets.h>
#include <talus/baselines/real_log.h>

#include <string>
#include <vector>

namespace talus::baselines
{
/** A log without the truth of a world. */
struct RealLog
{
  std::string name;
  std::vector<RealLogScore> maps;
};

/** The labels of the points of a log. */
struct LabelledLog
{
  std::string name;
  std::vector<LabelScore> scores;
};

/** All that one call compared. */
struct Comparison
{
  std::vector<Evaluation> evaluations;
  std::vector<HoldOut> holdouts;  //!< of logs without truth
  std::vector<RealLog> real_logs;
  std::vector<LabelledLog> labelled;
  std::string command;  //!< that made it
  ExpectedFailures expected;  //!< of worlds
  std::vector<int> without_rules;  //!< of talus, by their numbers
};

/** For a terminal: for each world or log one row a method, one row a fill; before them the rules
 * that were left out. */
std::string tables_text(const Comparison& c);
/** Rows are budgets, columns are worlds; "!" marks what fails and was not expected or is clearly
 * worse, "*" what fails as expected, "-" what does not apply. Before them, of several worlds, how
 * many fail; "not seen": of these, where what a ray could show holds. */
std::string budget_text(const Comparison& c);
/** How many budgets fail. */
int failed_budgets(const Comparison& c);
/** How many fail that were not expected to, or are clearly worse than was noted. */
int unexpected_failures(const Comparison& c);
/** Both in words; empty where none was judged. */
std::string budget_words(const Comparison& c);
/** Which are not as was noted, for better or worse; empty where nothing was noted. */
std::string surprises_text(const Comparison& c);
/** All of that as a part of a page of Markdown. */
std::string budget_markdown(const Comparison& c);

/** The same as a page of Markdown. */
std::string tables_markdown(const Comparison& c);

/** All figures. */
std::string comparison_json(const Comparison& c);

/** Rows are worlds, columns are the truth and the traversability of each method, as in figure 8 of
 * the paper. Whole or not at all. Throws std::runtime_error. */
void write_maps_picture(const std::string& path, const std::vector<Evaluation>& evaluations);

/** Rows of text under a heading; the first column is left-aligned, the others right-aligned. */
struct Table
{
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;

  /** The same without columns in which no row has a figure; the first column stays. */
  Table without_empty_columns() const;
  std::string text() const;  //!< for a terminal
  std::string markdown() const;
};

/** A number with so many decimals, "-" for NaN. */
std::string number(double value, int decimals);
/** A share as a percentage with one decimal, "-" for NaN. */
std::string percent(double share);

/** Rows are the worlds and logs; for each kind of height the shares within one and two estimated
 * deviations [%] and the medians of estimated and true deviation [mm]. */
Table bars_table(const Comparison& c);

/** Rows are the worlds with truth, then all of them as one: of the passable cells in each tenth of
 * the estimated risk those that are impassable [%]. */
Table risk_table(const Comparison& c);

/** By tenth of the estimated risk: how many passable cells, and the share of them that is
 * impassable. Empty where no risk was estimated. */
nlohmann::json risk_json(const Score& s);

/** The figures of one world or log, near, far and both. */
nlohmann::json bars_json(const HeightBars& bars);

}  // namespace talus::baselines
