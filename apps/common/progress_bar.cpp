#include "progress_bar.h"

#include "printable.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace talus::app
{
namespace
{
double* receiver = nullptr;  //!< of the fractions of this process; none: its terminal

/** Of the terminal. */
std::size_t columns()
{
  winsize size{};
  const bool is_known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : 80;
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
    : label_(printable(label)), on_(wanted && ::isatty(STDERR_FILENO))
{
}

void ProgressBar::show(double fraction, const std::string& words)
{
  constexpr auto kMinInterval = std::chrono::milliseconds(100);
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (receiver) *receiver = fraction;
  const auto now = std::chrono::steady_clock::now();
  if (!on_ || receiver || now - last_ < kMinInterval) return;
  last_ = now;
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(std::lround(fraction * kWidth));
  const double now_s = std::chrono::duration<double>(now.time_since_epoch()).count();
  const std::string left = left_.text(fraction, now_s);
  std::string line = label_ + " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') +
                     "] " + std::to_string(static_cast<int>(100 * fraction)) + " %  " +
                     printable(words) + (left.empty() ? "" : ", " + left);
  line.resize(std::min(line.size(), columns() - 1));
  std::fprintf(stderr, "\r%s\033[K", line.c_str());
  std::fflush(stderr);
}

void ProgressBar::remove()
{
  if (on_ && !receiver) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::send_to(double* fraction) { receiver = fraction; }

}  // namespace talus::app
