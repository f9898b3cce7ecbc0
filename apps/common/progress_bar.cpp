#include "progress_bar.h"

#include "printable.h"

#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>

namespace talus::app
{
namespace
{
constexpr auto kMinInterval = std::chrono::milliseconds(100);

char* receiver = nullptr;  //!< of the lines of this process; none: its terminal

struct Room
{
  std::size_t columns = 80, rows = 24;
};
/** Of the terminal. */
Room terminal_room()
{
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0)
    return {};
  return {size.ws_col, size.ws_row};
}

std::string cut(const std::string& line, std::size_t columns)
{
  return line.substr(0, std::max<std::size_t>(columns, 2) - 1);
}
}  // namespace

std::string TimeLeft::text(double fraction, double now_s)
{
  constexpr double kMinWatched_s = 3, kMinDone = 0.01;
  if (fraction < last_)
  {
    first_ = fraction;
    begin_s_ = now_s;
  }
  last_ = fraction;
  const double watched_s = now_s - begin_s_, done = fraction - first_;
  if (watched_s < kMinWatched_s || done < kMinDone) return "";
  const auto left_s = std::lround(watched_s * (1 - fraction) / done);
  if (left_s < 100) return std::to_string(left_s) + " s left";
  if (left_s < 6000) return std::to_string((left_s + 30) / 60) + " min left";
  return std::to_string((left_s + 1800) / 3600) + " h left";
}

ProgressBar::ProgressBar(const std::string& label, bool wanted)
    : label_(printable(label)), on_(wanted && (receiver || ::isatty(STDERR_FILENO)))
{
}

ProgressBar::~ProgressBar()
{
  if (on_ && !receiver) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(double fraction, const std::string& words)
{
  const auto now = std::chrono::steady_clock::now();
  if (!on_ || now - last_ < kMinInterval) return;
  last_ = now;
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(std::lround(fraction * kWidth));
  const double now_s = std::chrono::duration<double>(now.time_since_epoch()).count();
  const std::string left = left_.text(fraction, now_s);
  std::string line = label_ + " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') +
                     "] " + std::to_string(static_cast<int>(100 * fraction)) + " %  " +
                     printable(words) + (left.empty() ? "" : ", " + left);
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (receiver)
    std::snprintf(receiver, SharedLines::kSize, "%s", line.c_str());
  else
    std::fprintf(stderr, "\r%s\033[K", cut(line, terminal_room().columns).c_str());
  std::fflush(stderr);
}

void ProgressBar::send_to(char* line) { receiver = line; }

SharedLines::SharedLines(std::size_t count) : count_(count)
{
  void* const lines =
      ::mmap(nullptr, count * kSize, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (lines == MAP_FAILED) throw std::bad_alloc();
  begin_ = static_cast<char*>(lines);
}

SharedLines::~SharedLines() { ::munmap(begin_, count_ * kSize); }

std::vector<std::string> SharedLines::shown() const
{
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < count_; ++i)
    if (const char* line = begin_ + i * kSize; *line) lines.emplace_back(line);
  return lines;
}

ProgressLines::ProgressLines(bool wanted) : on_(wanted && ::isatty(STDERR_FILENO)) {}

void ProgressLines::show(const std::vector<std::string>& lines)
{
  const auto now = std::chrono::steady_clock::now();
  if (!on_ || now - last_ < kMinInterval) return;
  last_ = now;
  remove();
  const Room room = terminal_room();
  for (const std::string& line : lines)
    if (drawn_ + 1 < room.rows)
    {
      std::fprintf(stderr, "%s\n", cut(line, room.columns).c_str());
      ++drawn_;
    }
  std::fflush(stderr);
}

void ProgressLines::remove()
{
  if (drawn_ > 0) std::fprintf(stderr, "\r\033[%zuA\033[J", drawn_);
  std::fflush(stderr);
  drawn_ = 0;
}

}  // namespace talus::app
