#include <talus/baselines/budgets.h>
#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

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
  judge(out, name, static_cast<double>(e.count()) >= kMinCount ? e.rmse_m() : NAN, limit_m, true);
}

void judge(
    Results& out, const std::string& name, const Share& s, double limit, bool at_most,
    double min_count = kMinCount)
{
  judge(out, name, s.of >= min_count ? s.value() : NAN, limit, at_most);
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
        out, "fill_beats_" + fills[f].fill, enough ? error_m(own) / error_m(other) : NAN, 1.0,
        true);
  }
}

constexpr std::uint64_t kMaxBytes = 1 << 24;
constexpr double kSlackOfShare = 0.01;
constexpr double kSlackOfError = 0.1;  //!< relative to the value that was noted

constexpr const char* kHead =
    "# What does not hold in the worlds, the value that it had, and why. Written by\n"
    "# `talus-compare WORLDS --methods talus --accept FILE`; reasons may be made more exact by "
    "hand.\n"
    "# world\tbudget\tvalue\treason\n";

bool begins_with(const std::string& text, const char* with) { return text.rfind(with, 0) == 0; }

/** Of the names that begin so; the first that fits. */
struct Reason
{
  const char *begin, *why;
};
constexpr Reason kReasons[]{
    {"measured_ground_near_step", "cells at an edge hold points of both levels"},
    {"measured_ground", "points count where they are in their cell, and noise stays"},
    {"two_sided", "between two lines nobody saw where the ground turns"},
    {"hanging", "what hangs shares cells with what stands, or its floor was not seen"},
    {"obstacle_blocked_whole", "tops without a face before them, and bodies that look like ground"},
    {"obstacle_blocked", "cells are covered in part, and tops have no face before them"},
    {"free_passable", "free cells beside obstacles and drops count as these"},
    {"leak_hit", "level tops wider than an object are ground"},
    {"leak", "insides that nobody saw are filled from their sides"},
    {"reach", "ground that nobody saw, or that lies behind it, is not reached"},
    {"inflation", "cells beside what stands hold points of it"},
    {"mover", "rays at that height still end on the rest of the mover"},
    {"posts", "rays pass thin things in most frames"},
    {"fill_beats", "behind an edge a square of neighbours reaches cells that lines do not"}};

std::string usual_reason(const std::string& budget)
{
  for (const Reason& r : kReasons)
    if (begins_with(budget, r.begin)) return r.why;
  return "not promised";
}

/** By how much a budget may get worse and still be as expected. */
double slack(const std::string& budget, double noted)
{
  if (budget == "inflation_cells") return 0;
  const bool is_error = budget.find("rmse_m") != std::string::npos;
  return is_error || begins_with(budget, "fill_beats") ? kSlackOfError * noted : kSlackOfShare;
}

[[noreturn]] void refuse(const std::string& path, int line, const std::string& why)
{
  throw std::runtime_error(
      path + ":" + std::to_string(line) + ": " + why +
      "; a line is world, budget, value and reason with tabs between them. Write the file anew by "
      "talus-compare --accept");
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

ExpectedFailures ExpectedFailures::read(const std::string& path)
{
  ExpectedFailures out;
  std::istringstream lines(read_input_file(path, "file of expected failures", kMaxBytes));
  int number = 0;
  for (std::string line; std::getline(lines, line);)
  {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string world, budget, value, reason;
    std::getline(words, world, '\t');
    std::getline(words, budget, '\t');
    std::getline(words, value, '\t');
    std::getline(words, reason);
    const auto parsed = number_from(value);
    if (!parsed) refuse(path, number, "'" + value + "' is no value");
    if (reason.empty()) refuse(path, number, "there is no reason");
    if (!out.rows_.insert({{world, budget}, {*parsed, reason}}).second)
      refuse(path, number, "'" + budget + "' of '" + world + "' is there twice");
  }
  return out;
}

std::string ExpectedFailures::text() const
{
  std::string out = kHead;
  for (const auto& [key, row] : rows_)
    out +=
        key.first + "\t" + key.second + "\t" + number_text(row.value, 4) + "\t" + row.reason + "\n";
  return out;
}

ExpectedFailures::Verdict ExpectedFailures::judge(
    const std::string& world, const BudgetResult& result) const
{
  const auto row = noted(world, result.name);
  if (result.verdict != BudgetResult::Verdict::Fail)
    return row ? Verdict::NoLongerFails : Verdict::Holds;
  if (!row) return Verdict::New;
  const double worse_by = result.at_most ? result.value - row->value : row->value - result.value;
  return worse_by > slack(result.name, row->value) ? Verdict::Worse : Verdict::Expected;
}

std::optional<ExpectedFailures::Row> ExpectedFailures::noted(
    const std::string& world, const std::string& budget) const
{
  const auto found = rows_.find({world, budget});
  return found == rows_.end() ? std::nullopt : std::optional<Row>(found->second);
}

void ExpectedFailures::accept(const std::string& world, const std::vector<BudgetResult>& results)
{
  if (world.empty() || world[0] == '#' || world.find_first_of("\t\r\n") != std::string::npos)
    throw std::runtime_error(
        "world '" + world +
        "': a line of expected failures cannot hold this name: give it another");
  for (const BudgetResult& r : results)
  {
    const auto known = noted(world, r.name);
    rows_.erase({world, r.name});
    if (r.verdict == BudgetResult::Verdict::Fail)
      rows_[{world, r.name}] = {r.value, known ? known->reason : usual_reason(r.name)};
  }
}

void ExpectedFailures::add(const ExpectedFailures& other)
{
  for (const auto& [key, row] : other.rows_) rows_[key] = row;
}

}  // namespace talus::baselines
