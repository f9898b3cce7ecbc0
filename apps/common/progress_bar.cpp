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
int terminal_columns()
{
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}
}  // namespace

ProgressBar::ProgressBar(std::string label, bool wanted)
    : label_(printable(label)), on_(wanted && ::isatty(STDERR_FILENO))
{
}

ProgressBar::~ProgressBar()
{
  if (on_) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(double fraction, const std::string& words)
{
  using namespace std::chrono;
  const auto now = steady_clock::now();
  if (!on_ || now - last_ < milliseconds(100)) return;
  last_ = now;
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(std::lround(fraction * kWidth));
  std::string line = label_ + " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') +
                     "] " + std::to_string(static_cast<int>(100 * fraction)) + " %  " +
                     printable(words);
  line.resize(std::min(line.size(), static_cast<std::size_t>(std::max(1, terminal_columns() - 1))));
  std::fprintf(stderr, "\r%s\033[K", line.c_str());
  std::fflush(stderr);
}

}  // namespace talus::app
