#include "child_process.h"

#include "suspect.h"

#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <iterator>
#include <stdexcept>

namespace talus::app
{
namespace
{
volatile std::sig_atomic_t asked_to_stop = 0;
volatile std::sig_atomic_t running_child = 0;

constexpr int kForwarded[] = {SIGINT, SIGTERM, SIGHUP};

void on_signal(int signal)
{
  asked_to_stop = signal;
  if (running_child > 0) ::kill(static_cast<pid_t>(running_child), SIGKILL);
}

[[noreturn]] void be_the_child(const std::function<int()>& work, pid_t parent) noexcept
{
  // A parent that is killed cannot tidy up after its child: the child goes with it.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it was killed before
  const int code = work();
  std::cout.flush();
  std::fflush(nullptr);
  ::_exit(code);  // not exit(): what the parent registered to be undone is the parent's
}
}  // namespace

int start_child(const std::function<int()>& work)
{
  std::cout.flush();
  std::fflush(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0)
    throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) be_the_child(work, parent);
  return child;
}

ChildEnd run_in_child(const std::function<int()>& work)
{
  Suspect::forget();
  const pid_t child = start_child(
      [&]
      {
        for (const int s : kForwarded)  // as before forward_signals()
          if (std::signal(s, SIG_DFL) == SIG_IGN) std::signal(s, SIG_IGN);
        return work();
      });
  running_child = child;
  if (asked_to_stop) ::kill(child, SIGKILL);
  siginfo_t ended;
  while (::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR)
  {
  }
  running_child = 0;  // before its number can become that of another process
  return wait_for_child(child);
}

int run_command_in_child(
    const std::string& file, const std::function<int()>& work,
    const std::function<void(const std::string&)>& tell)
{
  const ChildEnd end = run_in_child(work);
  if (stop_signal())
  {
    tell("stopped; nothing was written");
    return 128 + stop_signal();
  }
  if (end.signal) throw std::runtime_error(crash_text(file, end.signal));
  return end.exit_code;
}

ChildEnd wait_for_child(int child)
{
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
  {
  }
  ChildEnd end;
  if (WIFSIGNALED(status))
    end.signal = WTERMSIG(status);
  else
    end.exit_code = WEXITSTATUS(status);
  // A signal to the whole group, as of a terminal, may reach the child first.
  if (std::count(std::begin(kForwarded), std::end(kForwarded), end.signal) > 0)
    asked_to_stop = end.signal;
  return end;
}

void forward_signals()
{
  struct sigaction forward = {};
  forward.sa_handler = on_signal;  // without SA_RESTART: whatever waits for ever ends
  for (const int s : kForwarded)
  {
    struct sigaction before = {};
    // A program that ignores a signal (nohup) goes on ignoring it.
    if (::sigaction(s, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
      ::sigaction(s, &forward, nullptr);
  }
}

int stop_signal() { return asked_to_stop; }

std::string signal_text(int signal)
{
  return "signal " + std::to_string(signal) + ", " + ::strsignal(signal);
}

std::string crash_text(const std::string& log, int signal)
{
  Suspect::Named suspect = Suspect::newest();
  Suspect::forget();  // this process may be a child itself
  if (suspect.file.empty()) suspect = {log, kLookAtLog};
  if (signal == SIGKILL)
    return suspect.file + ": was killed, perhaps for want of memory; it gives no results";
  const std::string what = signal == SIGPROF ? "computing over it did not come to an end"
                                             : "crashed the program (" + signal_text(signal) + ")";
  return suspect.file + ": " + what + "; it gives no results. " + suspect.advice;
}

void limit_computing(int seconds)
{
  itimerval limit{};
  limit.it_value.tv_sec = seconds;
  ::setitimer(ITIMER_PROF, &limit, nullptr);
}

}  // namespace talus::app
