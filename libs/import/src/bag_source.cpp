#include "bag_source.h"

#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "bag_messages.h"
#include "bag_motion.h"
#include "bag_reader.h"
#include "bag_topics.h"
#include "cdr_reader.h"

namespace talus::import
{
namespace
{
/** What is known of one topic with clouds. */
struct Sensor
{
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  std::size_t scans = 0, late = 0, not_mounted = 0, not_timed = 0, not_stamped = 0;
  std::optional<double> time_unit_s;  //!< of its points
};

class BagSource : public ScanSource
{
 public:
  BagSource(const std::string& path, const SourceOptions& options)
      : reader_(path),
        roles_(roles_of(reader_.topics(), options.topics, path)),
        motion_(reader_, roles_, options, path),
        mountings_(options.mountings),
        sensors_(roles_.size())
  {
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
    return false;
  }
  double progress() const override { return reader_.progress(); }
  io::Trajectory poses() override { return motion_.poses(); }
  std::vector<std::string> remarks() const override;

 private:
  bool read_scan(const BagMessage& message, ImportedScan& scan);
  void fill(ImportedScan& scan, Sensor& sensor, std::int64_t stamp_ns);

  BagReader reader_;
  std::vector<BagRole> roles_;
  BagMotion motion_;
  std::map<std::string, mrpt::poses::CPose3D> mountings_;  //!< given ones, by topic
  std::vector<Sensor> sensors_;  //!< one a topic
  ScanFile file_;
};

/** False: it is left out. */
bool BagSource::read_scan(const BagMessage& message, ImportedScan& scan)
{
  auto& sensor = sensors_[message.topic];
  CloudMessage cloud;
  try
  {
    cloud = read_cloud(reader_.payload());
    collect_points(cloud, reader_.place(), file_);
  }
  catch (const CdrError& e)
  {
    throw std::runtime_error(reader_.place() + " " + e.what() + ". Copy the bag again.");
  }
  sensor.not_stamped += cloud.header.stamp_ns == 0 ? 1 : 0;
  const auto stamp_ns = cloud.header.stamp_ns == 0 ? message.log_time_ns : cloud.header.stamp_ns;
  if (stamp_ns < sensor.last_ns) return ++sensor.late, false;
  const auto& topic = reader_.topics()[message.topic].name;
  const auto given = mountings_.find(topic);
  const auto T_base_sensor = given == mountings_.end()
                                 ? motion_.T_base_sensor(cloud.header.frame, stamp_ns)
                                 : std::optional<mrpt::poses::CPose3D>(given->second);
  if (!T_base_sensor) return ++sensor.not_mounted, false;
  sensor.last_ns = stamp_ns;
  ++sensor.scans;
  scan.sensor_label = topic;
  scan.T_base_sensor = *T_base_sensor;
  fill(scan, sensor, stamp_ns);
  return true;
}

void BagSource::fill(ImportedScan& scan, Sensor& sensor, std::int64_t stamp_ns)
{
  scan.time_s = static_cast<double>(stamp_ns) * 1e-9;
  if (!sensor.time_unit_s && !file_.time.empty()) sensor.time_unit_s = time_unit_s(file_);
  scan.point_time_s = times_since(scan.time_s, file_, sensor.time_unit_s.value_or(1));
  sensor.not_timed += scan.point_time_s.size() == file_.time.size() ? 0 : 1;
  take_points(file_, scan);
}

std::vector<std::string> BagSource::remarks() const
{
  auto all = motion_.remarks();
  const auto count = [&all](std::size_t scans, const std::string& topic, const char* what)
  {
    if (scans > 0) all.push_back(topic + ": " + std::to_string(scans) + " scans " + what);
  };
  for (std::size_t i = 0; i < sensors_.size(); ++i)
  {
    const auto& [last_ns, scans, late, not_mounted, not_timed, not_stamped, unit_s] = sensors_[i];
    const auto& topic = reader_.topics()[i].name;
    count(late, topic, "are left out: their stamps are before those of the scans before them");
    count(not_mounted, topic, "are left out: TF does not tell the mounting at their time");
    count(not_timed, topic, "are read without times of points: these fit no unit and no beginning");
    count(not_stamped, topic, "have no stamp: they have the time at which they were recorded");
  }
  return all;
}
}  // namespace

std::unique_ptr<ScanSource> open_bag(const std::string& path, const SourceOptions& options)
{
  return std::make_unique<BagSource>(path, options);
}

}  // namespace talus::import
