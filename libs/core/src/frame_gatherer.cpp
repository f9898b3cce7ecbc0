#include <talus/frame_gatherer.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace talus
{
namespace
{
constexpr double kNever_s = -std::numeric_limits<double>::infinity();
/** No scan has more: parts with so many have wrong stamps, and need no more memory. */
constexpr std::size_t kMaxPoints = 1 << 20;
}  // namespace

FrameGatherer::Parts& FrameGatherer::parts_of(std::uint32_t sensor)
{
  const auto found = std::find_if(
      parts_.begin(), parts_.end(), [&](const Parts& p) { return p.sensor == sensor; });
  if (found != parts_.end()) return *found;
  Parts& parts = parts_.emplace_back();
  parts.sensor = sensor;
  parts.newest_s = kNever_s;
  return parts;
}

void FrameGatherer::add(const Frame& frame, const Take& take)
{
  Parts& parts = parts_of(frame.sensor);
  const double apart_s = frame.stamp_s - parts.newest_s;
  const bool goes_on = apart_s > 0 && apart_s < kApart_s;
  parts.newest_s = frame.stamp_s;
  if (goes_on)
    parts.apart_s = apart_s;
  else
  {
    if (parts.count == 1) parts.apart_s = 0;  // what it sent was no part
    pass_on(parts, take);
    parts.passed_on_s = frame.stamp_s - parts.apart_s;
  }
  if (parts.apart_s == 0) return take(frame);
  append(parts, frame);
  const double lasts_s = frame.stamp_s - parts.passed_on_s + parts.apart_s / 2;
  if (lasts_s < kScan_s && parts.x_m.size() < kMaxPoints) return;
  parts.passed_on_s = frame.stamp_s;
  pass_on(parts, take);
}

void FrameGatherer::finish(const Take& take)
{
  for (Parts& parts : parts_) pass_on(parts, take);
}

void FrameGatherer::append(Parts& parts, const Frame& frame)
{
  if (frame.size && !(frame.x_m && frame.y_m && frame.z_m))
    throw std::invalid_argument("a frame with points has no x_m, y_m or z_m");
  if (parts.count++ == 0)
  {
    parts.first_s = frame.stamp_s;
    for (auto* values : {&parts.x_m, &parts.y_m, &parts.z_m, &parts.time_s}) values->clear();
    for (auto& values : parts.channels) values.clear();
    parts.scan.path.clear();
  }
  const auto copy = [&](const float* from, std::vector<float>& to)
  { to.insert(to.end(), from, from + frame.size); };
  copy(frame.x_m, parts.x_m);
  copy(frame.y_m, parts.y_m);
  copy(frame.z_m, parts.z_m);
  for (std::size_t c = 0; c < kMaxChannels; c++)
  {
    auto& to = parts.channels[c];
    if (!frame.channels[c]) continue;
    to.resize(parts.time_s.size(), std::numeric_limits<float>::quiet_NaN());  // earlier parts
    copy(frame.channels[c], to);
  }
  const bool moves = frame.time_s && frame.path.size() >= 2;
  const double later_s = frame.stamp_s - parts.first_s;
  for (std::size_t i = 0; i < frame.size; i++)
    parts.time_s.push_back(static_cast<float>(later_s) + (moves ? frame.time_s[i] : 0.0f));
  const auto go_on = [&](double time_s, const Pose& T_map_sensor)
  {
    auto& path = parts.scan.path;
    if (path.empty() || later_s + time_s > path.back().time_s)
      path.push_back({later_s + time_s, T_map_sensor});
  };
  if (!moves) go_on(0, frame.T_map_sensor);
  if (moves)
    for (const TimedPose& pose : frame.path) go_on(pose.time_s, pose.T_map_sensor);
  parts.scan.stamp_s = frame.stamp_s;
  parts.scan.T_map_sensor = frame.T_map_sensor;
  parts.scan.T_base_sensor = frame.T_base_sensor;
}

void FrameGatherer::pass_on(Parts& parts, const Take& take)
{
  if (parts.count == 0) return;
  parts.count = 0;
  Frame& scan = parts.scan;
  const double lasts_s = scan.stamp_s - parts.first_s;
  for (float& time_s : parts.time_s) time_s -= static_cast<float>(lasts_s);
  for (TimedPose& pose : scan.path) pose.time_s -= lasts_s;
  scan.sensor = parts.sensor;
  scan.x_m = parts.x_m.data();
  scan.y_m = parts.y_m.data();
  scan.z_m = parts.z_m.data();
  scan.time_s = parts.time_s.data();
  scan.size = parts.time_s.size();
  for (std::size_t c = 0; c < kMaxChannels; c++)
  {
    auto& values = parts.channels[c];
    const bool has_any = !values.empty();
    if (has_any) values.resize(scan.size, std::numeric_limits<float>::quiet_NaN());
    scan.channels[c] = has_any ? values.data() : nullptr;
  }
  take(scan);
}

FrameSequence::FrameSequence(double max_late_s) : max_late_s_(max_late_s)
{
  if (!(std::isfinite(max_late_s) && max_late_s >= 0))
    throw std::invalid_argument(
        "max_late_s is " + number_text(max_late_s) + ": must be a time of 0 s or more");
}

FrameOrder FrameSequence::next(double stamp_s, std::uint32_t sensor)
{
  if (!std::isfinite(stamp_s))
    throw std::invalid_argument("the time stamp of the frame is not finite");
  const auto known = std::find_if(
      newest_.begin(), newest_.end(), [&](const Newest& n) { return n.sensor == sensor; });
  if (known == newest_.end())
  {
    newest_.push_back({sensor, stamp_s});
    return FrameOrder::Newest;
  }
  const double before_s = known->stamp_s;
  if (stamp_s == before_s) return FrameOrder::Duplicate;
  if (stamp_s < before_s && before_s - stamp_s <= max_late_s_) return FrameOrder::Late;
  known->stamp_s = stamp_s;
  return stamp_s > before_s ? FrameOrder::Newest : FrameOrder::ClockSetBack;
}

}  // namespace talus
