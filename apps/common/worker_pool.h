#pragma once
#include "child_process.h"

#include <cstddef>
#include <functional>
#include <string>

namespace talus::app
{
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
