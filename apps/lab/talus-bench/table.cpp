#include "table.h"

#include <talus/elevation_mapper.h>

#include <cstdio>
#include <string>

namespace talus::bench
{
namespace
{
using Counters = benchmark::UserCounters;

void cell(const Counters& counters, const std::string& name, int width, int decimals)
{
  const auto at = counters.find(name);
  if (at == counters.end())
    std::printf(" %*s", width, "");
  else
    std::printf(" %*.*f", width, decimals, static_cast<double>(at->second));
}

/** "frame/cpu/S1/iterations:250/manual_time" without its end. */
std::string short_name(const std::string& name) { return name.substr(0, name.find("/iterations")); }
}  // namespace

bool Table::ReportContext(const Context&)
{
  std::printf(
      "Microseconds a frame; median and p99 by the clock, CPU: median of the processor time.\n"
      "reference: transform and bin the same points, and pass once over the window for each "
      "layer,\n"
      "timed in the same run (on a device: launch and copy). x ref: the frame over it, one thread "
      "by\n"
      "CPU, else by the clock. ns: the same for each point and cell; x S1: that against S1. Then "
      "the\n"
      "mean time of each stage; stages that run fused count for the first.\n\n"
      "%-42s %9s %9s %9s %9s %6s %6s %5s",
      "", "median", "p99", "CPU", "reference", "x ref", "ns", "x S1");
  for (const char* stage : kStageNames) std::printf(" %8.8s", stage);
  std::printf("\n");
  return true;
}

void Table::ReportRuns(const std::vector<Run>& runs)
{
  for (const Run& run : runs)
  {
    std::printf("%-42s", short_name(run.benchmark_name()).c_str());
    if (run.error_occurred)
    {
      std::printf(" %s\n", run.error_message.c_str());
      continue;
    }
    const Counters& c = run.counters;
    cell(c, "median_us", 9, 0);
    cell(c, "p99_us", 9, 0);
    cell(c, "cpu_us", 9, 0);
    cell(c, "reference_us", 9, 1);
    cell(c, "x_reference", 6, 1);
    cell(c, "ns_per_point_and_cell", 6, 1);
    cell(c, "x_S1", 5, 2);
    for (std::size_t i = 0; i < kStageNames.size(); i++)
      cell(c, std::to_string(i + 1) + "_" + kStageNames[i] + "_us", 8, 0);
    if (c.count("speedup"))
      std::printf("  %.2f x one thread", static_cast<double>(c.at("speedup")));
    if (c.count("x_talus")) std::printf("  %.1f x talus", static_cast<double>(c.at("x_talus")));
    if (!run.report_label.empty()) std::printf("  %s", run.report_label.c_str());
    std::printf("\n");
    std::fflush(stdout);
  }
}

}  // namespace talus::bench
