#include "log_mapper.h"

#include "../common/memory_limit.h"
#include "../common/crash_context.h"

#include <mrpt/obs/CObservationVelodyneScan.h>
#include <talus/io/rawlog_reader.h>
#include <talus/mrpt/CObservationTraversability.h>
#include <talus/risk.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string_view>

namespace talus::app
{
namespace
{
/** What the backend has to say about itself is in the summary. */
class QuietLog
{
 public:
  QuietLog() : before_(std::clog.rdbuf(nullptr)) {}
  ~QuietLog()
  {
    std::clog.rdbuf(before_);
    std::clog.clear();
  }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;

 private:
  std::streambuf* before_;
};

ElevationMapper make_map(const Job& job, const Settings& s)
{
  const QuietLog quiet;
  return ElevationMapper(s.parameters, s.backend, job.threads, job.device);
}

/** What is written of every frame; all else is read at the end, and nothing is made for it before.
 */
std::vector<Layer> layers_of_every_frame(const Options& o)
{
  if (o.every == 0 && !o.rawlog_out.empty()) return CObservationTraversability::default_layers();
  if (o.every != 1) return {};
  std::vector<Layer> all;
  all.reserve(kLayerCount);
  for (int l = 0; l < kLayerCount; ++l) all.push_back(static_cast<Layer>(l));
  return all;
}

std::string percent(std::uint64_t part, std::uint64_t whole)
{
  char text[16];
  std::snprintf(
      text, sizeof text, "%.0f %%",
      whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0);
  return text;
}

std::size_t hash_of(const SensorPoints& scan)
{
  std::size_t hash = 0;
  for (const auto* coordinates : {&scan.x_m, &scan.y_m, &scan.z_m})
  {
    const std::string_view bytes(
        reinterpret_cast<const char*>(coordinates->data()), coordinates->size() * sizeof(float));
    hash = hash * 31 + std::hash<std::string_view>()(bytes);
  }
  return hash;
}

std::string quoted_list(const std::set<std::string>& names)
{
  std::string text;
  for (const auto& n : names) text += (text.empty() ? "'" : ", '") + n + "'";
  return text;
}

/** Without its namespace where that is MRPT's. */
std::string class_of(const mrpt::obs::CObservation& obs)
{
  const std::string name = obs.GetRuntimeClass()->className, usual = "mrpt::obs::";
  return name.rfind(usual, 0) == 0 ? name.substr(usual.size()) : name;
}
}  // namespace

LogMapper::LogMapper(
    const Job& job, const SourceLog& log, const Options& options, const Settings& settings,
    KeptSite* site, LabelFiles* labels)
    : job_(job),
      options_(options),
      settings_(settings),
      log_(job.log),
      source_(log),
      map_(make_map(job, settings)),
      site_(site),
      labels_(labels),
      hints_(settings.parameters, options.suggest ? hints::Effort::Much : hints::Effort::Little)
{
  map_.set_output_layers(layers_of_every_frame(options));
  run_.version = TALUS_VERSION;
  run_.log = job.log;
  run_.imported = log.notes;
  run_.backend = map_.backend_name();
  run_.threads = settings.threads;
  run_.parameters = settings.parameters;
  run_.warnings = settings.warnings;
  run_.warnings.insert(run_.warnings.end(), log.warnings.begin(), log.warnings.end());
  for (const Channel& channel : settings.parameters.channels)
    scan_.channel_names.push_back(channel.name);
  has_channel_.resize(scan_.channel_names.size());
}

io::LayerStack LogMapper::layers() const
{
  io::LayerStack stack = io::snapshot(map_);
  if (!options_.risk) return stack;
  stack.names.emplace_back("risk");
  stack.layers.push_back(risk(map_));
  return stack;
}

void LogMapper::run(const OnFrame& on_frame)
{
  const std::size_t memory_bytes = memory_for_log(source_.path);
  const auto reader = guarded(
      log_, kLookAtLog, [&] { return std::make_unique<io::RawlogReader>(source_.path); },
      memory_bytes);
  note_points(reader->description());
  poses_ = PoseSource::of_log(source_, log_, options_);
  run_.pose_source = poses_.description();
  std::size_t shown = 0;
  const auto show = [&]
  {
    if (run_.frames.size() == shown) return;
    shown = run_.frames.size();
    on_frame(*this, reader->progress());
  };
  while (const auto obs = guarded(
             log_, kLookAtLog, [&] { return reader->next(); }, memory_bytes))
    if (take(*obs)) show();
  gatherer_.finish([this](const Frame& scan) { map_scan(scan); });
  show();
  if (run_.frames.empty()) explain_no_frames();
  if (options_.suggest) return;
  if (has_rays()) add_hints();
  require_points();
  require_channels_of_log();
  if (site_) site_->finish(map_, run_, has_rays());
  if (labels_) labels_->finish();
  add_warnings();
}

bool LogMapper::take(const mrpt::obs::CObservation& obs)
{
  if (!options_.sensor.empty() && obs.sensorLabel != options_.sensor)
  {
    other_labels_.insert(obs.sensorLabel);
    return false;
  }
  if (!decode(obs)) return false;
  if (labels_) labels_->note_scan(obs, scan_);
  if (scan_.x_m.empty()) return skip("no_points", "it is empty");
  if (!note_stamp(obs))
    return skip("duplicate", "the log has it twice: same sensor, stamp and points");
  last_stamp_ = obs.timestamp;
  last_label_ = obs.sensorLabel;
  return insert(obs.sensorLabel);
}

/** The intensities of an import may be other values. Where rays tell nothing, they tell of no drops
 * either. */
void LogMapper::note_points(const std::string& description)
{
  notes_ = import::notes_from(description);
  if (notes_.pieces != import::Pieces::Scans && options_.robot_is_static)
    throw std::runtime_error(
        log_ +
        ": is the map of a whole drive, in pieces: leave out --static, or say --clouds-in sensor "
        "if it is one scan");
  if (!has_rays())
  {
    Settings without_drops = settings_;
    without_drops.parameters.sparsity_range_m = 0;
    map_ = make_map(job_, without_drops);
    map_.set_output_layers(layers_of_every_frame(options_));
    run_.parameters = without_drops.parameters;
  }
  const auto& channels = map_.parameters().channels;
  for (std::size_t c = 0; c < channels.size(); ++c)
    if (!notes_.values.empty())
      scan_.channel_names[c] = channels[c].name == notes_.values ? "intensity"
                               : channels[c].name == "intensity" ? ""
                                                                 : channels[c].name;
}

/** What the bytes of a scan mean. */
void LogMapper::scale_intensity(const mrpt::obs::CObservation& obs)
{
  if (!dynamic_cast<const mrpt::obs::CObservationVelodyneScan*>(&obs)) return;
  for (std::size_t c = 0; c < scan_.channel_names.size(); ++c)
    if (scan_.channel_names[c] == "intensity")
      for (float& value : scan_.channels[c])
        value = static_cast<float>(notes_.least + notes_.step * static_cast<double>(value));
}

bool LogMapper::decode(const mrpt::obs::CObservation& obs)
{
  try
  {
    if (points_from_observation(obs, scan_)) return scale_intensity(obs), true;
    const double stamp_s = mrpt::Clock::toDouble(obs.timestamp);
    if (!site_ || !site_->take_fix(obs, poses_.base_at(stamp_s))) ++run_.unsupported[class_of(obs)];
    return false;
  }
  catch (const std::exception& e)
  {
    return skip("undecodable", e.what());
  }
}

void LogMapper::note_way()
{
  constexpr double kApart_m = 0.1;
  constexpr std::size_t kMax = 5000;
  const cv::Point2d at(last_T_map_base_.x(), last_T_map_base_.y());
  const double step_m = last_way_.empty() ? HUGE_VAL : cv::norm(at - last_way_.back());
  if (step_m < kApart_m) return;
  if (!last_way_.empty()) driven_m_ += step_m;
  last_way_.push_back(at);
  if (last_way_.size() > kMax) last_way_.pop_front();
}

/** Frames are taken in the order of the log, each with the pose of its own time; where a clock
 * jumps back, or a scan was logged late, that is counted. False when the log repeats a scan: one
 * without a stamp may be like the one before because nothing moved. */
bool LogMapper::note_stamp(const mrpt::obs::CObservation& obs)
{
  if (obs.timestamp == INVALID_TIMESTAMP) return true;
  first_stamp_s_ = std::min(first_stamp_s_, scan_.stamp_s);
  final_stamp_s_ = std::max(final_stamp_s_, scan_.stamp_s);
  const LastScan now{scan_.stamp_s, scan_.x_m.size(), hash_of(scan_), scan_.T_base_sensor};
  const auto [last, is_first] = last_scans_.emplace(obs.sensorLabel, now);
  if (is_first) return true;
  if (now.stamp_s < last->second.stamp_s) ++run_.stamps_backwards;
  const bool repeated = now == last->second;
  last->second = now;
  return !repeated;
}

bool LogMapper::insert(const std::string& label)
{
  const auto T_map_base = poses_.base_at(scan_.stamp_s);
  if (!T_map_base) return skip("no_pose", "there is no pose within --max-gap");
  Frame frame = frame_from(scan_, *T_map_base);
  check_channels(frame);
  frame.path = poses_.sensor_path(scan_);
  try
  {
    frame.sensor = sensors_.number_of(label);
    map_.window_after(frame);  // throws for a pose that is none
    last_T_map_base_ = *T_map_base;
    if (labels_) labels_->await(frame.sensor);
    gatherer_.add(frame, [this](const Frame& scan) { map_scan(scan); });
  }
  catch (const std::invalid_argument& e)
  {
    return skip("bad_pose", e.what());
  }
  note_way();
  return true;
}

/** A scan of the log, or one that was gathered from parts. */
void LogMapper::map_scan(const Frame& scan)
{
  if (labels_) labels_->begin(scan);
  run_.frames.push_back(map_frame(scan));
  if (labels_) labels_->write(scan, label_points(map_, scan));
  const std::string& label = sensors_.labels()[scan.sensor];
  if (!scan.path.empty()) ++run_.frames_deskewed;
  ++run_.sensors[label];
  if (has_rays() || options_.suggest) hints_.add(scan, label, run_.frames.back());
}

FrameReport LogMapper::map_frame(const Frame& frame)
{
  if (options_.suggest) return {};
  return site_ ? site_->update(map_, frame) : map_.update(frame);
}

void LogMapper::add_hints()
{
  const auto& state = map_.layer(Layer::State);
  const auto known = std::count_if(state.begin(), state.end(), [](float s) { return s > 0; });
  for (auto& hint : hints_.find(static_cast<double>(known) / static_cast<double>(state.size())))
    run_.hints.push_back(std::move(hint.text));
}

bool LogMapper::skip(const std::string& reason, const std::string& why)
{
  ++run_.skipped[reason];
  first_skip_.emplace(reason, why);
  return false;
}

void LogMapper::explain_no_frames() const
{
  const std::string start = log_ + ": no scan of this log could be mapped: ";
  for (const char* reason : {"bad_pose", "undecodable", "no_points"})
    if (run_.skipped.count(reason) &&
        (reason == std::string("bad_pose") || !run_.skipped.count("no_pose")))
      throw std::runtime_error(start + first_skip_.at(reason));
  if (run_.skipped.count("no_pose") && first_stamp_s_ > final_stamp_s_)
    throw std::runtime_error(
        start +
        "its scans have no time stamps, and poses belong to times; say --static if the robot did "
        "not move");
  if (run_.skipped.count("no_pose"))
    throw std::runtime_error(start + poses_.why_no_pose(first_stamp_s_, final_stamp_s_));
  if (!run_.unsupported.empty())
  {
    std::set<std::string> classes;
    for (const auto& entry : run_.unsupported) classes.insert(entry.first);
    throw std::runtime_error(
        start + "it holds only " + quoted_list(classes) +
        ", and scans are CObservationPointCloud, CObservationVelodyneScan, "
        "CObservationRotatingScan, CObservation3DRangeScan and CObservation2DRangeScan");
  }
  if (!other_labels_.empty())
    throw std::runtime_error(
        start + "no sensor is called '" + options_.sensor + "'; this log has " +
        quoted_list(other_labels_) + ": choose one of them with --sensor");
  throw std::runtime_error(start + "it holds no observations");
}

void LogMapper::require_points() const
{
  const auto sum = io::totals_of(run_.frames);
  if (sum.accepted > 0) return;
  std::string text = log_ + ": none of its " + std::to_string(sum.in) + " points was accepted: ";
  for (int i = 0; i < kRejectCount; ++i)
    if (sum.rejected[i] > 0)
      text += percent(sum.rejected[i], sum.in) + " " + kRejectNames[i] + ", ";
  if (!run_.warnings.empty()) throw std::runtime_error(text + "warning: " + run_.warnings.front());
  if (!run_.hints.empty()) throw std::runtime_error(text + "hint: " + run_.hints.front());
  throw std::runtime_error(
      text +
      "see min_height_m, max_height_m (from the sensor upwards), min_range_m, max_range_m and "
      "window_m, which -s NAME=VALUE sets");
}

/** Of the frame of a scan. A class that is none ends the run: the log has other classes than was
 * said. */
void LogMapper::check_channels(const Frame& frame)
{
  for (std::size_t c = 0; c < has_channel_.size(); ++c)
    if (frame.channels[c]) has_channel_[c] = true;
  try
  {
    require_channels(frame, map_.parameters().channels);
  }
  catch (const std::invalid_argument& e)
  {
    throw std::runtime_error(log_ + ": " + e.what());
  }
}

void LogMapper::require_channels_of_log() const
{
  for (std::size_t c = 0; c < has_channel_.size(); ++c)
    if (!has_channel_[c])
      throw std::runtime_error(
          log_ + ": no scan of it has the values '" + map_.parameters().channels[c].name +
          "' of --channels; read are 'intensity' (of clouds, Velodyne, rotating and 2D scans that "
          "have it), 'red', 'green' and 'blue' of clouds with colours, and with MRPT 2.15 and "
          "newer "
          "all fields of clouds that are floats; talus-import --values takes others along");
}

void LogMapper::add_warnings()
{
  auto& warnings = run_.warnings;
  for (const auto& [reason, count] : run_.skipped)
    warnings.push_back(
        std::to_string(count) + (count == 1 ? " scan was" : " scans were") + " skipped (" + reason +
        "): " + first_skip_.at(reason));
  if (run_.stamps_backwards > 0)
    warnings.push_back(
        "the time stamps go back " + std::to_string(run_.stamps_backwards) +
        " times; frames were taken in the order of the log, each at the pose of its time");
}

}  // namespace talus::app
