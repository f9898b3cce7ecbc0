#include <talus/io/timing_csv.h>

#include <talus/io/atomic_file.h>

#include <cstdio>

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

void append_ms(std::string& row, double ms)
{
  char text[32];
  std::snprintf(text, sizeof text, ",%.4f", ms);
  row += text;
}

std::string row_of(const FrameReport& f)
{
  char stamp[40];
  std::snprintf(stamp, sizeof stamp, "%.6f", f.stamp_s);
  std::string row = stamp;
  row += "," + std::to_string(f.points_in) + "," + std::to_string(f.points_accepted);
  for (const auto count : f.rejected) row += "," + std::to_string(count);
  for (const double ms : f.stage_ms) append_ms(row, ms);
  append_ms(row, f.total_ms);
  return row + "\n";
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
