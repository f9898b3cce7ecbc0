#include <talus/input_file.h>
#include <talus/text.h>

#include <algorithm>
#include <stdexcept>

#include "label_file.h"
#include "formats.h"

namespace talus::import
{
namespace
{
constexpr std::size_t kFloat_bytes = 4;

/** The fields that are given, else those of the data set by the name. */
std::vector<PointField> fields_of(const std::string& path, const std::vector<std::string>& given)
{
  const std::vector<std::string> kitti = {"x", "y", "z", "reflectance"},
                                 nuscenes = {"x", "y", "z", "intensity", "ring"};
  const auto& names = !given.empty() ? given : ends_with(path, ".pcd.bin") ? nuscenes : kitti;
  std::vector<PointField> fields;
  fields.reserve(names.size());
  for (const auto& name : names) fields.push_back({name, NumberType::Float32});
  return fields;
}

std::string listed(const std::vector<PointField>& fields)
{
  std::string list;
  for (const auto& field : fields) list += (list.empty() ? "" : " ") + field.name;
  return list;
}

/** What --fields may be for that count of floats a point. */
std::string example_of(std::size_t floats)
{
  std::string fields = "x,y,z";
  for (const char* more : {"intensity", "ring", "time", "other", "another"})
    if (floats > 3)
    {
      fields += std::string(",") + more;
      --floats;
    }
  return "--fields " + fields;
}

void require_count(
    const std::string& path, const std::string& bytes, const std::vector<PointField>& fields)
{
  const std::size_t point_bytes = kFloat_bytes * fields.size();
  std::size_t floats = floats_a_point(bytes, fields.size());
  const bool is_whole = bytes.size() % point_bytes == 0;
  if (floats != fields.size())
    throw std::runtime_error(
        path + ": has " + std::to_string(floats) + " floats a point, as its numbers show, not " +
        std::to_string(fields.size()) + " (" + listed(fields) +
        "). Name them in their order, for example " + example_of(floats) + ".");
  if (is_whole) return;
  throw std::runtime_error(
      path + ": has " + std::to_string(bytes.size()) + " bytes, no multiple of " +
      std::to_string(point_bytes) + ": it is cut at byte " +
      std::to_string(bytes.size() - bytes.size() % point_bytes) + ", or its points are not (" +
      listed(fields) + "), a float each. Copy it again, or name the fields that it has: " +
      example_of(fields.size() == 5 ? 6 : 5) + ".");
}

/** A label for each point, of a file beside the scan, where those are asked for. */
std::vector<std::uint32_t> labels_beside(
    const std::string& path, const std::vector<PointField>& fields, const std::string& values,
    std::size_t points)
{
  const bool is_field = std::any_of(
      fields.begin(), fields.end(), [&](const PointField& f) { return f.name == values; });
  if (is_field || !(values == kLabels || values == kSemanticKitti)) return {};
  auto labels = read_labels(path, points);
  if (values == kSemanticKitti)
    for (std::uint32_t& label : labels) label = class_of_semantickitti(label);
  return labels;
}

/** Other data read as floats has all sizes. */
void require_distances(const std::string& path, const ScanFile& scan)
{
  constexpr float kFarthest_m = 1e5F;
  for (const auto* axis : {&scan.x_m, &scan.y_m, &scan.z_m})
    for (std::size_t i = 0; i < axis->size(); ++i)
      if (!((*axis)[i] >= -kFarthest_m && (*axis)[i] <= kFarthest_m))
        throw std::runtime_error(
            path + ": point " + std::to_string(i) +
            " is more than 100 km away: its points are not floats in the order that is expected "
            "(KITTI's x y z reflectance, or --fields), or it is damaged. Compare it with its "
            "source.");
}
}  // namespace

void read_bin(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  const auto fields = fields_of(path, out.fields);
  require_count(path, bytes, fields);
  const std::size_t point_bytes = kFloat_bytes * fields.size(), count = bytes.size() / point_bytes;
  const auto labels = labels_beside(path, fields, out.values, count);
  auto with_label = fields;
  if (!labels.empty()) with_label.push_back({out.values, NumberType::UInt32});
  PointCollector points(with_label, count, path, out);
  auto places = positions_of(fields, bytes.data(), count, is_big_endian_host());
  places.push_back({reinterpret_cast<const char*>(labels.data()), sizeof labels[0], false});
  points.add_records(places, count);
  points.finish();
  require_distances(path, out);
}

}  // namespace talus::import
