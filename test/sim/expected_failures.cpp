// Which failures of budgets are as they were noted, and what the file says of them.
#include <gtest/gtest.h>
#include <talus/baselines/budgets.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

using namespace talus;
using namespace talus::baselines;

namespace
{
using Verdict = ExpectedFailures::Verdict;

BudgetResult failing(const std::string& name, double value, double limit, bool at_most)
{
  return {name, value, limit, at_most, BudgetResult::Verdict::Fail, ""};
}
BudgetResult share(double value) { return failing("reach", value, 0.98, false); }

/** A file for as long as it lives. */
struct File
{
  explicit File(const std::string& text) { std::ofstream(path) << text; }
  ~File() { std::filesystem::remove(path); }
  std::string path = (std::filesystem::temp_directory_path() /
                      ("talus_expected_" + std::to_string(::getpid()) + ".tsv"))
                         .string();
};

TEST(ExpectedFailures, AreClearlyWorseFromAHundredthOfAShareOrATenthOfAnErrorOn)
{
  ExpectedFailures e;
  const auto noted = [&](BudgetResult r, double now)
  {
    e.accept("hall", {r});
    r.value = now;
    return e.judge("hall", r);
  };
  EXPECT_EQ(noted(share(0.95), 0.941), Verdict::Expected);
  EXPECT_EQ(noted(share(0.95), 0.939), Verdict::Worse);
  EXPECT_EQ(noted(share(0.95), 0.97), Verdict::Expected) << "better";
  const BudgetResult leak = failing("leak", 0.03, 0.01, true);
  EXPECT_EQ(noted(leak, 0.039), Verdict::Expected);
  EXPECT_EQ(noted(leak, 0.041), Verdict::Worse);
  const BudgetResult error = failing("two_sided_seen_rmse_m", 0.05, 0.03, true);
  EXPECT_EQ(noted(error, 0.054), Verdict::Expected);
  EXPECT_EQ(noted(error, 0.056), Verdict::Worse);
  const BudgetResult ratio = failing("fill_beats_bgk", 1.2, 1, true);
  EXPECT_EQ(noted(ratio, 1.31), Verdict::Expected);
  EXPECT_EQ(noted(ratio, 1.33), Verdict::Worse);
  EXPECT_EQ(noted(failing("inflation_cells", 2, 1, true), 3), Verdict::Worse);
}

TEST(ExpectedFailures, AreOfOneWorldAndOneBudget)
{
  ExpectedFailures e;
  e.accept("hall", {share(0.9)});
  EXPECT_EQ(e.judge("park", share(0.9)), Verdict::New);
  EXPECT_EQ(e.judge("hall", failing("reach_seen", 0.9, 0.98, false)), Verdict::New);
  BudgetResult holds = share(0.99);
  for (const auto verdict : {BudgetResult::Verdict::Pass, BudgetResult::Verdict::NotApplicable})
  {
    holds.verdict = verdict;
    EXPECT_EQ(e.judge("hall", holds), Verdict::NoLongerFails);
    EXPECT_EQ(e.judge("park", holds), Verdict::Holds);
  }
}

TEST(ExpectedFailures, AreASortedFileThatReadsBackAsTheSame)
{
  ExpectedFailures e;
  e.accept("park", {share(0.91234)});
  e.accept("hall", {failing("leak", 0.03, 0.01, true), share(0.9)});
  const File file(e.text());
  const ExpectedFailures again = ExpectedFailures::read(file.path);
  EXPECT_EQ(again.text(), e.text());
  const auto at = [&](const char* row) { return e.text().find(row); };
  EXPECT_LT(at("hall\tleak\t0.03\tinsides"), at("hall\treach\t0.9\tground"));
  EXPECT_LT(at("hall\treach\t"), at("park\treach\t0.9123\t"));
  EXPECT_EQ(again.noted("park", "reach")->value, 0.9123);
  EXPECT_FALSE(again.noted("park", "leak"));
}

TEST(ExpectedFailures, AreRefusedWhereALineIsDamagedAndWhereNoLineCanHoldAName)
{
  for (const char* text :
       {"hall\treach\t0.9\n", "hall\treach\tx\twhy\n", "hall reach 0.9 why\n",
        "hall\treach\t0.9\twhy\nhall\treach\t0.8\twhy\n"})
  {
    const File file(text);
    EXPECT_THROW(ExpectedFailures::read(file.path), std::runtime_error) << text;
  }
  ExpectedFailures e;
  for (const char* name : {"", "a\tb", "a\nb", "#a"})
    EXPECT_THROW(e.accept(name, {share(0.9)}), std::runtime_error) << name;
}

}  // namespace
