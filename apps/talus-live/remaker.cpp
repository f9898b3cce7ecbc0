#include "remaker.h"

#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
fs::file_time_type time_of(const std::string& path)
{
  std::error_code none;
  return fs::last_write_time(path, none);
}
}  // namespace

Remaker::Remaker(const Options& options, const Settings& settings, const std::string& folder)
    : options_(options),
      settings_(settings),
      folder_(folder),
      record_(folder + "/record.rawlog"),
      resumed_time_(time_of(options.resume))
{
  if (!options.corrected_trajectory.empty()) file_.emplace(options.corrected_trajectory);
}

void Remaker::ask_for(const std::string& source, double from_s)
{
  source_ = source;
  if (!due_s_) due_s_ = from_s;
}

void Remaker::add(
    const std::vector<import::StreamPose>& poses, const std::vector<Jump>& jumps, double now_s)
{
  constexpr double kSettle_s = 1;  // a SLAM may jump again, and say what it knows
  auto jump = jumps.begin();
  for (const auto& pose : poses)
  {
    if (jump != jumps.end() && jump->time_s == pose.time_s)
    {
      known_.jumps.push_back(*jump);
      T_after_ = {};
      added_.right_from_s = std::min(added_.right_from_s, jump->time_s);
      const auto seemed = (-jump->T_after_before) + pose.T_map_base;
      const double jump_m = seemed.distanceTo(pose.T_map_base);
      if (known_.given.empty())
        ask_for("map -> odom has jumped by " + fixed_text(jump_m, 2) + " m", now_s + kSettle_s);
      ++jump;
    }
    const auto used = moved(pose, T_after_);
    record_.add(used, pose);
    if (remake_) added_.heard.push_back(pose);
    recent_.push_back(used);
    add_to_history(used, history_);
  }
  if (poses.empty()) return;
  keep_last(recent_);
  trajectory_.reset();
}

const io::Trajectory& Remaker::poses()
{
  if (!trajectory_) trajectory_.emplace(recent_);
  return *trajectory_;
}

/** A SLAM tells its whole path again and again: only what moves by more than a cell is news. What
 * the map is to have counts before what it has. */
bool Remaker::is_news(const Poses& given) const
{
  const io::Trajectory last(known_.given), used(history_);
  return std::any_of(
      given.begin(), given.end(),
      [&](const io::Trajectory::Entry& pose)
      {
        auto known = last.at(pose.time_s, HUGE_VAL);
        if (!known && (known_.given.empty() || !is_at_work()))
          known = used.at(pose.time_s, HUGE_VAL);
        return known && known->distanceTo(pose.T_map_base) > settings_.parameters.resolution_m;
      });
}

void Remaker::require_same_time(const Poses& given, const std::string& source) const
{
  if (history_.empty() || given.back().time_s < history_.front().time_s ||
      given.front().time_s > history_.back().time_s)
    throw std::runtime_error(source + ": its poses are of another time than the scans");
}

void Remaker::take_path(const import::StreamPath& path, const std::string& map_frame, double now_s)
{
  const std::string& topic = options_.corrected_path;
  if (path.frame != map_frame)
    throw std::runtime_error(
        topic + ": its poses are in '" + path.frame.substr(0, 60) + "', and the map is in '" +
        map_frame + "'; --map-frame names the frame of both");
  if (path.poses.empty())
    throw std::runtime_error(topic + ": none of its poses has a time and finite numbers");
  auto given = io::Trajectory(path.poses).entries();
  if (!history_.empty()) require_same_time(given, topic);
  if (!is_news(given)) return;
  known_.given = std::move(given);
  ask_for(std::to_string(known_.given.size()) + " corrected poses of " + topic, now_s);
}

void Remaker::look_at_file(double now_s)
{
  constexpr double kLook_s = 0.1;
  if (!file_ || std::abs(now_s - looked_s_) < kLook_s) return;
  looked_s_ = now_s;
  const std::string& path = options_.corrected_trajectory;
  try
  {
    auto given = file_->take(now_s);
    if (!given) return;
    require_same_time(*given, path);
    known_.given = std::move(*given);
    ask_for(std::to_string(known_.given.size()) + " corrected poses of " + path, now_s);
  }
  catch (const std::runtime_error& e)
  {
    errors_.emplace_back(e.what());
  }
}

std::unique_ptr<DriveMap> Remaker::work(double now_s)
{
  look_at_file(now_s);
  try
  {
    // It may have half of a core for long, as where the map goes on to jump.
    const bool may_begin = due_s_ && now_s >= *due_s_ && now_s >= began_s_ + 2 * took_s_;
    if (!remake_ && may_begin && record_.scans() > 0) begin(now_s);
    if (!remake_ || remake_->is_at_work()) return nullptr;
    remake_->wait();
    constexpr std::size_t kFew = 5;  // are mapped at once, so that none comes meanwhile
    if (record_.scans() <= remake_->scans() + kFew) return end(now_s);
    go_on();
  }
  catch (const std::exception& e)
  {
    errors_.push_back(std::string("the map is not made again, it stays as it is: ") + e.what());
    remake_.reset();
  }
  return nullptr;
}

void Remaker::begin(double now_s)
{
  due_s_.reset();
  began_s_ = now_s;
  if (time_of(options_.resume) != resumed_time_)
    throw std::runtime_error(
        options_.resume + ": has been replaced since it was read; resume a copy of it");
  news_.push_back(
      source_ + ": the map of " + std::to_string(record_.scans()) +
      " scans is made again, in the background");
  added_ = {};
  record_.flush();
  remake_ = std::make_unique<Remake>(options_, settings_, folder_, record_, known_, history_);
  go_on();
}

/** All that has come so far. */
void Remaker::go_on()
{
  record_.flush();
  added_.scans = record_.scans();
  remake_->start(std::exchange(added_, {}));
}

std::unique_ptr<DriveMap> Remaker::end(double now_s)
{
  record_.flush();
  added_.scans = record_.scans();
  remake_->map(std::exchange(added_, {}));
  auto map = remake_->take_map();
  if (map->frames() == 0) throw std::runtime_error("no scan can be mapped with the new poses");
  record_.take_poses();
  map->run_on(settings_);
  recent_ = remake_->poses().poses;
  T_after_ = remake_->poses().T_after;
  history_ = remake_->history();
  whole_ = remake_->take_whole();
  trajectory_.reset();
  took_s_ = now_s - began_s_;
  news_.push_back(
      "the map is made again, of " + std::to_string(remake_->scans()) + " scans in " +
      fixed_text(took_s_, 1) + " s; their poses have moved " + remake_->moved_text());
  remake_.reset();
  return map;
}

void Remaker::close()
{
  due_s_.reset();
  remake_.reset();
  record_.close();
}

}  // namespace talus::app
