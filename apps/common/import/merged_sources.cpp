#include "merged_sources.h"

#include "../crash_context.h"

#include <talus/import/kitti_poses.h>
#include <talus/number_text.h>

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

}  // namespace talus::import
