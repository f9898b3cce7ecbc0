#include <talus/formats/write.h>
#include <talus/io/atomic_file.h>
#include <talus/io/palette.h>

#include "needed_layer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <stdexcept>

namespace talus::formats
{
namespace
{
constexpr std::int32_t kNone = -1;

template <class T>
void put(std::string& bytes, T value)
{
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);  // little-endian, as is every machine that MRPT runs on
  bytes.append(raw, sizeof value);
}

/** Bytes of vertices and faces, and how many there are. */
struct Mesh
{
  explicit Mesh(const FileOrigin& at) : origin(at) {}

  FileOrigin origin;
  std::string vertices, faces;
  std::int32_t vertex_count = 0;
  std::size_t face_count = 0;

  std::int32_t add_vertex(double x_m, double y_m, double z_m, const io::Rgb& c)
  {
    for (const double v : {x_m - origin.x_m, y_m - origin.y_m, z_m - origin.z_m})
      put(vertices, static_cast<float>(v));
    for (const std::uint8_t v : c) put(vertices, v);
    return vertex_count++;
  }
  void add_face(std::int32_t a, std::int32_t b, std::int32_t c)
  {
    put(faces, std::uint8_t{3});
    for (const std::int32_t v : {a, b, c}) put(faces, v);
    ++face_count;
  }
};

/** Two triangles between four neighbours whose ground is known, and ten of what stands on one. */
std::size_t most_faces(const io::LayerStack& map)
{
  const Heights h(map);
  std::size_t faces = 0;
  for (std::size_t i = 0; i < h.ground.size(); ++i)
    faces += (std::isnan(h.ground[i]) ? 0U : 2U) + (h.stands(i) ? 10U : 0U);
  return faces;
}

void add_ground(const io::LayerStack& map, Mesh& mesh)
{
  const Heights h(map);
  const auto& score = needed_layer(map, Layer::Traversability);
  std::vector<std::int32_t> vertex(h.ground.size(), kNone);
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        if (std::isnan(h.ground[i])) return;
        vertex[i] = mesh.add_vertex(
            middle_x_m(map, ix), middle_y_m(map, iy), h.ground[i], io::score_colour(score[i]));
      });
  const auto row = static_cast<std::size_t>(map.cells_x);
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        if (ix + 1 >= map.cells_x || iy + 1 >= map.cells_y) return;
        const std::int32_t a = vertex[i], b = vertex[i + 1], c = vertex[i + row + 1],
                           d = vertex[i + row];
        if (a == kNone || b == kNone || c == kNone || d == kNone) return;
        mesh.add_face(a, b, c);
        mesh.add_face(a, c, d);
      });
}

/** What stands on a cell is a box: its top, and its sides as far as nothing beside it is as high.
 */
void add_standing(const io::LayerStack& map, Mesh& mesh)
{
  struct Corner
  {
    int x, y;
  };
  constexpr std::array<Corner, 4> kCorners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  constexpr std::array<Corner, 4> kBeside{
      {{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};  // of corner and next
  const Heights h(map);
  const double half_m = map.resolution_m / 2;
  for_each_cell(
      map,
      [&](std::size_t i, int ix, int iy)
      {
        if (!h.stands(i)) return;
        const auto add = [&](const Corner& c, float z_m)
        {
          return mesh.add_vertex(
              middle_x_m(map, ix) + c.x * half_m, middle_y_m(map, iy) + c.y * half_m, z_m,
              io::palette::kStands.rgb);
        };
        std::array<std::int32_t, 4> top{};
        for (std::size_t k = 0; k < 4; ++k) top[k] = add(kCorners[k], h.top[i]);
        mesh.add_face(top[0], top[1], top[2]);
        mesh.add_face(top[0], top[2], top[3]);
        for (std::size_t k = 0; k < 4; ++k)
        {
          const int x = ix + kBeside[k].x, y = iy + kBeside[k].y;
          const bool is_in = x >= 0 && y >= 0 && x < map.cells_x && y < map.cells_y;
          const auto j = static_cast<std::size_t>(y) * map.cells_x + static_cast<std::size_t>(x);
          const float low_m = !is_in        ? h.ground[i]
                              : h.stands(j) ? h.top[j]
                                            : std::fmin(h.ground[i], h.ground[j]);
          if (!(low_m < h.top[i])) continue;
          const std::size_t next = (k + 1) % 4;
          const std::int32_t from = add(kCorners[k], low_m), to = add(kCorners[next], low_m);
          mesh.add_face(from, to, top[next]);
          mesh.add_face(from, top[next], top[k]);
        }
      });
}

std::string head_of(const Mesh& mesh)
{
  return "ply\nformat binary_little_endian 1.0\ncomment ground and what stands on it, map frame, "
         "metres\ncomment origin_m: " +
         text_of(mesh.origin) + "\nelement vertex " + std::to_string(mesh.vertex_count) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty "
         "uchar green\nproperty uchar blue\nelement face " +
         std::to_string(mesh.face_count) + "\nproperty list uchar int vertex_indices\nend_header\n";
}
}  // namespace

void write_mesh(
    const std::string& path, const io::LayerStack& map, std::size_t max_faces,
    const FileOrigin& origin)
{
  const auto fits = [max_faces](const io::LayerStack& m)
  { return most_faces(m) <= max_faces || m.cells_x <= 1 || m.cells_y <= 1; };
  io::LayerStack coarse;
  const io::LayerStack& shown = joined_until(fits, map, coarse);
  Mesh mesh(origin);
  add_ground(shown, mesh);
  add_standing(shown, mesh);
  if (mesh.vertex_count == 0) throw std::runtime_error(path + ": no cell of the map is known");
  io::write_file(path, head_of(mesh) + mesh.vertices + mesh.faces);
  std::string list = text_of(origin);
  std::replace(list.begin(), list.end(), ' ', ',');
  io::write_file(
      std::filesystem::path(path).replace_extension().string() + "_mesh.json",
      "{\"origin_m\": [" + list + "]}\n");
}

}  // namespace talus::formats
