#pragma once
#include <benchmark/benchmark.h>

namespace talus::bench
{
/** Prints a line a setting for people: what it took, and how many times the reference. The same
 * numbers, and more, are in the JSON file of --benchmark_out. */
class Table : public benchmark::BenchmarkReporter
{
 public:
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& runs) override;
};

}  // namespace talus::bench
