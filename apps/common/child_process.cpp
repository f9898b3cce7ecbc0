#include "child_process.h"

#include "crash_context.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <sys/mman.h>

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

/** What a process and its children see both. */
struct Note
{
  char file[4096], advice[256];  // paths are no longer
};

/** Of zeros. */
Note* new_note()
{
  void* const page =
      ::mmap(nullptr, sizeof(Note), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  return static_cast<Note*>(page);
}

Note*& shared_note()
{
  static Note* note = new_note();
  return note;
}

void write(const CrashContext::Named& named)
{
  Note& note = *shared_note();
  std::snprintf(note.advice, sizeof note.advice, "%s", named.advice.c_str());
  std::snprintf(note.file, sizeof note.file, "%s", named.file.c_str());
}
}  // namespace

int start_child(const std::function<int()>& work)
{
  std::cout.flush();
  std::fflush(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0)
    throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  if (child > 0) return child;
  // A parent that is killed cannot tidy up after its child: the child goes with it.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it was killed before
  const int code = work();
  std::cout.flush();
  std::fflush(nullptr);
  ::_exit(code);  // not exit(): what the parent registered to be undone is the parent's
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

ChildEnd run_in_child(const std::function<int()>& work)
{
  CrashContext::begin_anew();
  running_child = start_child(
      [&]
      {
        for (const int s : kForwarded)  // as before forward_signals()
          if (std::signal(s, SIG_DFL) == SIG_IGN) std::signal(s, SIG_IGN);
        return work();
      });
  if (asked_to_stop) ::kill(running_child, SIGKILL);
  const ChildEnd end = wait_for_child(running_child);
  running_child = 0;
  return end;
}

int run_command_in_child(
    const std::string& file, const std::string& advice, const std::function<int()>& work,
    const std::function<void(const std::string&)>& report)
{
  const ChildEnd end = run_in_child([&] { return code_of(work, report, file, advice); });
  if (stop_signal())
  {
    report("stopped; nothing was written");
    return 128 + stop_signal();
  }
  if (end.signal) throw std::runtime_error(crash_text(file, end.signal));
  return end.exit_code;
}

void forward_signals()
{
  for (const int s : {SIGXFSZ, SIGPIPE}) std::signal(s, SIG_IGN);
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
  CrashContext::Named blamed = CrashContext::newest();
  CrashContext::begin_anew();  // this process may be a child itself
  if (blamed.file.empty()) blamed = {log, kLookAtLog};
  if (signal == SIGKILL)
    return blamed.file + ": was killed, perhaps for want of memory; it gives no results";
  return blamed.file + ": crashed the program (" + signal_text(signal) +
         "); it gives no results. " + blamed.advice;
}

CrashContext::CrashContext(const std::string& file, const std::string& advice) : before_(newest())
{
  write({file, advice});
}

CrashContext::~CrashContext() { write(before_); }

CrashContext::Named CrashContext::newest() { return {shared_note()->file, shared_note()->advice}; }

void CrashContext::begin_anew()
{
  Note* const fresh = new_note();
  ::munmap(shared_note(), sizeof(Note));
  shared_note() = fresh;
}

std::string failure_text(
    const std::exception& e, const std::string& file, const std::string& advice)
{
  if (!dynamic_cast<const std::bad_alloc*>(&e)) return e.what();
  return file + ": needs more memory than there is. " + advice;
}

int code_of(
    const std::function<int()>& work, const std::function<void(const std::string&)>& report,
    const std::string& file, const std::string& advice)
{
  try
  {
    return work();
  }
  catch (const std::exception& e)
  {
    report(failure_text(e, file, advice));
    return 1;
  }
}

}  // namespace talus::app
