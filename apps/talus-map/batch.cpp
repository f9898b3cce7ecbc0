#include "run_job.h"

#include "../common/child_process.h"
#include "../common/memory_limit.h"
#include "../common/log_name.h"
#include "../common/output_folder.h"
#include "../common/printable.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <thread>

namespace talus::app
{
namespace
{
constexpr int kSignalCode = 128;  // and the number of the signal

class Batch
{
 public:
  Batch(std::vector<Job> jobs, const Options& options, const Settings& settings)
      : jobs_(std::move(jobs)), options_(options), settings_(settings)
  {
    const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (jobs_.size() > 1 && settings.backend != Backend::Cpu)
      devices_ = settings.device ? 1 : count_devices();
    const Sharing shared = share(options, settings, jobs_.size(), cores, devices_);
    at_once_ = shared.at_once;
    share_log_memory(at_once_);
    options_.memory_mb = shared.memory_mb;
    for (Job& job : jobs_)
    {
      job.threads = shared.threads;
      job.device = settings.device.value_or(0);
    }
  }

  int run()
  {
    if (at_once_ > 1)
      run_some_at_once();
    else
      for (std::size_t i = 0; i < jobs_.size() && stop_signal() == 0; ++i)
        if (!map_log(i)) failed_.push_back(jobs_[i].log);
    if (stop_signal()) return kSignalCode + stop_signal();
    if (jobs_.size() > 1) report();
    return failed_.empty() ? kDone : kSomeFailed;
  }

 private:
  bool map_log(std::size_t i) const
  {
    const Job& job = jobs_[i];
    std::string label = name_of_source(job.log);
    if (jobs_.size() > 1)
      label = std::to_string(i + 1) + "/" + std::to_string(jobs_.size()) + " " + label;
    if (!run_job(job, options_, settings_, label)) return false;
    if (!options_.quiet)
      std::cout << "  wrote   " << (std::filesystem::path(job.folder) / "map.png").string()
                << (options_.has_site ? ", site.png" : "") << exports_text()
                << (job.labels.empty() ? "" : ", and labels into " + job.labels) << "\n";
    return true;
  }

  /** ", and as ros, html"; empty without exports. */
  std::string exports_text() const
  {
    std::string text;
    for (const std::string& format : options_.exports.formats)
      text += (text.empty() ? ", and as " : ", ") + format;
    return text;
  }

  void run_some_at_once()
  {
    // Of the jobs none knows whether it is the last that leaves these folders empty.
    std::optional<OutputFolder> all;
    if (!options_.output.empty()) all.emplace(options_.output);
    std::optional<OutputFolder> all_labels;
    if (!options_.labels.empty()) all_labels.emplace(options_.labels, "--labels");
    WorkPlan plan;
    plan.jobs = jobs_.size();
    plan.at_once = at_once_;
    plan.shows_progress = !options_.quiet;
    plan.work = [&](std::size_t i, std::size_t seat)
    {
      if (devices_ > 1) jobs_[i].device = static_cast<int>(seat) % devices_;
      const bool done = map_log(i);
      return stop_signal() ? kSignalCode + stop_signal() : done ? kDone : kSomeFailed;
    };
    plan.ended = [&](std::size_t i, const WorkerEnd& end) { take_end(i, end); };
    run_at_once(plan);
  }

  void take_end(std::size_t i, const WorkerEnd& end)
  {
    std::cerr << end.err;
    std::cout << end.out << std::flush;
    if (end.signal) print_error(jobs_[i].log + ": its process ended by " + signal_text(end.signal));
    if (end.signal || end.exit_code != kDone) failed_.push_back(jobs_[i].log);
  }

  void report() const
  {
    if (!options_.quiet)
      std::cout << jobs_.size() << " logs: " << jobs_.size() - failed_.size() << " done, "
                << failed_.size() << " failed\n";
    if (failed_.empty()) return;
    print_error(std::to_string(failed_.size()) + " of the logs failed:");
    for (const auto& log : failed_) std::cerr << "  " << printable(log) << "\n";
  }

  std::vector<Job> jobs_;
  Options options_;
  const Settings& settings_;
  int devices_ = 0;  //!< that the logs are dealt out over
  std::size_t at_once_ = 1;
  std::vector<std::string> failed_;
};
}  // namespace

int run_batch(std::vector<Job> jobs, const Options& options, const Settings& settings)
{
  return Batch(std::move(jobs), options, settings).run();
}

}  // namespace talus::app
