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
std::size_t max_faces_of(const MapStrips& map)
{
  std::size_t faces = 0;
  map.for_each(
      [&](const Strip& strip)
      {
        const Heights h(strip.map);
        for (std::size_t i = 0; i < h.ground.size(); ++i)
          faces += (std::isnan(h.ground[i]) ? 0U : 2U) + (h.stands(i) ? 10U : 0U);
      });
  return faces;
}

/** Vertices of the strip, and faces between them and the row below, whose vertices `row` has. */
void add_ground(const Strip& strip, std::vector<std::int32_t>& row, Mesh& mesh)
{
  const Heights h(strip.map);
  const auto& score = needed_layer(strip.map, Layer::Traversability);
  std::int32_t beside = kNone, below_beside = kNone;
  for_each_cell(
      strip,
      [&](std::size_t i, int ix, int iy)
      {
        std::int32_t& vertex = row[static_cast<std::size_t>(ix)];
        const std::int32_t below = vertex;
        vertex = std::isnan(h.ground[i]) ? kNone
                                         : mesh.add_vertex(
                                               middle_x_m(strip.map, ix), middle_y_m(strip.map, iy),
                                               h.ground[i], io::score_colour(score[i]));
        if (ix > 0 && std::min({below_beside, below, vertex, beside}) != kNone)
        {
          mesh.add_face(below_beside, below, vertex);
          mesh.add_face(below_beside, vertex, beside);
        }
        below_beside = below;
        beside = vertex;
      });
}

/** What stands on a cell is a box: its top, and its sides as far as nothing beside it is as high.
 */
void add_standing(const Strip& strip, Mesh& mesh)
{
  struct Corner
  {
    int x, y;
  };
  constexpr std::array<Corner, 4> kCorners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  constexpr std::array<Corner, 4> kBeside{
      {{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};  // of corner and next
  const io::LayerStack& map = strip.map;
  const Heights h(map);
  const double half_m = map.resolution_m / 2;
  for_each_cell(
      strip,
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
    const std::string& path, const MapStrips& map, std::size_t max_faces, const FileOrigin& origin)
{
  const auto fits = [max_faces](const MapStrips& m)
  { return m.frame().cells_x <= 1 || m.frame().cells_y <= 1 || max_faces_of(m) <= max_faces; };
  const MapStrips shown = joined_until(fits, map);
  Mesh mesh(origin);
  std::vector<std::int32_t> row(static_cast<std::size_t>(shown.frame().cells_x), kNone);
  shown.for_each([&](const Strip& strip) { add_ground(strip, row, mesh); });
  shown.for_each([&](const Strip& strip) { add_standing(strip, mesh); }, 1);
  if (mesh.vertex_count == 0) throw std::runtime_error(path + ": no cell of the map is known");
  io::AtomicFile file(path);
  file.write(head_of(mesh));
  file.write(mesh.vertices);
  file.write(mesh.faces);
  file.commit();
  std::string list = text_of(origin);
  std::replace(list.begin(), list.end(), ' ', ',');
  io::write_file(
      std::filesystem::path(path).replace_extension().string() + "_mesh.json",
      "{\"origin_m\": [" + list + "]}\n");
}

}  // namespace talus::formats
