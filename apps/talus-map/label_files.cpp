#include "label_files.h"

#include "../common/output_folder.h"

#include <mrpt/core/format.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <talus/io/atomic_file.h>
#include <talus/io/palette.h>
#include <talus/mrpt/CDualElevationMap.h>

#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace fs = std::filesystem;

namespace talus::app
{
namespace
{
/** Four bytes a number, the lowest first. */
std::string bytes_of(const PointLabel* labels, std::size_t size)
{
  std::string bytes;
  bytes.reserve(4 * size);
  for (std::size_t i = 0; i < size; ++i)
    for (const unsigned shift : {0U, 8U, 16U, 24U})
      bytes += static_cast<char>(static_cast<std::uint32_t>(labels[i]) >> shift & 0xFFU);
  return bytes;
}

std::string table_of(const std::array<std::uint64_t, kPointLabelCount>& counts)
{
  const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  std::string names, colours, shares;
  for (std::size_t i = 0; i < kPointLabelCount; ++i)
  {
    const io::Rgb& rgb = io::palette::kLabels[i].rgb;
    const double share = all ? static_cast<double>(counts[i]) / static_cast<double>(all) : 0.0;
    names += mrpt::format("  %zu: \"%s\"\n", i, kPointLabelNames[i]);
    colours += mrpt::format("  %zu: [%d, %d, %d]\n", i, rgb[2], rgb[1], rgb[0]);
    shares += mrpt::format("  %zu: %.6f\n", i, share);
  }
  return "# What the map says of each point; written by talus-map --labels.\nlabels:\n" + names +
         "color_map: # blue, green, red\n" + colours +
         "content: # of the points that were mapped\n" + shares;
}
}  // namespace

void require_no_foreign_labels(const std::string& folder)
{
  std::error_code none;
  const fs::path to(folder);
  if (!fs::is_directory(to, none) || fs::exists(to / kLabelTable, none)) return;
  for (const auto& entry : fs::directory_iterator(to, none))
    if (entry.path().extension() == ".label")
      throw std::runtime_error(
          "--labels " + folder + ": has labels that talus-map did not write, such as " +
          entry.path().filename().string() + "; give another folder");
}

LabelFiles::LabelFiles(std::string folder, LabelsAs as) : folder_(std::move(folder))
{
  if (as == LabelsAs::Rawlog)
    log_ = std::make_unique<io::PackedLog>((fs::path(folder_) / kLabelledLog).string());
}
LabelFiles::~LabelFiles() = default;

std::string LabelFiles::path_of(std::size_t scan) const
{
  return (fs::path(folder_) / mrpt::format("%06zu.label", scan)).string();
}

void LabelFiles::note_scan(const mrpt::obs::CObservation& obs, const SensorPoints& points)
{
  last_ = {sizes_.size(), points.x_m.size(), obs.timestamp, obs.sensorLabel, points.T_base_sensor};
  sizes_.push_back(static_cast<std::uint32_t>(last_.size));
  written_.push_back(false);
}

void LabelFiles::await(std::uint32_t sensor) { waiting_[sensor].push_back(last_); }

void LabelFiles::begin(const Frame& scan)
{
  begun_.clear();
  auto& waiting = waiting_[scan.sensor];
  for (std::size_t size = 0; size < scan.size && !waiting.empty(); size += begun_.back().size)
  {
    begun_.push_back(std::move(waiting.front()));
    waiting.pop_front();
  }
}

void LabelFiles::write(const Frame& scan, const std::vector<PointLabel>& labels)
{
  std::size_t first = 0;
  for (const Part& part : begun_)
  {
    write_part(part, scan, labels, first);
    first += part.size;
  }
  for (const PointLabel label : labels) ++counts_[static_cast<std::size_t>(label)];
}

void LabelFiles::write_part(
    const Part& part, const Frame& scan, const std::vector<PointLabel>& labels, std::size_t first)
{
  written_[part.scan] = true;
  if (!log_) return io::write_file(path_of(part.scan), bytes_of(labels.data() + first, part.size));
  const auto of = [&](const float* from)
  { return std::vector<float>(from + first, from + first + part.size); };
  SensorPoints points;
  points.x_m = of(scan.x_m);
  points.y_m = of(scan.y_m);
  points.z_m = of(scan.z_m);
  const auto begin = labels.begin() + static_cast<std::ptrdiff_t>(first);
  mrpt::obs::CObservationPointCloud obs;
  obs.timestamp = part.stamp;
  obs.sensorLabel = part.sensor_label;
  obs.sensorPose = part.T_base_sensor;
  obs.pointcloud = labelled_cloud(points, {begin, begin + static_cast<std::ptrdiff_t>(part.size)});
  log_->write(obs);
}

void LabelFiles::finish()
{
  if (log_) log_->close();
  for (std::size_t scan = 0; scan < sizes_.size() && !log_; ++scan)
    if (!written_[scan])
    {
      const std::vector<PointLabel> none(sizes_[scan], PointLabel::NotTaken);
      io::write_file(path_of(scan), bytes_of(none.data(), none.size()));
    }
  io::write_file((fs::path(folder_) / kLabelTable).string(), table_of(counts_));
}

}  // namespace talus::app
