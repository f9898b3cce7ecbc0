#include <talus/elevation_mapper.h>
#include "setting.h"

#include <valgrind/callgrind.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

// Instructions of each stage, counted by callgrind: the same in every run, where time is not. Built
// and run by instructions.sh.
//
// The clock of this program does not tell the time. Each look at it lets callgrind write what it
// counted since the last look into a file of its own, and moves it by the next power of two. So the
// milliseconds that a frame reports for a stage say, bit by bit, which files belong to the stage,
// and the code that is measured needs to know nothing of it.

namespace
{
bool counting = false;
int looks = 0;  //!< at the clock, while counting
std::int64_t now_ns = 0;
}  // namespace

std::chrono::steady_clock::time_point std::chrono::steady_clock::now() noexcept
{
  if (counting)
  {
    CALLGRIND_DUMP_STATS;
    if (looks > 0) now_ns += std::int64_t{1} << (looks - 1);
    looks++;
  }
  return time_point(duration(now_ns));
}

namespace
{
using namespace talus;
using namespace talus::bench;

/** The count that a file of callgrind's sums up to. */
double count_in(const std::string& path)
{
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.rfind("summary:", 0) == 0) return std::stod(line.substr(8));
  throw std::runtime_error(path + ": no such profile; run this program by instructions.sh");
}

const Setting& find_setting(const std::string& name)
{
  static const auto all = settings();
  for (const Setting& s : all)
    if (s.name == name) return s;
  throw std::runtime_error("no setting is called " + name);
}

/** Counts one frame after some that are not counted. */
FrameReport count_frame(const Setting& s)
{
  constexpr int kWarm = 8;
  ElevationMapper map(parameters(s), Backend::Cpu, 1);
  map.set_output_layers(s.layers);
  for (int i = 0; i < kWarm; i++) map.update(scan_at(s, i).frame());
  const Frame frame = scan_at(s, kWarm).frame();
  CALLGRIND_START_INSTRUMENTATION;
  counting = true;
  const FrameReport report = map.update(frame);
  counting = false;
  CALLGRIND_STOP_INSTRUMENTATION;
  return report;
}

/** The first look's file has what was before the frame: interval i is in file i + 2. */
double instructions(double stage_ms, const std::string& profile)
{
  const auto intervals = static_cast<std::int64_t>(std::llround(1e6 * stage_ms));
  double sum = 0;
  for (int i = 0; i < looks - 1; i++)
    if (intervals >> i & 1) sum += count_in(profile + "." + std::to_string(i + 2));
  return sum;
}
}  // namespace

int main(int argc, char** argv)
try
{
  if (argc != 3) throw std::runtime_error("usage: instructions SETTING PROFILE");
  const FrameReport report = count_frame(find_setting(argv[1]));
  double total = 0;
  std::printf("%s", argv[1]);
  for (std::size_t i = 0; i < kStageNames.size(); i++)
  {
    const double count = instructions(report.stage_ms[i], argv[2]);
    total += count;
    if (count > 0) std::printf("  %zu %s %.2f M", i + 1, kStageNames[i], 1e-6 * count);
  }
  std::printf("  sum %.2f M\n", 1e-6 * total);
}
catch (const std::exception& e)
{
  std::fprintf(stderr, "instructions: %s\n", e.what());
  return 1;
}
