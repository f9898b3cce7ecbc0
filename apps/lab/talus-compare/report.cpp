#include "report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

namespace talus::baselines
{
namespace
{
/** One column of the tables that people read. */
template <typename S>
struct Column
{
  const char* heading;
  std::function<std::string(const S&)> text;
};

template <typename S>
Table table_of(const std::vector<Column<S>>& columns, const std::vector<S>& scores)
{
  Table t;
  for (const auto& c : columns) t.heading.emplace_back(c.heading);
  for (const S& s : scores)
  {
    t.rows.emplace_back();
    for (const auto& c : columns) t.rows.back().push_back(c.text(s));
  }
  return t.without_empty_columns();
}

std::string millimetres(double error_m) { return number(1000 * error_m, 1); }
std::string millimetres(const Errors& e) { return millimetres(e.rmse_m()); }

Table map_table(const std::vector<Score>& maps)
{
  static const std::vector<Column<Score>> columns{
      {"method", [](const Score& s) { return s.method; }},
      {"ms", [](const Score& s) { return number(figures(s)[0].second, 2); }},
      {"p99", [](const Score& s) { return number(figures(s)[1].second, 2); }},
      {"read ms", [](const Score& s) { return number(figures(s)[2].second, 1); }},
      {"MB", [](const Score& s) { return number(s.memory_mb, 1); }},
      {"known %", [](const Score& s) { return percent(1 - s.unknown.value()); }},
      {"ground mm", [](const Score& s) { return millimetres(s.all_measured_ground()); }},
      {"top mm", [](const Score& s) { return millimetres(s.measured_elevation); }},
      {"fill2 mm", [](const Score& s) { return millimetres(s.two_sided_seen); }},
      {"fill1 mm", [](const Score& s) { return millimetres(s.one_sided); }},
      {"hang wrong", [](const Score& s) { return percent(s.hanging_wrong.value()); }},
      {"hang pass", [](const Score& s) { return percent(s.hanging_passable.value()); }},
      {"obst", [](const Score& s) { return percent(s.obstacle_blocked.value()); }},
      {"free", [](const Score& s) { return percent(s.free_passable.value()); }},
      {"leak", [](const Score& s) { return percent(s.leak.value()); }},
      {"reach", [](const Score& s) { return percent(s.reach.value()); }},
      {"infl", [](const Score& s) { return number(s.inflation_cells(), 0); }},
      {"mover", [](const Score& s) { return percent(s.mover_freed.value()); }},
      {"posts", [](const Score& s) { return percent(s.posts.value()); }},
      {"ditch", [](const Score& s) { return percent(s.ditch_found.value()); }}};
  return table_of(columns, maps);
}

Table fill_table(const std::vector<FillScore>& fills)
{
  using F = FillScore;
  static const std::vector<Column<F>> columns{
      {"fill", [](const F& f) { return f.fill; }},
      {"ms", [](const F& f) { return number(figures(f)[0].second, 1); }},
      {"coverage %", [](const F& f) { return percent(f.coverage.value()); }},
      {"RMSE mm", [](const F& f) { return millimetres(f.all); }},
      {"p95 mm", [](const F& f) { return millimetres(f.all.quantile_m(0.95)); }},
      {"median mm", [](const F& f) { return millimetres(f.all.quantile_m(0.5)); }},
      {"seen RMSE", [](const F& f) { return millimetres(f.seen); }},
      {"two-sided RMSE", [](const F& f) { return millimetres(f.two_sided); }},
      {"one-sided RMSE", [](const F& f) { return millimetres(f.one_sided); }},
      {"cells", [](const F& f) { return std::to_string(f.all.count()); }}};
  return table_of(columns, fills);
}

Figures real_figures(const RealLogScore& s)
{
  return {
      {"precision", s.precision.value()},
      {"recall", s.recall.value()},
      {"f1", s.f1()},
      {"obstacle_blocked", s.obstacle_blocked.value()},
      {"low_blocked", s.low_blocked.value()},
      {"ground_passable", s.ground_passable.value()},
      {"left_blocked", s.left_blocked.value()},
      {"swept_blocked", s.swept_blocked.value()},
      {"unjudged", s.unjudged.value()},
      {"two_sided_unjudged", s.two_sided_unjudged.value()}};
}

Table real_log_table(const std::vector<RealLogScore>& maps)
{
  Table t;
  t.heading = {"method", "precision", "recall", "F1",       "obst",          "low",
               "free",   "left",      "swept",  "unjudged", "fill2 unjudged"};
  for (const RealLogScore& s : maps)
  {
    auto& row = t.rows.emplace_back(std::vector<std::string>{s.method});
    for (const auto& [name, value] : real_figures(s)) row.push_back(percent(value));
  }
  return t.without_empty_columns();
}

std::string reach_text(const LabelScore& s)
{
  return std::isfinite(s.within_m) ? number(s.within_m, 0) + " m" : "window";
}
const char* past_text(const LabelScore& s) { return s.alone ? "alone" : "in a row"; }

Table label_table(const std::vector<LabelScore>& scores)
{
  Table t;
  t.heading = {"scans", "within", "number", "points", "precision", "recall", "F1"};
  for (const LabelScore& s : scores)
    t.rows.push_back(
        {past_text(s), reach_text(s), std::to_string(s.scans), std::to_string(s.points),
         number(100 * s.precision, 2), number(100 * s.recall, 2), number(100 * s.f1, 2)});
  return t;
}

/** The worlds with truth as one. No frames when there are fewer than two. */
Evaluation pooled(const std::vector<Evaluation>& evaluations)
{
  Evaluation all;
  int worlds = 0;
  for (const Evaluation& e : evaluations)
  {
    if (!e.has_truth) continue;
    ++worlds;
    all.frames += e.frames;
    all.maps.resize(e.maps.size());
    all.fills.resize(e.fills.size());
    for (std::size_t i = 0; i < e.maps.size(); ++i) all.maps[i].add(e.maps[i]);
    for (std::size_t i = 0; i < e.fills.size(); ++i) all.fills[i].add(e.fills[i]);
  }
  return worlds > 1 ? all : Evaluation();
}

std::string not_ground_words(const HoldOut& h)
{
  if (h.not_ground.of == 0) return {};
  return " (labelled as none: " + percent(h.not_ground.value()) + " %)";
}

using Render = std::string (Table::*)() const;

std::string tables(const Comparison& c, Render render, const std::string& title)
{
  std::string out;
  const auto add = [&](const std::string& heading, const Table& t)
  { out += title + heading + "\n\n" + (t.*render)() + "\n"; };
  const Evaluation all = pooled(c.evaluations);
  if (all.frames > 0)
  {
    add("all worlds: maps", map_table(all.maps));
    add("all worlds: fills, on the same cells", fill_table(all.fills));
  }
  for (const Evaluation& e : c.evaluations)
  {
    add(e.name + ": maps", map_table(e.maps));
    if (e.has_truth && !e.fills.empty())
      add(e.name + ": fills, on the same cells", fill_table(e.fills));
  }
  for (const HoldOut& h : c.holdouts)
    add(h.name + ": fills, held-out ground points" + not_ground_words(h), fill_table(h.fills));
  if (const Table bars = bars_table(c); !bars.rows.empty())
    add("heights within one and two estimated deviations, %", bars);
  if (const Table risks = risk_table(c); !risks.rows.empty())
    add("cells that are impassable, of those that the map lets pass, %", risks);
  for (const RealLog& log : c.real_logs)
    add(log.name + ": ground, obstacles and what is not judged, %", real_log_table(log.maps));
  for (const LabelledLog& log : c.labelled)
    add(log.name + ": points labelled as ground, %", label_table(log.scores));
  return out;
}

/** "Without rules 27, 30."; empty: all count. */
std::string left_out_words(const Comparison& c)
{
  std::string text;
  for (const int rule : c.without_rules) text += (text.empty() ? "" : ", ") + std::to_string(rule);
  if (text.empty()) return {};
  return (c.without_rules.size() > 1 ? "Without rules " : "Without rule ") + text + ".";
}

/** NaN becomes null. */
nlohmann::json as_json(const Figures& values)
{
  nlohmann::json j;
  for (const auto& [name, value] : values) j[name] = value;
  return j;
}

nlohmann::json as_json(const std::string& log, const LabelScore& s)
{
  return {{"precision", s.precision},
          {"recall", s.recall},
          {"f1", s.f1},
          {"name", log},
          {"alone", s.alone},
          {"within", reach_text(s)},
          {"scans", s.scans},
          {"points", s.points}};
}

nlohmann::json as_json(const BudgetResult& r, ExpectedFailures::Verdict expected)
{
  const char* verdicts[] = {"pass", "fail", "not applicable"};
  const char* expectations[] = {"holds", "as expected", "new", "worse", "no longer fails"};
  return {
      {"name", r.name},
      {"value", r.value},
      {"limit", r.limit},
      {"at_most", r.at_most},
      {"verdict", verdicts[static_cast<int>(r.verdict)]},
      {"expectation", expectations[static_cast<int>(expected)]}};
}

}  // namespace

std::string tables_text(const Comparison& c)
{
  const std::string left_out = left_out_words(c);
  return (left_out.empty() ? "" : left_out + "\n\n") + tables(c, &Table::text, "");
}

std::string tables_markdown(const Comparison& c)
{
  const std::string left_out = left_out_words(c);
  std::string out = "Made by `" + c.command + "`." + (left_out.empty() ? "" : " " + left_out);
  const std::string budgets = budget_markdown(c);
  out += budgets.empty() ? "\n\n" : " " + budgets;
  return out + tables(c, &Table::markdown, "## ");
}

std::string comparison_json(const Comparison& c)
{
  nlohmann::json worlds = nlohmann::json::array(), holdouts = worlds, real_logs = worlds,
                 labels = worlds;
  for (const Evaluation& e : c.evaluations)
  {
    nlohmann::json w{
        {"name", e.name}, {"sensor", e.sensor}, {"frames", e.frames}, {"truth", e.has_truth}};
    for (const Score& s : e.maps)
    {
      w["methods"][s.method] = as_json(figures(s));
      if (!s.bars.empty()) w["heights"] = bars_json(s.bars);
      if (const auto risk = risk_json(s); !risk.empty()) w["risk"] = risk;
    }
    for (const FillScore& f : e.fills) w["fills"][f.fill] = as_json(figures(f));
    if (e.has_truth)
      for (const BudgetResult& r : check_budgets(e))
        w["budgets"].push_back(as_json(r, c.expected.judge(e.name, r)));
    worlds.push_back(w);
  }
  for (const HoldOut& h : c.holdouts)
  {
    nlohmann::json j{{"name", h.name}, {"sensor", h.sensor}, {"frames", h.frames}};
    if (!h.bars.empty()) j["heights"] = bars_json(h.bars);
    j["not_ground"] = h.not_ground.value();
    for (const FillScore& f : h.fills) j["fills"][f.fill] = as_json(figures(f));
    holdouts.push_back(j);
  }
  for (const RealLog& log : c.real_logs)
  {
    nlohmann::json j{{"name", log.name}};
    for (const RealLogScore& s : log.maps) j["methods"][s.method] = as_json(real_figures(s));
    real_logs.push_back(j);
  }
  for (const LabelledLog& log : c.labelled)
    for (const LabelScore& score : log.scores) labels.push_back(as_json(log.name, score));
  const nlohmann::json all{{"command", c.command},   {"without_rules", c.without_rules},
                           {"worlds", worlds},       {"held_out", holdouts},
                           {"real_logs", real_logs}, {"labels", labels}};
  // a file name may be no UTF-8
  return all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace talus::baselines
