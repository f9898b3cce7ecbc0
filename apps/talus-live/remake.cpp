#include "remake.h"

#include <talus/number_text.h>

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
/** The bits are those of any number of threads. */
Settings on_one_core(Settings settings)
{
  settings.threads = 1;
  return settings;
}

std::string text_of_moves(const Poses& before, const Poses& after)
{
  const io::Trajectory now(after);
  double sum_m = 0, max_m = 0;
  for (const auto& pose : before)
  {
    const auto there = now.at(pose.time_s, HUGE_VAL);
    const double move_m = there ? there->distanceTo(pose.T_map_base) : 0;
    sum_m += move_m;
    max_m = std::max(max_m, move_m);
  }
  const double count = static_cast<double>(std::max<std::size_t>(before.size(), 1));
  return "by " + fixed_text(sum_m / count, 2) + " m on average, by " + fixed_text(max_m, 2) +
         " m at most";
}
}  // namespace

void add_to_history(const io::Trajectory::Entry& pose, Poses& history)
{
  constexpr double kApart_s = 0.1;
  if (history.empty() || pose.time_s >= history.back().time_s + kApart_s) history.push_back(pose);
}

void keep_last(Poses& poses)
{
  constexpr double kKept_s = 10;
  const auto is_kept = [&](const auto& pose)
  { return pose.time_s >= poses.back().time_s - kKept_s; };
  poses.erase(poses.begin(), std::find_if(poses.begin(), poses.end(), is_kept));
}

Remake::Remake(
    const Options& options, const Settings& settings, const std::string& folder,
    const Record& record, Correction correction, Poses history)
    : options_(options),
      settings_(on_one_core(settings)),
      folder_(folder),
      log_(record.log()),
      heard_tum_(record.heard_tum()),
      tum_(record.other_tum()),
      heard_bytes_(fs::file_size(heard_tum_)),
      correction_(std::move(correction)),
      history_(std::move(history))
{
}

Remake::~Remake()
{
  is_stopped_ = true;
  if (round_.valid()) round_.wait();
}

/** What the record gets meanwhile is no concern of it. */
void Remake::begin()
{
  fs::copy_file(heard_tum_, tum_, fs::copy_options::overwrite_existing);
  fs::resize_file(tum_, heard_bytes_);
  auto all = corrected(io::Trajectory::load(tum_).entries(), correction_);
  correction_ = {};
  corrected_.T_after = all.T_after;
  out_.open(tum_, std::ios::binary);
  const Poses before = std::exchange(history_, {});
  for (const auto& pose : all.poses) add(pose);
  moved_text_ = text_of_moves(before, history_);
  reader_ = std::make_unique<io::RawlogReader>(log_);
  map_ = std::make_unique<DriveMap>(settings_, options_.memory_mb, folder_, options_.resume);
}

void Remake::add(const io::Trajectory::Entry& pose)
{
  out_ << io::tum_line(pose);
  add_to_history(pose, history_);
  corrected_.poses.push_back(pose);
}

void Remake::map(const Added& added)
{
  if (!map_) begin();
  for (const auto& pose : added.heard)
  {
    if (pose.time_s >= added.right_from_s) corrected_.T_after = {};
    add(moved(pose, corrected_.T_after));
  }
  const io::Trajectory poses(corrected_.poses);
  for (; scans_ < added.scans && !is_stopped_; ++scans_)
  {
    const auto scan = reader_->next();
    if (!scan) throw std::runtime_error(log_ + ": has lost scans; is the disk full?");
    map_->add(*scan, poses);  // what is wrong with a scan was said when it came
    constexpr std::size_t kOften = 500;  // then what has changed is a small area
    if (scans_ % kOften == 0) look_at_tiles();
  }
  keep_last(corrected_.poses);
  look_at_tiles();
}

void Remake::look_at_tiles()
{
  const Window w = map_->window().window();
  if (options_.hz == 0 || w.cells == 0) return;
  const std::vector<std::int8_t> unknown(static_cast<std::size_t>(w.cells) * w.cells, -1);
  whole_.update(map_->site().tiles, map_->floor(), w, unknown);
  whole_.take_changed();
}

void Remake::start(Added added)
{
  const auto work = [this, new_ones = std::move(added)]
  {
    constexpr int kNice = 10;
    ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread alone
    map(new_ones);
  };
  round_ = std::async(std::launch::async, work);
}

bool Remake::is_at_work() const
{
  return round_.valid() && round_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

std::unique_ptr<DriveMap> Remake::take_map()
{
  out_.close();
  if (!out_) throw std::runtime_error(tum_ + ": cannot be written; is the disk full?");
  return std::move(map_);
}

}  // namespace talus::app
