#include <talus/io/summary_json.h>

#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

namespace talus::io
{
namespace
{
std::string header()
{
  std::string line = "stamp_s,points_in,points_accepted";
  for (const char* reason : kRejectNames) line += std::string(",rejected_") + reason;
  for (const char* stage : kStageNames) line += std::string(",") + stage + "_ms";
  return line + ",total_ms\n";
}

std::string row_of(const FrameReport& f)
{
  std::string row = fixed_text(f.stamp_s, 6);
  row += "," + std::to_string(f.points_in) + "," + std::to_string(f.points_accepted);
  for (const auto count : f.rejected) row += "," + std::to_string(count);
  for (const double ms : f.stage_ms) row += "," + fixed_text(ms, 4);
  return row + "," + fixed_text(f.total_ms, 4) + "\n";
}
}  // namespace

std::string timing_csv(const std::vector<FrameReport>& frames)
{
  std::string text = header();
  for (const auto& f : frames) text += row_of(f);
  return text;
}

void write_timing_csv(const std::string& path, const std::vector<FrameReport>& frames)
{
  write_file(path, timing_csv(frames));
}

}  // namespace talus::io
