// talus-live: the clouds of a robot with ROS 2 in, its map out, while it drives.
#include "../common/child_process.h"
#include "../common/output_folder.h"
#include "../common/run_app.h"
#include "drive_map.h"
#include "jump_finder.h"
#include "live_page.h"
#include "options.h"
#include "publisher.h"
#include "remaker.h"
#include "topics.h"

#include <malloc.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace talus::app
{
namespace
{
double now_s()
{
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(since).count();
}

/** All that runs between start and signal. */
class Live
{
 public:
  Live(const Options& options, const Settings& settings)
      : options_(options),
        page_(
            options.page ? std::make_unique<LivePage>(options.page_address, *options.page)
                         : nullptr),
        output_(options.output),
        map_(std::make_unique<DriveMap>(
            settings, options.memory_mb, output_.staging(), options.resume)),
        jump_finder_(settings.parameters.resolution_m),
        network_(options.domain.value_or(live::domain_of_environment()), "talus_live"),
        topics_(network_, options.source.topics, options.corrected_path),
        stream_(options.source, options.max_wait_s)
  {
    if (options.record) remaker_.emplace(options, settings, output_.staging());
    if (options.hz > 0) publisher_.emplace(network_, options.layers);
    show(*map_);
    if (page_)
    {
      page_->begin("talus-live: " + options.output, map_->site().resolution_m);
      tell("shows the map at http://" + options.page_address + ":" + std::to_string(*options.page));
    }
    tell(
        "joins domain " + std::to_string(options.domain.value_or(live::domain_of_environment())) +
        ", maps on " + map_->window().backend_name());
  }

  void run();
  /** False: the record is not among the results. */
  bool finish();

 private:
  void tell(const std::string& text) const
  {
    if (!options_.quiet) std::cout << text << std::endl;
  }
  void look();
  bool next_scan();
  void show(DriveMap& map);
  void publish_window();
  void publish();
  void save(double now);
  void map_scans();
  void tell_state();
  void tell_of_losses();
  void take_poses(double now);
  void correct(double now);
  void finish_corrections();
  void drop_record(const std::string& why);

  const Options& options_;
  std::unique_ptr<LivePage> page_;  //!< where it is wanted
  OutputFolder output_;
  std::unique_ptr<DriveMap> map_;
  JumpFinder jump_finder_;
  std::optional<Remaker> remaker_;  //!< with --record
  live::Participant network_;
  std::optional<Publisher> publisher_;
  Topics topics_;
  import::ScanStream stream_;
  import::ImportedScan scan_;
  std::string trouble_, told_path_;  //!< that was told last
  bool has_record_ = true;  //!< where one is wanted
  bool has_told_of_jump_ = false;
  std::optional<int> saving_;  //!< the child that does
  double published_s_ = 0, saved_s_ = now_s();
  std::size_t published_frames_ = 0;
  std::optional<io::LayerStack> shown_;  //!< a window beside which the rest is due
  std::size_t told_scans_ = 0, told_late_ = 0, told_dropped_ = 0, told_missing_ = 0, told_lost_ = 0;
};

/** Who publishes what changes seldom. */
void Live::look()
{
  for (const auto& text : topics_.look(stream_)) tell(text);
  for (const auto& text : stream_.take_news()) tell(text);
  network_.announce();
}

void Live::run()
{
  constexpr double kLook_s = 0.1, kState_s = 5, kWait_s = 0.02;
  double looked_s = 0, told_s = now_s();
  while (!stop_signal())
  {
    network_.wait(kWait_s);
    map_scans();
    const double now = now_s();
    correct(now);
    if (std::abs(now - looked_s) >= kLook_s) look(), looked_s = now;
    if (std::abs(now - told_s) >= kState_s) tell_state(), told_s = now;
    if (options_.save_every_min > 0) save(now);
  }
}

/** All that has come: before a cloud is late, its poses are heard. */
bool Live::next_scan()
{
  const double now = now_s();
  topics_.take_into(stream_, now);
  take_poses(now);
  return stream_.next(scan_, now);
}

void Live::take_poses(double now)
{
  const auto poses = stream_.take_new_poses();
  const auto jumps = jump_finder_.add(poses);
  if (remaker_) return remaker_->add(poses, jumps, now);
  if (!jumps.empty() && !std::exchange(has_told_of_jump_, true))
    print_error(
        "map -> odom has jumped: what was mapped before stays where it is; with --record the map "
        "is made again");
}

/** Where better poses become known. */
void Live::correct(double now)
{
  if (!remaker_) return;
  try
  {
    const auto path = stream_.map_frame().empty() ? std::nullopt : topics_.take_path();
    if (path) remaker_->take_path(*path, stream_.map_frame(), now);
  }
  catch (const std::runtime_error& e)
  {
    if (const std::string text = e.what(); std::exchange(told_path_, text) != text)
      print_error(text);
  }
  auto map = remaker_->work(now);
  for (const auto& text : remaker_->take_news()) tell(text);
  for (const auto& text : remaker_->take_errors()) print_error(text);
  if (!map) return;
  show(*map);
  map_ = std::move(map);
  ::malloc_trim(0);  // what the old one leaves lies between what stays
  if (publisher_) publisher_->begin_anew(remaker_->take_whole(), remaker_->history());
  published_frames_ = 0;
  publish();
}

/** A robot that is switched off may say so twice, by two signals: then it cannot wait. */
void Live::finish_corrections()
{
  correct(now_s());
  if (!remaker_ || !remaker_->is_at_work()) return;
  tell("waits for the map that is made again; another signal (TERM, INT) ends that");
  const int signal = stop_signal();
  constexpr auto kStep = std::chrono::milliseconds(10);
  for (; remaker_->is_at_work() && stop_signal() == signal; std::this_thread::sleep_for(kStep))
  {
    remaker_->hurry();
    correct(now_s());
  }
}

/** The map is worth more. */
void Live::drop_record(const std::string& why)
{
  print_error(why + "; nothing is recorded any more");
  remaker_.reset();
  has_record_ = false;
  std::error_code none;  // somebody may have removed the folder
  for (const auto& file : std::filesystem::directory_iterator(output_.staging(), none))
    if (file.path().filename().string().rfind("record.", 0) == 0)
      std::filesystem::remove(file.path());
}

void Live::map_scans()
{
  while (next_scan())
  {
    std::string wrong;
    try
    {
      wrong = map_->add(scan_, remaker_ ? remaker_->poses() : stream_.poses());
    }
    catch (const std::runtime_error& e)
    {
      wrong = e.what();
    }
    if (!wrong.empty()) print_error(wrong + "; it is left out");
    publish();
    try
    {
      if (remaker_) remaker_->add(scan_);
    }
    catch (const std::runtime_error& e)
    {
      drop_record(e.what());
    }
  }
  publish();
}

/** The window before all that can wait. */
void Live::show(DriveMap& map)
{
  if (publisher_) map.set_output(publisher_->layers(), [this] { publish_window(); });
}

void Live::publish_window()
{
  const double now = now_s();
  if (map_->frames() == published_frames_ || std::abs(now - published_s_) < 1 / options_.hz) return;
  published_s_ = now;
  published_frames_ = map_->frames();
  shown_ = publisher_->publish_window(*map_, stream_.map_frame());
}

void Live::publish()
{
  if (page_) page_->update(*map_);
  if (!publisher_) return;
  publish_window();
  if (const auto window = std::exchange(shown_, std::nullopt))
    publisher_->publish_rest(*map_, *window, stream_.map_frame());
}

/** In a child: the map goes on meanwhile. */
void Live::save(double now)
{
  constexpr double kMinute_s = 60;
  if (saving_ && ::waitpid(*saving_, nullptr, WNOHANG) != 0) saving_.reset();
  if (saving_ || map_->frames() == 0 || (remaker_ && remaker_->is_making())) return;
  if (std::abs(now - saved_s_) < options_.save_every_min * kMinute_s) return;
  saved_s_ = now;
  saving_ = map_->start_save(options_.output);
  if (!saving_)
    print_error(
        "the site is too large for --save-every; --memory allows more, it is written at the end");
}

/** What is wrong, when nothing came since it was asked last; and what gets lost. */
void Live::tell_state()
{
  const auto counts = stream_.counts();
  if (counts.scans == told_scans_)
  {
    std::string trouble = topics_.why_nothing();
    if (trouble.empty()) trouble = stream_.why_nothing();
    if (trouble.empty()) trouble = "no cloud comes any more";
    if (trouble != trouble_) print_error("no scan for 5 s: " + trouble);
    trouble_ = trouble;
  }
  else if (const auto why = map_->why_empty(); why != trouble_)
  {
    if (!why.empty()) print_error(why);
    trouble_ = why;
  }
  told_scans_ = counts.scans;
  if (counts.late > told_late_)
    print_error(
        std::to_string(counts.late - told_late_) + " clouds are left out: " + stream_.why_late());
  told_late_ = counts.late;
  if (counts.dropped > told_dropped_)
    print_error(
        std::to_string(counts.dropped - told_dropped_) +
        " clouds are left out: they come faster than they are mapped; a larger resolution_m or a "
        "smaller window_m takes less time (-s NAME=VALUE), and so do more --threads");
  told_dropped_ = counts.dropped;
  tell_of_losses();
}

void Live::tell_of_losses()
{
  constexpr std::size_t kEnough_bytes = std::size_t{16} << 20, kPacket_bytes = 65536;
  const auto missing = stream_.counts().missing, lost = topics_.lost();
  told_lost_ = std::min(told_lost_, lost);  // topics that are left count no more
  if (missing == told_missing_ && lost == told_lost_) return;
  std::string text = "by their stamps " + std::to_string(missing - told_missing_) +
                     " clouds are missing between those that came, and the network has lost " +
                     std::to_string(lost - told_lost_) + " messages";
  told_missing_ = missing;
  told_lost_ = lost;
  const auto buffer = live::max_receive_buffer();
  if (topics_.max_bytes() > kPacket_bytes && buffer > 0 && buffer < kEnough_bytes)
    text += "; one has " + std::to_string(topics_.max_bytes()) +
            " bytes, and sockets get no more than " + std::to_string(buffer) +
            ": sudo sysctl -w net.core.rmem_max=" + std::to_string(kEnough_bytes);
  print_error(text);
}

bool Live::finish()
{
  page_.reset();
  map_scans();
  stream_.end();
  map_scans();
  const auto counts = stream_.counts();
  tell_of_losses();
  const auto tell_count = [](std::size_t count, const char* what)
  {
    if (count > 0) print_error(std::to_string(count) + " clouds " + what);
  };
  tell_count(counts.late, "are left out: no pose or mounting came in time");
  tell_count(counts.dropped, "are left out: they came faster than they were mapped");
  tell_count(counts.stale, "are left out: they were not newer than the one before");
  tell_count(counts.refused, "are left out: they could not be read");
  tell_count(counts.without_times, "are mapped without the times of their points");
  if (counts.scans == 0)
  {
    const bool has_heard = counts.late + counts.dropped + counts.stale + counts.refused > 0;
    const auto why = has_heard ? "" : topics_.why_nothing();  // a robot may have left since
    throw std::runtime_error(
        "nothing was mapped, nothing is written: " + (why.empty() ? stream_.why_nothing() : why));
  }
  if (saving_) wait_for_child(*saving_);
  finish_corrections();
  try
  {
    if (remaker_) remaker_->close();
  }
  catch (const std::runtime_error& e)
  {
    drop_record(e.what());
  }
  output_.make_sure_it_exists();
  map_->finish(output_.staging());
  output_.commit(kSeal);
  tell(
      std::to_string(map_->frames()) + " frames of " + std::to_string(counts.scans) +
      " scans are mapped: " + options_.output + "/site.tif, site.png, map.tif, map.png");
  return has_record_;
}

int run(const Options& options)
{
  Settings settings = load_settings(options.config, options.overrides);
  if (options.backend) settings.backend = *options.backend;
  if (options.threads) settings.threads = *options.threads;
  for (const auto& warning : settings.warnings) print_error("warning: " + warning);
  Live live(options, settings);
  live.run();
  return live.finish() ? 0 : 1;
}
}  // namespace
}  // namespace talus::app

int main(int argc, char** argv)
{
  return talus::app::run_app("talus-live", argc, argv, talus::app::run);
}
