#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/number_text.h>
#include <yaml-cpp/yaml.h>

#include "close_islands.h"
#include "needed_layer.h"

#include <algorithm>
#include <filesystem>

namespace talus::formats
{
namespace
{
// As map_server reads them: a pixel p is occupied with (255 - p) / 255. 205 is unknown to it only
// where what is free has to be below 0.196.
constexpr uchar kFree = 254, kOccupied = 0, kUnknown = 205;
constexpr const char* kFreeBelow = "0.196";
constexpr const char* kOccupiedAbove = "0.65";
constexpr int kWorstFree =
    91;  //!< the darkest pixel that is not occupied: (255 - 91) / 255 = 0.643

/** Gray and alpha of a cell. */
cv::Vec4b scaled(Kind kind, float traversability)
{
  if (kind == Kind::Unknown) return {kUnknown, kUnknown, kUnknown, 0};
  const float t = std::clamp(traversability, 0.0F, 1.0F);
  const uchar p = kind == Kind::Blocked
                      ? kOccupied
                      : static_cast<uchar>(kWorstFree + std::lround((kFree - kWorstFree) * t));
  return {p, p, p, 255};
}

/** Some rows at once: of a large map they are as large as the map. */
void write_pgm(const std::string& path, const io::LayerStack& map, const Kinds& kinds)
{
  constexpr std::size_t kAtOnce = 1 << 20;
  io::AtomicFile file(path);
  std::string bytes =
      "P5\n" + std::to_string(map.cells_x) + " " + std::to_string(map.cells_y) + "\n255\n";
  for (int iy = map.cells_y - 1; iy >= 0; --iy)  // its first row is the northernmost
  {
    for (int ix = 0; ix < map.cells_x; ++ix)
    {
      const Kind kind = kinds[static_cast<std::size_t>(iy) * map.cells_x + ix];
      bytes += static_cast<char>(
          kind == Kind::Unknown ? kUnknown
          : kind == Kind::Free  ? kFree
                                : kOccupied);
    }
    if (bytes.size() < kAtOnce && iy > 0) continue;
    file.write(bytes);
    bytes.clear();
  }
  file.commit();
}

cv::Mat4b picture_of(const MapStrips& map, const Kinds& kinds)
{
  const io::LayerStack& frame = map.frame();
  cv::Mat4b picture(frame.cells_y, frame.cells_x);
  map.for_each(
      [&](const Strip& strip)
      {
        const auto& t = needed_layer(strip.map, Layer::Traversability);
        const std::size_t before = static_cast<std::size_t>(strip.first_row) * frame.cells_x;
        for_each_cell(
            strip,
            [&](std::size_t i, int ix, int iy) {
              picture(frame.cells_y - 1 - strip.first_row - iy, ix) =
                  scaled(kinds[before + i], t[i]);
            });
      });
  return picture;
}

/** By yaml-cpp, as a name may have characters that mean something. */
std::string yaml_of(const io::LayerStack& map, const std::string& picture, RosMode mode)
{
  YAML::Emitter yaml;
  const auto put = [&yaml](const char* key, const std::string& value)
  { yaml << YAML::Key << key << YAML::Value << value; };
  yaml << YAML::BeginMap;
  put("image", picture);
  put("mode", mode == RosMode::Scale ? "scale" : "trinary");
  put("resolution", number_text(map.resolution_m));
  yaml << YAML::Key << "origin" << YAML::Value << YAML::Flow << YAML::BeginSeq
       << number_text(map.min_x_m) << number_text(map.min_y_m) << "0" << YAML::EndSeq;
  put("negate", "0");
  put("occupied_thresh", kOccupiedAbove);
  put("free_thresh", kFreeBelow);
  yaml << YAML::EndMap << YAML::Newline;
  return yaml.c_str();
}
}  // namespace

std::vector<std::int8_t> ros_cells(const MapStrips& map, const Occupancy& o)
{
  const Kinds kinds = kinds_of(map, o);
  std::vector<std::int8_t> cells(kinds.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    cells[i] = kinds[i] == Kind::Unknown ? -1 : kinds[i] == Kind::Free ? 0 : 100;
  return cells;
}

void write_ros_map(const std::string& path, const MapStrips& map, RosMode mode, const Occupancy& o)
{
  const Kinds kinds = kinds_of(map, o);
  std::filesystem::path picture = path;
  // Beside a map its .png is the picture of it that talus-map wrote.
  picture.replace_extension();
  picture += mode == RosMode::Scale ? "_scale.png" : ".pgm";
  if (mode == RosMode::Scale)
    io::write_png(picture.string(), picture_of(map, kinds));
  else
    write_pgm(picture.string(), map.frame(), kinds);
  io::write_file(path, yaml_of(map.frame(), picture.filename().string(), mode));
}

}  // namespace talus::formats
