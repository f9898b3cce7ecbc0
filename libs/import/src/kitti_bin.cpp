#include <talus/input_file.h>

#include <array>
#include <stdexcept>

#include "scan_files.h"

namespace talus::import
{
namespace
{
constexpr std::size_t kNumbers = 4, kPoint_bytes = 16;

bool ends_with(const std::string& text, const std::string& ending)
{
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

void require_kitti(const std::string& path, std::size_t bytes)
{
  if (ends_with(path, ".pcd.bin"))
    throw std::runtime_error(
        path +
        ": is a scan of nuScenes, of five floats a point. Write the first four of each "
        "(x y z intensity) into .bin files.");
  if (bytes % kPoint_bytes != 0)
    throw std::runtime_error(
        path + ": has " + std::to_string(bytes) + " bytes, no multiple of " +
        std::to_string(kPoint_bytes) + ": it is cut at byte " +
        std::to_string(bytes - bytes % kPoint_bytes) +
        ", or no scan of KITTI's (x y z reflectance, a float each). Copy it again.");
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
            " is more than 100 km away: this is no scan of KITTI's (x y z reflectance, a float "
            "each), or it is damaged. Compare it with its source.");
}
}  // namespace

void read_kitti_bin(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  require_kitti(path, bytes.size());
  PointCollector points(
      {{"x"}, {"y"}, {"z"}, {"reflectance"}}, bytes.size() / kPoint_bytes, path, out);
  const bool swapped = is_big_endian_host();
  for (std::size_t at = 0; at < bytes.size(); at += kPoint_bytes)
  {
    std::array<double, kNumbers> values{};
    for (std::size_t k = 0; k < kNumbers; ++k)
      values[k] = number_at(bytes.data() + at + 4 * k, NumberType::Float32, swapped);
    points.add(values.data());
  }
  require_distances(path, out);
}

}  // namespace talus::import
