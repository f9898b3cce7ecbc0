#include "interrupt.h"

#include <csignal>

namespace talus::app
{
namespace
{
volatile std::sig_atomic_t noted = 0;

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

void note(int signal)
{
  noted = signal;
  for (const int s : kSignals) std::signal(s, SIG_DFL);
}
}  // namespace

Interrupt::Interrupt()
{
  noted = 0;
  for (const int s : kSignals)
    // A program that ignores a signal (nohup) goes on ignoring it.
    if (std::signal(s, note) == SIG_IGN) std::signal(s, SIG_IGN);
}

Interrupt::~Interrupt()
{
  for (const int s : kSignals)
    if (std::signal(s, SIG_DFL) == SIG_IGN) std::signal(s, SIG_IGN);
}

void Interrupt::check() const
{
  if (noted != 0) throw Interrupted{static_cast<int>(noted)};
}

}  // namespace talus::app
