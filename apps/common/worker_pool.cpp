#include "worker_pool.h"

#include "progress_bar.h"
#include "suspect.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace talus::app
{
namespace
{
/** A file that is closed at the end. */
class Descriptor
{
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& o) noexcept : number_(o.number_) { o.number_ = -1; }
  Descriptor& operator=(Descriptor&& o) noexcept
  {
    std::swap(number_, o.number_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close()
  {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }
  int number() const { return number_; }

 private:
  int number_;
};

struct Pipe
{
  Descriptor read_end, write_end;
  Pipe()
  {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
      throw std::runtime_error(std::string("cannot make a pipe: ") + std::strerror(errno));
    read_end = Descriptor(ends[0]);
    write_end = Descriptor(ends[1]);
  }
};

/** What one process sends, by kind. */
enum Stream : std::size_t
{
  kOut,
  kErr,
  kProgress,
  kStreams
};

struct Worker
{
  std::size_t job = 0, seat = 0;
  pid_t pid = 0;
  std::array<Descriptor, kStreams> from;
  std::array<std::string, kStreams> text;

  bool is_silent() const
  {
    return std::all_of(from.begin(), from.end(), [](const auto& d) { return d.number() < 0; });
  }
  void read(std::size_t stream)
  {
    std::array<char, 65536> bytes{};
    const ssize_t got = ::read(from[stream].number(), bytes.data(), bytes.size());
    if (got > 0)
      text[stream].append(bytes.data(), static_cast<std::size_t>(got));
    else if (got == 0 || errno != EINTR)
      from[stream].close();
  }
  /** The newest whole line of its progress. */
  std::string progress_line()
  {
    std::string& lines = text[kProgress];
    const auto end = lines.rfind('\n');
    if (end == std::string::npos || end == 0) return {};
    const auto before = lines.rfind('\n', end - 1);
    if (before != std::string::npos) lines.erase(0, before + 1);
    return lines.substr(0, lines.find('\n'));
  }
};

class Pool
{
 public:
  explicit Pool(const WorkPlan& plan) : plan_(plan), lines_(plan.shows_progress) {}

  void run()
  {
    while (can_begin() || !running_.empty())
    {
      while (can_begin() && running_.size() < plan_.at_once) begin_or_fail(next_++);
      listen();
      if (stop_signal())
        for (const Worker& w : running_) ::kill(w.pid, stop_signal());
      end_silent_ones();
      tell_ended();
      draw();
    }
  }

 private:
  bool can_begin() const { return next_ < plan_.jobs && stop_signal() == 0; }

  std::size_t free_seat() const
  {
    std::size_t seat = 0;
    const auto is_taken = [&](const Worker& w) { return w.seat == seat; };
    while (std::any_of(running_.begin(), running_.end(), is_taken)) ++seat;
    return seat;
  }

  void begin_or_fail(std::size_t job)
  {
    try
    {
      begin(job);
    }
    catch (const std::runtime_error& e)
    {
      WorkerEnd& end = ended_[job];
      end.exit_code = 1;
      end.err = std::string(::program_invocation_short_name) + ": " + e.what() + "\n";
    }
  }

  void begin(std::size_t job)
  {
    Worker worker;
    worker.job = job;
    worker.seat = free_seat();
    std::array<Pipe, kStreams> pipes;
    worker.pid = start_child(
        [&]
        {
          running_.clear();  // what others send is for the parent
          Suspect::be_alone();
          ::dup2(pipes[kOut].write_end.number(), STDOUT_FILENO);
          ::dup2(pipes[kErr].write_end.number(), STDERR_FILENO);
          ProgressBar::send_to(pipes[kProgress].write_end.number());
          return plan_.work(job, worker.seat);
        });
    for (std::size_t s = 0; s < kStreams; ++s) worker.from[s] = std::move(pipes[s].read_end);
    running_.push_back(std::move(worker));
  }

  /** Waits until some of them send something, or a moment. */
  void listen()
  {
    constexpr int kMoment_ms = 100;
    std::vector<pollfd> polled;
    polled.reserve(running_.size() * kStreams);
    for (const Worker& w : running_)
      for (const Descriptor& d : w.from) polled.push_back({d.number(), POLLIN, 0});  // -1: none
    if (::poll(polled.data(), polled.size(), kMoment_ms) <= 0) return;
    for (std::size_t i = 0; i < polled.size(); ++i)
      if (polled[i].revents) running_[i / kStreams].read(i % kStreams);
  }

  void end_silent_ones()
  {
    const auto is_running = [this](Worker& w)
    {
      if (!w.is_silent()) return true;
      WorkerEnd& end = ended_[w.job];
      static_cast<ChildEnd&>(end) = wait_for_child(w.pid);
      end.out = std::move(w.text[kOut]);
      end.err = std::move(w.text[kErr]);
      return false;
    };
    running_.erase(
        std::stable_partition(running_.begin(), running_.end(), is_running), running_.end());
  }

  void tell_ended()
  {
    // Those that a signal kept from beginning have no end.
    for (auto it = ended_.find(told_); it != ended_.end(); it = ended_.find(++told_))
    {
      lines_.remove();
      plan_.ended(it->first, it->second);
      ended_.erase(it);
    }
  }

  void draw()
  {
    std::vector<std::string> lines;
    lines.reserve(running_.size());
    for (Worker& w : running_)
      if (auto line = w.progress_line(); !line.empty()) lines.push_back(std::move(line));
    lines_.show(lines);
  }

  const WorkPlan& plan_;
  ProgressLines lines_;
  std::size_t next_ = 0, told_ = 0;
  std::vector<Worker> running_;
  std::map<std::size_t, WorkerEnd> ended_;
};
}  // namespace

void run_at_once(const WorkPlan& plan) { Pool(plan).run(); }

}  // namespace talus::app
