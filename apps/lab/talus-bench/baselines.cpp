#include <talus/baselines/method.h>

#include "baselines.h"
#include "measure.h"

namespace talus::bench
{
namespace
{
constexpr int kWarm = 3, kTimed = 12;

/** Median seconds of a frame; `with_read`: until its surfaces and traversability are there. */
double time_method(const char* name, bool with_read, const Setting& s)
{
  const auto method = talus::baselines::make_method(name, parameters(s));
  std::vector<double> seconds;
  for (int i = 0; i < kWarm + kTimed; i++)
  {
    Frame frame = scan_at(s, i).frame();
    frame.stamp_s = 0.1 * i;
    const double before = process_cpu_s();
    method->update(frame);
    if (with_read) method->read();
    if (i >= kWarm) seconds.push_back(process_cpu_s() - before);
  }
  return quantile(seconds, 0.5);
}

}  // namespace

std::vector<Baseline> baselines()
{
  const auto timed = [](const char* method, bool with_read)
  { return [=](const Setting& s) { return time_method(method, with_read, s); }; };
  return {
      {"octomap_insert", timed("octomap", false)},
      {"octomap_insert_and_read", timed("octomap", true)},
      {"heightgrid_insert", timed("heightgrid", false)},
      {"heightgrid_insert_and_judge", timed("heightgrid", true)},
      {"kalman_insert_and_judge", timed("highest", true)}};
}

}  // namespace talus::bench
