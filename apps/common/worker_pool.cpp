#include "child_process.h"

#include "crash_context.h"
#include "progress_bar.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>
#include <new>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <vector>

namespace talus::app
{
namespace
{
/** A file in memory, for what another process prints. */
class Printed
{
 public:
  Printed() : file_(::memfd_create("printed", MFD_CLOEXEC))
  {
    if (file_ < 0)
      throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  }
  ~Printed() { ::close(file_); }
  Printed(const Printed&) = delete;
  Printed& operator=(const Printed&) = delete;

  int file() const { return file_; }
  std::string text() const
  {
    std::string all(static_cast<std::size_t>(::lseek(file_, 0, SEEK_END)), '\0');
    const ssize_t got = ::pread(file_, all.data(), all.size(), 0);
    all.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return all;
  }

 private:
  int file_;
};

struct Worker
{
  explicit Worker(std::size_t its_job) : job(its_job) {}
  std::size_t job;
  int pid = 0;
  Printed out, err;

  bool has_ended() const
  {
    siginfo_t end{};
    const auto id = static_cast<id_t>(pid);
    return ::waitid(P_PID, id, &end, WEXITED | WNOHANG | WNOWAIT) == 0 && end.si_pid != 0;
  }
};

/** How far each job is, which its process writes and this one reads. */
double* shared_fractions(std::size_t count)
{
  void* const all = ::mmap(
      nullptr, count * sizeof(double), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) throw std::bad_alloc();
  return static_cast<double*>(all);
}

class Pool
{
 public:
  explicit Pool(const WorkPlan& plan)
      : plan_(plan),
        fractions_(shared_fractions(plan.jobs)),
        bar_(std::to_string(plan.jobs) + " logs", plan.shows_progress),
        seats_(plan.at_once)
  {
  }
  ~Pool() { ::munmap(fractions_, plan_.jobs * sizeof(double)); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  void run()
  {
    constexpr int kMoment_us = 20000;
    const auto count = static_cast<double>(plan_.jobs);
    do
    {
      if (stop_signal())
        for (const auto& worker : seats_)
          if (worker) ::kill(worker->pid, stop_signal());
      for (std::size_t seat = 0; seat < seats_.size(); ++seat)
      {
        if (seats_[seat] && seats_[seat]->has_ended()) end(seat);
        if (!seats_[seat] && next_ < plan_.jobs && stop_signal() == 0) begin(seat);
      }
      report_ended();
      bar_.show(
          std::accumulate(fractions_, fractions_ + plan_.jobs, 0.0) / count,
          std::to_string(reported_) + " done");
      ::usleep(kMoment_us);
    } while (std::any_of(seats_.begin(), seats_.end(), [](const auto& w) { return bool(w); }));
    report_ended();
  }

 private:
  void begin(std::size_t seat)
  {
    Worker& worker = seats_[seat].emplace(next_++);
    worker.pid = start_child(
        [&]
        {
          CrashContext::begin_anew();
          ::dup2(worker.out.file(), STDOUT_FILENO);
          ::dup2(worker.err.file(), STDERR_FILENO);
          ProgressBar::send_to(&fractions_[worker.job]);
          return plan_.work(worker.job, seat);
        });
  }

  void end(std::size_t seat)
  {
    const Worker& worker = *seats_[seat];
    ended_[worker.job] = {wait_for_child(worker.pid), worker.out.text(), worker.err.text()};
    fractions_[worker.job] = 1;
    seats_[seat].reset();
  }

  void report_ended()
  {
    // Those that a signal kept from beginning have no end.
    for (auto it = ended_.find(reported_); it != ended_.end(); it = ended_.find(++reported_))
    {
      bar_.remove();
      plan_.ended(it->first, it->second);
      ended_.erase(it);
    }
  }

  const WorkPlan& plan_;
  double* fractions_;
  ProgressBar bar_;
  std::size_t next_ = 0, reported_ = 0;
  std::vector<std::optional<Worker>> seats_;
  std::map<std::size_t, WorkerEnd> ended_;
};
}  // namespace

void run_at_once(const WorkPlan& plan) { Pool(plan).run(); }

}  // namespace talus::app
