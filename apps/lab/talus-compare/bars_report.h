#pragma once
#include <nlohmann/json.hpp>

#include "report.h"

namespace talus::baselines
{
/** How the heights of talus in one world or log, or in several, lie beside what the map estimates
 * for them. Shares of several are means over these. */
struct BarsOf
{
  std::string name, sensor;
  std::vector<const HeightBars*> each;
};

/** One a world, one a log, then all worlds and the worlds of each sensor, where there are several.
 * Empty where talus was not compared with a truth. */
std::vector<BarsOf> bars_of(const Comparison& c);

/** Rows are those of bars_of(), for each kind of height the shares within one and two estimated
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

/** Writes the reliability curves: over the share of heights that should lie within the estimated
 * deviations the share that does. Nothing where there is none. */
void write_bars_picture(const std::string& path, const Comparison& c);

}  // namespace talus::baselines
