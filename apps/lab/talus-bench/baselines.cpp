#include <malloc.h>
#include <talus/baselines/rivals.h>
#include <talus/site/site_geotiff.h>
#include <talus/site/site_mapper.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "baselines.h"
#include "measure.h"

namespace fs = std::filesystem;

namespace talus::bench
{
namespace
{
constexpr int kWarm = 3, kTimed = 12;

/** Median seconds of a frame; `with_read`: until its surfaces and traversability are there. */
double time_method(const char* name, bool with_read, const Setting& s)
{
  const auto method = talus::baselines::make_method(name, parameters(s));
  std::vector<double> seconds;
  for (int i = 0; i < kWarm + kTimed; i++)
  {
    Frame frame = scan_at(s, i).frame();
    frame.stamp_s = 0.1 * i;
    const double before = process_cpu_s();
    method->update(frame);
    if (with_read) method->read();
    if (i >= kWarm) seconds.push_back(process_cpu_s() - before);
  }
  return quantile(seconds, 0.5);
}

constexpr std::size_t kPoints = 14400;
constexpr double kRoad_m = 16, kStep_m = 0.4;
constexpr int kDriveFrames = 250;
constexpr double kMB = 1024 * 1024;

double heap_MB()
{
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / kMB;
}

/** Removed with all that is in it. */
class ScratchFolder
{
 public:
  ScratchFolder()
  {
    std::string name = (fs::temp_directory_path() / "talus-bench.XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot make this folder");
    path_ = name;
  }
  ~ScratchFolder()
  {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::vector<Scan> road() { return make_road(kPoints, kRoad_m / 2, kRoad_m, kStep_m); }

/** Without what ends outside of talus's window. */
std::vector<Scan> road_within_window(const Parameters& p)
{
  std::vector<Scan> scans = road();
  const auto half_m = static_cast<float>(p.window_m / 2 - p.resolution_m);
  for (Scan& scan : scans)
    for (std::size_t i = 0; i < scan.x_m.size(); ++i)
      if (std::abs(scan.x_m[i]) > half_m || std::abs(scan.y_m[i]) > half_m) scan.x_m[i] = NAN;
  return scans;
}

/** Calls update(frame) for the frames of the drive; mean processor time of a frame [s]. */
template <class Update>
double drive(const std::vector<Scan>& scans, const Update& update)
{
  const double before_s = process_cpu_s();
  for (int i = 0; i < kDriveFrames; ++i)
  {
    Frame frame = scans[static_cast<std::size_t>(i) % scans.size()].frame();
    frame.stamp_s = 0.1 * i;
    frame.T_map_sensor.m[3] = kStep_m * i;
    update(frame);
  }
  return (process_cpu_s() - before_s) / kDriveFrames;
}

WholeCost talus_whole()
{
  const Parameters p;
  const std::vector<Scan> scans = road();
  const ScratchFolder folder;
  WholeCost cost;
  const double before_MB = heap_MB();
  site::Site site(p.resolution_m, std::size_t{512} << 20, folder.path().string());
  site::SiteMapper mapper(site);
  ElevationMapper map(p, Backend::Cpu, 1);
  map.set_output_layers({Layer::Traversability, Layer::Elevation});
  cost.frame_s = drive(scans, [&](const Frame& frame) { mapper.update(map, frame); });
  cost.memory_MB = heap_MB() - before_MB;
  mapper.keep_window(map);
  mapper.look_back(map);
  const fs::path file = folder.path() / "site.tif";
  site::write_site(file.string(), site, 0);
  cost.file_MB = static_cast<double>(fs::file_size(file)) / kMB;
  return cost;
}

WholeCost octomap_whole(const std::vector<Scan>& scans)
{
  const Parameters p;
  const ScratchFolder folder;
  WholeCost cost;
  const double before_MB = heap_MB();
  baselines::OctoMapMethod octomap(p);
  cost.frame_s = drive(scans, [&](const Frame& frame) { octomap.update(frame); });
  cost.memory_MB = heap_MB() - before_MB;
  octomap.map().saveMetricMapRepresentationToFile((folder.path() / "map").string());
  for (const fs::directory_entry& file : fs::directory_iterator(folder.path()))
    if (file.path().extension() == ".bt")
      cost.file_MB = static_cast<double>(file.file_size()) / kMB;
  return cost;
}
}  // namespace

std::vector<Baseline> baselines()
{
  const auto timed = [](const char* method, bool with_read)
  { return [=](const Setting& s) { return time_method(method, with_read, s); }; };
  return {
      {"octomap_insert", timed("octomap", false)},
      {"octomap_insert_and_read", timed("octomap", true)},
      {"heightgrid_insert", timed("heightgrid", false)},
      {"heightgrid_insert_and_judge", timed("heightgrid", true)},
      {"kalman_insert_and_judge", timed("highest", true)}};
}

std::vector<WholeDrive> whole_drives()
{
  return {
      {"talus", talus_whole},
      {"octomap", [] { return octomap_whole(road()); }},
      {"octomap/within_the_window", [] { return octomap_whole(road_within_window({})); }}};
}

}  // namespace talus::bench
