#pragma once
#include <cstddef>
#include <functional>
#include <string>

namespace talus::app
{
/** How a child process ended. */
struct ChildEnd
{
  int exit_code = 0;  //!< when it ended by itself
  int signal = 0;  //!< when a signal ended it
};

/** Starts a child process that does `work`, which throws nothing; its result is the exit code. The
 * number of the process. Throws std::runtime_error when none can be started. */
int start_child(const std::function<int()>& work);

/** Waits for it. */
ChildEnd wait_for_child(int child);

/** Both; a crash in the child costs this process nothing. */
ChildEnd run_in_child(const std::function<int()>& work);

/** The same for all that a command does with `file`. Its exit code: 1 where `work` throws, of which
 * failure_text() with `advice` is reported; where a signal asked to stop, 128 + its number, which
 * is reported, too. Throws std::runtime_error, crash_text() of `file`, where it crashed. */
int run_command_in_child(
    const std::string& file, const std::string& advice, const std::function<int()>& work,
    const std::function<void(const std::string&)>& report);

/** From now on SIGINT, SIGTERM and SIGHUP end the running child instead of this process; and a
 * limit on the size of files, or nobody who reads what is printed, is an error of write(). So no
 * signal but SIGKILL leaves a hidden folder behind. */
void forward_signals();

/** The signal that asked this program to stop, or 0. */
int stop_signal();

/** E.g. "signal 11, Segmentation fault". */
std::string signal_text(int signal);

/** The error message of a child that was ended by a signal: which file it is put down to (see
 * CrashContext; else to `log`), and what to do. */
std::string crash_text(const std::string& log, int signal);

/** How one of several jobs ended, and what it printed. */
struct WorkerEnd : ChildEnd
{
  std::string out, err;
};

/** Jobs 0, 1, ... of a command, of which some run at once: each in a process of its own, since the
 * reader of logs, the context of a crash and limits are of a whole process. */
struct WorkPlan
{
  std::size_t jobs = 0, at_once = 1;
  /** In the process of the job. Throws nothing; its result is the exit code. `seat` is less than
   * `at_once`, and no other job that runs has it. */
  std::function<int(std::size_t job, std::size_t seat)> work;
  /** In this process and in the order of the jobs, whichever ends first. */
  std::function<void(std::size_t job, const WorkerEnd&)> ended;
  bool shows_progress = false;  //!< a line for all, where stderr is a terminal
};

/** Runs them. After stop_signal() the jobs that run get that signal, and no other begins. Throws
 * std::runtime_error when no process can be started. */
void run_at_once(const WorkPlan& plan);

}  // namespace talus::app
