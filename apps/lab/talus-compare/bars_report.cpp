#include "report.h"

#include <cmath>
#include <map>

namespace talus::baselines
{
namespace
{
/** The mean of a figure over those that have it; NaN: none has. */
template <class Figure>
double mean_of(const BarsOf& bars, int kind, const Figure& figure)
{
  double sum = 0;
  int count = 0;
  for (const HeightBars* one : bars.each)
    if (const double value = figure(one->all(kind)); !std::isnan(value)) sum += value, ++count;
  return count > 0 ? sum / count : NAN;
}

std::string shares(const BarsOf& bars, int kind)
{
  const auto share = [&](double deviations)
  { return mean_of(bars, kind, [&](const EstimateErrors& e) { return e.within(deviations); }); };
  const double one = share(1), two = share(2);
  return std::isnan(one) ? "-" : percent(one) + ", " + percent(two);
}

std::string deviations(const BarsOf& bars, int kind)
{
  const double told =
      mean_of(bars, kind, [](const EstimateErrors& e) { return e.median_estimated_m(); });
  const double is = mean_of(bars, kind, [](const EstimateErrors& e) { return e.true_m(); });
  return std::isnan(told) ? "-" : number(1000 * told, 1) + ", " + number(1000 * is, 1);
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

std::vector<BarsOf> bars_of(const Comparison& c)
{
  std::vector<BarsOf> out;
  BarsOf all{"all worlds", "", {}};
  std::map<std::string, BarsOf> by_sensor;
  for (const Evaluation& e : c.evaluations)
    for (const Score& s : e.maps)
    {
      if (s.bars.empty()) continue;
      out.push_back({e.name, e.sensor, {&s.bars}});
      all.each.push_back(&s.bars);
      BarsOf& of_sensor = by_sensor[e.sensor];
      of_sensor.name = "all worlds", of_sensor.sensor = e.sensor;
      of_sensor.each.push_back(&s.bars);
    }
  for (const HoldOut& h : c.holdouts)
    if (!h.bars.empty()) out.push_back({h.name + " (held out)", h.sensor, {&h.bars}});
  if (all.each.size() < 2) return out;
  out.push_back(all);
  if (by_sensor.size() > 1)
    for (const auto& sensor : by_sensor) out.push_back(sensor.second);
  return out;
}

Table bars_table(const Comparison& c)
{
  static const char* const kHeadings[kHeightKinds] = {"measured", "fill2", "fill1", "presumed"};
  Table t;
  t.heading = {"heights", "sensor"};
  for (const char* kind : kHeadings)
  {
    t.heading.push_back(std::string(kind) + " 1, 2");
    t.heading.emplace_back("told, true mm");
  }
  for (const BarsOf& bars : bars_of(c))
  {
    auto& row = t.rows.emplace_back(std::vector<std::string>{bars.name, bars.sensor});
    for (int kind = 0; kind < kHeightKinds; ++kind)
    {
      row.push_back(shares(bars, kind));
      row.push_back(deviations(bars, kind));
    }
  }
  return t.without_empty_columns();
}

Table risk_table(const Comparison& c)
{
  constexpr double kMinCount = 50;
  Table t;
  t.heading = {"risk told, %"};
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
