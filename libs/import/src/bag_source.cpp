#include <talus/import/scan_source.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "bag_messages.h"
#include "bag_motion.h"
#include "bag_reader.h"
#include "bag_topics.h"
#include "cdr_reader.h"
#include "formats.h"

namespace talus::import
{
namespace
{
/** For errors. */
std::string name_of(const std::vector<std::string>& paths)
{
  return paths.front() +
         (paths.size() > 1 ? " and " + std::to_string(paths.size() - 1) + " more" : "");
}

/** "(0, 0, 0.7)", several with "and". */
std::string points_text(const std::vector<std::array<double, 3>>& places)
{
  std::string text;
  for (const auto& p : places)
    text += (text.empty() ? "(" : " and (") + number_text(p[0], 4) + ", " + number_text(p[1], 4) +
            ", " + number_text(p[2], 4) + ")";
  return text;
}

/** What is known of one topic with clouds. */
struct Sensor
{
  std::vector<std::size_t> files;  //!< of the reader, that have scans of it, in their order
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  std::size_t scans = 0, late = 0, not_mounted = 0, not_timed = 0, not_stamped = 0;
  std::size_t broken_times = 0;  //!< points
  std::size_t no_returns = 0;  //!< points
  std::int64_t not_mounted_ns = 0;  //!< the first of those
  double off_s = 0;  //!< the time of recording of the first scan, after its stamp
  StampOffsets offsets;

  bool has_lost_many() const { return 10 * late > scans + late; }
};

constexpr const char* kLate =
    "are left out: their stamps are before those of the scans before them";

class BagSource : public ScanSource
{
 public:
  BagSource(const std::vector<std::string>& paths, const SourceOptions& options)
      : path_(name_of(paths)),
        options_(options),
        reader_(paths, options.partial),
        roles_(roles_of(reader_.topics(), options.topics, path_)),
        motion_(reader_, roles_, options, path_),
        sensors_(roles_.size()),
        no_returns_(motion_.no_returns())
  {
    file_.values = options.values;
    file_.scale = options.scale;
    for (const auto topic : motion_.left_out()) roles_[topic] = BagRole::None;
    std::vector<bool> wanted;
    wanted.reserve(roles_.size());
    for (const auto role : roles_) wanted.push_back(role == BagRole::Cloud);
    reader_.start(std::move(wanted));
  }

  bool next(ImportedScan& scan) override
  {
    BagMessage message;
    while (reader_.next(message))
      if (read_scan(message, scan)) return true;
    require_scans();
    return false;
  }
  double progress() const override { return reader_.progress(); }
  io::Trajectory poses() override { return motion_.poses(); }
  std::vector<std::string> remarks() const override;
  std::vector<std::string> warnings() const override;
  bool wants(SourceOptions& options) const override;

 private:
  bool read_scan(const BagMessage& message, ImportedScan& scan);
  bool place(const CloudMessage& cloud, const BagMessage& message, ImportedScan& scan);
  void require_one_file(Sensor& sensor, const BagMessage& message) const;
  void require_scans() const;
  bool is_recorded(const std::string& topic) const
  {
    const auto& topics = options_.recorded_topics;
    return options_.recorded_times ||
           std::find(topics.begin(), topics.end(), topic) != topics.end();
  }

  std::string path_;
  SourceOptions options_;
  BagReader reader_;
  std::vector<BagRole> roles_;
  BagMotion motion_;
  std::vector<Sensor> sensors_;  //!< one a topic
  std::map<std::size_t, std::vector<std::array<double, 3>>> no_returns_;  //!< where, by topic
  ScanFile file_;
};

/** False: it is left out. */
bool BagSource::read_scan(const BagMessage& message, ImportedScan& scan)
{
  try
  {
    auto cloud = read_cloud(reader_.payload(), reader_.topics()[message.topic].type);
    cloud.is_big_endian ^= motion_.is_of_other_order(message.topic);
    auto& sensor = sensors_[message.topic];
    file_.no_return_points = no_returns_[message.topic];
    collect_points(cloud, reader_.place(), file_, most_points(reader_));
    sensor.no_returns += file_.no_returns;
    return place(cloud, message, scan);
  }
  catch (const CdrError& e)
  {
    throw std::runtime_error(reader_.place() + " " + e.what() + ". Copy the bag again.");
  }
}

/** Its time and mounting. The times of points are since the stamp of the sensor, or of its clock; a
 * scan is not recorded before its last point was measured. */
bool BagSource::place(const CloudMessage& cloud, const BagMessage& message, ImportedScan& scan)
{
  auto& sensor = sensors_[message.topic];
  require_one_file(sensor, message);
  const bool is_stamped = cloud.header.stamp_ns != 0;
  const auto stated_ns = is_stamped ? cloud.header.stamp_ns : message.log_time_ns;
  const auto& topic = reader_.topics()[message.topic].name;
  const auto& clock = motion_.clock(message.topic);
  const bool has_times = !file_.time.empty();
  sensor.broken_times += clock.leave_out_broken(file_);
  auto times_s = clock.times_since(seconds(stated_ns), file_);
  sensor.not_timed += has_times && times_s.empty() ? 1 : 0;
  float last_s = 0;
  for (const float time_s : times_s) last_s = std::max(last_s, time_s);
  const auto stamp_ns = is_recorded(topic) || !is_stamped
                            ? message.log_time_ns - std::llround(1e9 * static_cast<double>(last_s))
                            : stated_ns;
  sensor.not_stamped += is_stamped ? 0 : 1;
  if (is_stamped) sensor.offsets.add(message.log_time_ns, stamp_ns, static_cast<double>(last_s));
  if (stamp_ns < sensor.last_ns) return ++sensor.late, false;
  const auto* given = options_.mounting_of(topic);
  const auto T_base_sensor = given ? std::optional<mrpt::poses::CPose3D>(*given)
                                   : motion_.T_base_sensor(cloud.header.frame, stamp_ns);
  if (!T_base_sensor)
  {
    if (sensor.not_mounted++ == 0) sensor.not_mounted_ns = stamp_ns;
    return false;
  }
  if (sensor.scans++ == 0) sensor.off_s = seconds(stamp_ns - stated_ns);
  sensor.last_ns = stamp_ns;
  scan.sensor_label = topic;
  scan.T_base_sensor = *T_base_sensor;
  scan.time_s = seconds(stamp_ns);
  scan.point_time_s = std::move(times_s);
  take_points(file_, scan);
  return true;
}

/** Parts of a recording follow each other. What two sensors see must not get mixed up. */
void BagSource::require_one_file(Sensor& sensor, const BagMessage& message) const
{
  const auto file = reader_.file();
  auto& files = sensor.files;
  if (!files.empty() && files.back() == file) return;
  if (std::find(files.begin(), files.end(), file) != files.end())
    throw std::runtime_error(
        reader_.path_of(files.back()) + " and " + reader_.path_of(file) + ": both have scans of " +
        reader_.topics()[message.topic].name +
        " at the same time. Import them one by one if they are of two robots; take one of them "
        "away if it is a copy.");
  files.push_back(file);
}

/** Without a single scan there is more to say than how many are left out. */
void BagSource::require_scans() const
{
  std::string names;
  bool is_any = false;
  for (std::size_t i = 0; i < sensors_.size(); ++i)
  {
    const auto& sensor = sensors_[i];
    const auto& topic = reader_.topics()[i].name;
    is_any = is_any || sensor.scans + sensor.not_mounted > 0;
    if (roles_[i] == BagRole::Cloud) names += (names.empty() ? "" : ", ") + topic.substr(0, 100);
    if (sensor.scans > 0 || sensor.not_mounted == 0) continue;
    throw std::runtime_error(
        path_ + ": TF has the mounting of " + topic + " at the time of none of its " +
        std::to_string(sensor.not_mounted) + " scans, of which the first is of " +
        number_text(seconds(sensor.not_mounted_ns), 13) +
        " s. If its sensor has a clock of its own, pass --recorded-times: scans then have the time "
        "of recording; --mount " +
        topic + "=X,Y,Z,YAW,PITCH,ROLL gives the mounting without TF.");
  }
  if (is_any) return;
  std::string why;
  for (const auto& remark : reader_.remarks()) why += "; " + remark;
  throw std::runtime_error(path_ + ": holds not a single message of " + names + why + ".");
}

std::vector<std::string> BagSource::remarks() const
{
  auto all = reader_.remarks();
  const auto of_motion = motion_.remarks();
  all.insert(all.end(), of_motion.begin(), of_motion.end());
  const auto count = [&all](std::size_t scans, const std::string& topic, const char* what)
  {
    if (scans > 0) all.push_back(topic + ": " + std::to_string(scans) + " scans " + what);
  };
  for (std::size_t i = 0; i < sensors_.size(); ++i)
  {
    const auto& sensor = sensors_[i];
    const auto& topic = reader_.topics()[i].name;
    if (!sensor.has_lost_many()) count(sensor.late, topic, kLate);
    count(sensor.not_mounted, topic, "are left out: TF has no mounting at their time");
    const auto& clock = motion_.clock(i);
    if (const auto said = clock.remark(); !said.empty() && sensor.scans > 0)
      all.push_back(topic + ": " + said);
    if (clock.is_understood())
      count(
          sensor.not_timed, topic,
          "are read without times of points: these are far from those of the scans");
    if (sensor.broken_times > 0)
      all.push_back(
          topic + ": " + std::to_string(sensor.broken_times) +
          " points are left out: their times are far from those of their scans");
    count(
        sensor.not_stamped, topic, "have no stamp: they have the time at which they were recorded");
    if (motion_.is_of_other_order(i))
      all.push_back(
          topic +
          ": is_bigendian is wrong in its clouds: only in the other order of bytes do its "
          "points have distances of a scanner, and it is read in that");
    if (sensor.no_returns > 0)
      all.push_back(
          topic + ": " + std::to_string(sensor.no_returns) +
          " points are left out: in each of the first scans some lie at exactly " +
          points_text(no_returns_.at(i)) + ", as rays without a return");
    if (is_recorded(topic))
      count(
          sensor.scans, topic,
          ("have the time of recording, " + fixed_text(sensor.off_s, 3) +
           " s after the stamp of the first" +
           (options_.recorded_topics.empty() ? ""
                                             : ", as their stamps are of another clock than the "
                                               "poses (--stamped-times keeps the stamps)"))
              .c_str());
  }
  return all;
}

std::vector<std::string> BagSource::warnings() const
{
  std::vector<std::string> all;
  for (std::size_t i = 0; i < sensors_.size(); ++i)
  {
    const auto& sensor = sensors_[i];
    const std::string topic = reader_.topics()[i].name + ": ";
    if (const auto clock = sensor.offsets.with(motion_.pose_offsets()); !clock.warning.empty())
      all.push_back(
          topic + clock.warning +
          (options_.recorded_times
               ? ". --poses FILE gives poses with the times of recording"
               : ". --recorded-times takes the times of recording for the scans"));
    if (sensor.has_lost_many())
      all.push_back(
          topic + std::to_string(sensor.late) + " of " +
          std::to_string(sensor.scans + sensor.late) + " scans " + kLate);
  }
  return all;
}

/** The recorder's clock, where that of a sensor or of the poses is another one. */
bool BagSource::wants(SourceOptions& options) const
{
  const bool is_asked_for = options_.recorded_times && options_.recorded_topics.empty();
  if (is_asked_for || options_.stamped_times) return false;
  bool wants = false;
  for (std::size_t i = 0; i < sensors_.size(); ++i)
  {
    const auto clock = sensors_[i].offsets.with(motion_.pose_offsets());
    if (!clock.is_clock) continue;
    if (!options_.recorded_topics.empty())
      throw std::runtime_error(
          path_ + ": " + reader_.topics()[i].name + ": " + clock.warning +
          ". --poses FILE gives poses with the clock of the scans; --stamped-times takes the "
          "stamps "
          "as they are.");
    wants = true;
    options.recorded_topics.push_back(reader_.topics()[i].name);
    options.recorded_times |= !clock.poses_are_recorded;
  }
  return wants;
}
}  // namespace

std::unique_ptr<ScanSource> open_bag_source(
    const std::vector<std::string>& paths, const SourceOptions& options)
{
  return std::make_unique<BagSource>(paths, options);
}

}  // namespace talus::import
