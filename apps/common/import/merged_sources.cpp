#include "merged_sources.h"

#include "../crash_context.h"
#include "../memory_limit.h"

#include <talus/import/kitti_poses.h>
#include <talus/input_file.h>
#include <talus/io/atomic_file.h>
#include <talus/number_text.h>

#include <cstdint>
#include <stdexcept>
#include <utility>

namespace talus::import
{
namespace
{
/** What a wrong file may lead astray. */
template <class F>
auto watched(const std::string& path, const F& work)
{
  return app::guarded(path, app::kCompareWithSource, work);
}
/** A switch that does nothing is a mistake. */
void require_no_switch_of_bags(const SourceOptions& o, const std::string& path)
{
  std::string name;
  if (!o.topics.empty()) name = "--topic";
  if (!o.base_frame.empty()) name = "--base-frame";
  if (!o.map_frame.empty()) name = "--map-frame";
  if (o.recorded_times) name = "--recorded-times";
  if (o.stamped_times) name = "--stamped-times";
  if (o.partial) name = "--partial";
  if (!name.empty())
    throw std::runtime_error(
        path + ": is no ROS 2 bag, and " + name + " is for bags. Leave it away.");
}

bool is_simplemap(const std::string& path)
{
  return path.find(".simplemap", path.rfind('/') + 1) != std::string::npos;
}

std::string text_of(const io::Trajectory& trajectory)
{
  std::string text = "# t[s] x[m] y[m] z[m] qx qy qz qw of the base in the map\n";
  for (const auto& entry : trajectory.entries()) text += io::tum_line(entry);
  return text;
}

WrittenPoses measured(const io::Trajectory& trajectory, const std::string& source)
{
  WrittenPoses written;
  const auto& entries = trajectory.entries();
  written.count = entries.size();
  written.source = source;
  if (entries.empty()) return written;
  written.first_s = entries.front().time_s;
  written.last_s = entries.back().time_s;
  for (std::size_t i = 1; i < entries.size(); ++i)
    written.length_m += entries[i].T_map_base.distanceTo(entries[i - 1].T_map_base);
  return written;
}
}  // namespace

MergedSources::MergedSources(const std::vector<std::string>& paths, const SourceOptions& options)
{
  // Those of KITTI's camera are turned by the first source.
  SourceOptions of_rest = options;
  of_rest.own_poses = options.poses.empty() || !is_kitti_poses(options.poses);
  SourceOptions of_first = options;
  of_first.is_only_source = of_rest.is_only_source = paths.size() == 1;
  bool has_bags = false;
  const auto inputs = inputs_of(paths);
  sources_.reserve(inputs.size());
  for (const Input& input : inputs)
  {
    has_bags |= input.is_bag();
    Source source;
    source.path = input.paths.front();
    const auto& its_options = sources_.empty() ? of_first : of_rest;
    source.scans = watched(source.path, [&] { return open_scan_source(input, its_options); });
    sources_.push_back(std::move(source));
    read(sources_.back());
  }
  if (!has_bags) require_no_switch_of_bags(options, paths.front());
}

void MergedSources::read(Source& source)
{
  source.has_pending = watched(source.path, [&] { return source.scans->next(source.pending); });
}

void MergedSources::require_one_source(const Source& source)
{
  LastOfLabel& last = last_[source.pending.sensor_label];
  const double time_s = source.pending.time_s;
  if (last.source && last.source != &source)
  {
    last.ended.insert(last.source);
    if (last.ended.count(&source) || time_s <= last.time_s)
      throw std::runtime_error(
          source.path + " and " + last.source->path + ": both have scans of '" +
          source.pending.sensor_label + "' at the same time (" + number_text(time_s, 16) +
          " s). Rename one of the folders if they are two sensors; give the folder, not its files, "
          "if they are one.");
  }
  last.source = &source;
  last.time_s = time_s;
}

bool MergedSources::next(ImportedScan& scan)
{
  Source* earliest = nullptr;
  for (Source& source : sources_)
    if (source.has_pending && (!earliest || source.pending.time_s < earliest->pending.time_s))
      earliest = &source;
  if (!earliest) return false;
  require_one_source(*earliest);
  std::swap(scan, earliest->pending);
  read(*earliest);
  return true;
}

double MergedSources::progress() const
{
  double sum = 0;
  for (const Source& source : sources_) sum += source.scans->progress();
  return sum / static_cast<double>(sources_.size());
}

io::Trajectory MergedSources::poses(std::string& path)
{
  for (Source& source : sources_)
    if (auto poses = watched(source.path, [&] { return source.scans->poses(); }); !poses.empty())
    {
      path = source.path;
      return poses;
    }
  return {};
}

std::vector<std::string> MergedSources::remarks() const
{
  std::vector<std::string> all;
  for (const Source& source : sources_)
  {
    const auto remarks = source.scans->remarks();
    all.insert(all.end(), remarks.begin(), remarks.end());
  }
  return all;
}

std::vector<std::string> MergedSources::warnings() const
{
  std::vector<std::string> all;
  for (const Source& source : sources_)
    for (auto& warning : source.scans->warnings()) all.push_back(std::move(warning));
  return all;
}

bool MergedSources::wants(SourceOptions& options) const
{
  bool wants = false;
  for (const Source& source : sources_) wants |= source.scans->wants(options);
  return wants;
}

WrittenPoses write_poses(
    const std::string& tum, const SourceOptions& options, MergedSources& sources)
{
  const std::string& poses = options.poses;
  constexpr std::uint64_t kMax_bytes = std::uint64_t{1} << 30;
  if (!poses.empty() && !options.poses_of_sensor && !is_kitti_poses(poses))
  {
    const auto trajectory = app::guarded(
        poses, app::kCompareWithSource, [&] { return io::Trajectory::load(poses); },
        app::memory_for_log(poses));
    std::string ignored;
    const auto placed = sources.poses(ignored);  // at other times where the file counts scans
    const bool is_counted =
        !placed.empty() && placed.entries().front().time_s != trajectory.entries().front().time_s;
    io::write_file(
        tum, is_counted || is_simplemap(poses) ? text_of(is_counted ? placed : trajectory)
                                               : read_input_file(poses, "trajectory", kMax_bytes));
    return measured(is_counted ? placed : trajectory, poses);
  }
  std::string source;
  const auto trajectory = sources.poses(source);
  if (!poses.empty()) source = poses;
  if (trajectory.empty() && !poses.empty())
    throw std::runtime_error(
        poses +
        ": has poses of KITTI's camera; they go with a folder of scans that has a "
        "calib.txt. Pass poses of the base, as TUM text.");
  if (!trajectory.empty()) io::write_file(tum, text_of(trajectory));
  return measured(trajectory, source);
}

}  // namespace talus::import
