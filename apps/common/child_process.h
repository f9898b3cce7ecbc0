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

/** Runs `work`, which throws nothing, in a child process, so that a crash in it costs this process
 * nothing, and waits. Its result is the exit code. Throws std::runtime_error when no child can be
 * started. */
ChildEnd run_in_child(const std::function<int()>& work);

/** The same for all that a command does. Its exit code; where a signal asked to stop, 128 + its
 * number, once `tell` was told so. Throws std::runtime_error, crash_text() of `file`, where it
 * crashed. */
int run_command_in_child(
    const std::string& file, const std::function<int()>& work,
    const std::function<void(const std::string&)>& tell);

/** Starts such a process and does not wait for it: what signals do is as here. Its number. */
int start_child(const std::function<int()>& work);

/** Waits for it. */
ChildEnd wait_for_child(int child);

/** From now on SIGINT, SIGTERM and SIGHUP end the running child instead of this process. */
void forward_signals();

/** The signal that asked this program to stop, or 0. */
int stop_signal();

/** E.g. "signal 11, Segmentation fault". */
std::string signal_text(int signal);

/** What to tell of a child that was ended by a signal: which file it is put down to (see Suspect;
 * else to `log`), and what to do. */
std::string crash_text(const std::string& log, int signal);

/** The process that calls this is ended by a signal, which crash_text() explains, where it computes
 * for longer than so many seconds (of all its threads) until it calls it again: what comes from a
 * wrong file may never end. */
void limit_computing(int seconds);

}  // namespace talus::app
