#pragma once
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

}  // namespace talus::app
