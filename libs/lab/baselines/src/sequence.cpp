#include <talus/baselines/sequence.h>

namespace talus::baselines
{
namespace
{
constexpr double kFirstStamp_s = 1700000000.0;
}

Frame ScanFrame::view() const
{
  Frame f;
  f.stamp_s = stamp_s;
  f.T_map_sensor = T_map_sensor;
  f.T_base_sensor = T_base_sensor;
  f.sensor = sensor;
  f.x_m = x_m.data();
  f.y_m = y_m.data();
  f.z_m = z_m.data();
  f.size = x_m.size();
  return f;
}

void add_sensor(Sequence& sequence, const std::string& name)
{
  const std::string all = " + " + sequence.sensor + " + ";
  if (all.find(" + " + name + " + ") != std::string::npos) return;
  sequence.sensor += (sequence.sensor.empty() ? "" : " + ") + name;
}

Sequence simulate(
    const sim::World& world, const sim::Drive& drive,
    const std::function<void(int done, int total)>& progress)
{
  Sequence sequence;
  sequence.name = world.name;
  for (std::size_t i = 0; i < world.sensors.size(); ++i)
    add_sensor(sequence, drive.scanner(i).name);
  for (int i = 0; i < drive.frames(); ++i)
  {
    sim::Scan scan = drive.scan(i);
    ScanFrame f;
    f.time_s = drive.time_s(i);
    f.stamp_s = kFirstStamp_s + f.time_s;
    f.T_base_sensor = drive.T_base_sensor(i);
    f.sensor = static_cast<std::uint32_t>(drive.sensor(i));
    f.T_map_sensor = sim::compose(drive.T_map_base_noisy(i), *f.T_base_sensor);
    f.T_true = sim::compose(drive.T_map_base(i), *f.T_base_sensor);
    f.x_m = std::move(scan.x_m);
    f.y_m = std::move(scan.y_m);
    f.z_m = std::move(scan.z_m);
    sequence.frames.push_back(std::move(f));
    if (progress) progress(i + 1, drive.frames());
  }
  return sequence;
}

}  // namespace talus::baselines
