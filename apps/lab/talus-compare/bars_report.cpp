#include "report.h"

namespace talus::baselines
{
namespace
{
std::string shares(const EstimateErrors& e)
{
  return e.count() == 0 ? "-" : percent(e.within(1)) + ", " + percent(e.within(2));
}

std::string deviations(const EstimateErrors& e)
{
  if (e.count() == 0) return "-";
  return number(1000 * e.median_estimated_m(), 1) + ", " + number(1000 * e.true_m(), 1);
}

nlohmann::json as_json(const EstimateErrors& e)
{
  return {
      {"n", e.count()},
      {"within_1", e.within(1)},
      {"within_2", e.within(2)},
      {"told_m", e.median_estimated_m()},
      {"true_m", e.true_m()}};
}
}  // namespace

Table bars_table(const Comparison& c)
{
  static const char* const kHeadings[kHeightKinds] = {"measured", "fill2", "fill1", "presumed"};
  Table t;
  t.heading = {"heights", "sensor"};
  for (const char* kind : kHeadings)
  {
    t.heading.push_back(std::string(kind) + " 1, 2");
    t.heading.emplace_back("estimated, true mm");
  }
  const auto add = [&t](const std::string& name, const std::string& sensor, const HeightBars& bars)
  {
    if (bars.empty()) return;
    auto& row = t.rows.emplace_back(std::vector<std::string>{name, sensor});
    for (int kind = 0; kind < kHeightKinds; ++kind)
    {
      row.push_back(shares(bars.all(kind)));
      row.push_back(deviations(bars.all(kind)));
    }
  };
  for (const Evaluation& e : c.evaluations)
    for (const Score& s : e.maps) add(e.name, e.sensor, s.bars);
  for (const HoldOut& h : c.holdouts) add(h.name + " (held out)", h.sensor, h.bars);
  return t.without_empty_columns();
}

Table risk_table(const Comparison& c)
{
  constexpr double kMinCount = 50;
  Table t;
  t.heading = {"estimated risk, %"};
  for (int i = 0; i < kTenths; ++i)
    t.heading.push_back(std::to_string(10 * i) + "-" + std::to_string(10 * i + 10));
  Score all;
  const auto add = [&t](const std::string& name, const Score& s)
  {
    auto& row = t.rows.emplace_back(std::vector<std::string>{name});
    for (const Share& tenth : s.risky)
      row.push_back(tenth.of < kMinCount ? "-" : percent(tenth.value()));
  };
  for (const Evaluation& e : c.evaluations)
    for (const Score& s : e.maps)
    {
      if (risk_json(s).empty()) continue;
      add(e.name, s);
      for (std::size_t i = 0; i < kTenths; ++i) all.risky[i].add(s.risky[i]);
    }
  if (t.rows.size() > 1) add("all worlds", all);
  return t;
}

nlohmann::json risk_json(const Score& s)
{
  nlohmann::json tenths = nlohmann::json::array();
  double cells = 0;
  for (const Share& tenth : s.risky)
  {
    cells += tenth.of;
    tenths.push_back({{"n", tenth.of}, {"impassable", tenth.part}});
  }
  return cells > 0 ? tenths : nlohmann::json::array();
}

nlohmann::json bars_json(const HeightBars& bars)
{
  nlohmann::json j;
  for (int kind = 0; kind < kHeightKinds; ++kind)
    j[kHeightKindNames[kind]] = {
        {"near", as_json(bars.near(kind))},
        {"far", as_json(bars.far(kind))},
        {"all", as_json(bars.all(kind))}};
  return j;
}

}  // namespace talus::baselines
