#pragma once
// Scans in the formats of other programs, written from what the formats' own documents say.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace talus::test
{
/** What a file may say of its points; the optional ones are empty, or one a point. */
struct Points
{
  std::vector<float> x, y, z, intensity;
  std::vector<float> time;
  std::vector<std::uint16_t> ring;

  std::size_t size() const { return x.size(); }
};

/** A level floor 0.5 m below the scanner, so many tenths of a metre to each side. `timed`: each
 * point has its time, of a turn of 0.1 s. */
inline Points floor_points(int side_dm, bool timed = false)
{
  Points p;
  for (int i = -side_dm; i <= side_dm; ++i)
    for (int k = -side_dm; k <= side_dm; ++k)
    {
      p.x.push_back(0.1F * static_cast<float>(i) + 0.02F);
      p.y.push_back(0.1F * static_cast<float>(k) + 0.02F);
      p.z.push_back(-0.5F);
      if (timed) p.time.push_back(1e-3F * static_cast<float>(i + side_dm));
    }
  return p;
}

/** As a number of the other byte order where `swapped`. */
template <class T>
void put(std::string& bytes, T value, bool swapped = false)
{
  char own[sizeof(T)];
  std::memcpy(own, &value, sizeof(T));
  if (swapped) std::reverse(own, own + sizeof(T));
  bytes.append(own, sizeof(T));
}

/** All points of a record each: x y z, and what there is. */
inline std::string records(const Points& p, bool swapped = false)
{
  std::string bytes;
  for (std::size_t i = 0; i < p.size(); ++i)
  {
    for (const auto* axis : {&p.x, &p.y, &p.z}) put(bytes, (*axis)[i], swapped);
    if (!p.intensity.empty()) put(bytes, p.intensity[i], swapped);
    if (!p.time.empty()) put(bytes, p.time[i], swapped);
    if (!p.ring.empty()) put(bytes, p.ring[i], swapped);
  }
  return bytes;
}

/** All points of a line each, in digits that give the same floats again. */
inline std::string lines(const Points& p)
{
  std::string text;
  const auto add = [&](double value)
  {
    char number[40];
    std::snprintf(number, sizeof number, "%.9g ", value);
    text += number;
  };
  for (std::size_t i = 0; i < p.size(); ++i)
  {
    for (const auto* axis : {&p.x, &p.y, &p.z}) add((*axis)[i]);
    if (!p.intensity.empty()) add(p.intensity[i]);
    if (!p.time.empty()) add(p.time[i]);
    if (!p.ring.empty()) add(p.ring[i]);
    text.back() = '\n';
  }
  return text;
}

inline std::string kitti_bin(const Points& p)
{
  Points four = p;
  four.time.clear();
  four.ring.clear();
  if (four.intensity.empty()) four.intensity.assign(p.size(), 0.0F);
  return records(four);
}

inline std::string pcd_header(
    const Points& p, const std::string& data, const std::string& viewpoint = "0 0 0 1 0 0 0")
{
  const std::string fields = std::string(p.intensity.empty() ? "" : " intensity") +
                             (p.time.empty() ? "" : " time") + (p.ring.empty() ? "" : " ring");
  std::string size = "4 4 4", type = "F F F", count = "1 1 1";
  for (const bool there : {!p.intensity.empty(), !p.time.empty()})
    if (there) size += " 4", type += " F", count += " 1";
  if (!p.ring.empty()) size += " 2", type += " U", count += " 1";
  const std::string n = std::to_string(p.size());
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z" + fields +
         "\nSIZE " + size + "\nTYPE " + type + "\nCOUNT " + count + "\nWIDTH " + n +
         "\nHEIGHT 1\nVIEWPOINT " + viewpoint + "\nPOINTS " + n + "\nDATA " + data + "\n";
}

inline std::string pcd_ascii(const Points& p) { return pcd_header(p, "ascii") + lines(p); }

inline std::string pcd_binary(const Points& p, const std::string& viewpoint = "0 0 0 1 0 0 0")
{
  return pcd_header(p, "binary", viewpoint) + records(p);
}

/** A folder of the same scan again and again, ten a second, and their times. */
inline void write_scan_folder(
    const std::filesystem::path& folder, const Points& scan, int count, double first_s)
{
  std::filesystem::create_directories(folder);
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < count; ++i)
  {
    std::ofstream(folder / (std::to_string(i) + ".pcd"), std::ios::binary) << pcd_binary(scan);
    times << std::fixed << first_s + 0.1 * i << "\n";
  }
}

/** LZF without any piece that is said twice. */
inline std::string lzf_of(const std::string& bytes)
{
  std::string packed;
  for (std::size_t i = 0; i < bytes.size(); i += 32)
  {
    const std::string piece = bytes.substr(i, 32);
    packed += static_cast<char>(piece.size() - 1);
    packed += piece;
  }
  return packed;
}

/** Of all points the x, then the y, and so on. */
inline std::string pcd_compressed(const Points& p)
{
  std::string columns;
  for (const auto* field : {&p.x, &p.y, &p.z, &p.intensity, &p.time})
    for (const float number : *field) put(columns, number);
  for (const auto number : p.ring) put(columns, number);
  const std::string packed = lzf_of(columns);
  std::string bytes = pcd_header(p, "binary_compressed");
  put(bytes, static_cast<std::uint32_t>(packed.size()));
  put(bytes, static_cast<std::uint32_t>(columns.size()));
  return bytes + packed;
}

inline std::string ply_header(const Points& p, const std::string& format)
{
  return "ply\nformat " + format + " 1.0\ncomment made for a test\nelement vertex " +
         std::to_string(p.size()) + "\nproperty float x\nproperty float y\nproperty float z\n" +
         (p.intensity.empty() ? "" : "property float intensity\n") +
         (p.time.empty() ? "" : "property float32 time\n") +
         (p.ring.empty() ? "" : "property ushort ring\n") +
         "element face 0\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string ply_ascii(const Points& p) { return ply_header(p, "ascii") + lines(p); }

/** On a little-endian machine. */
inline std::string ply_little(const Points& p)
{
  return ply_header(p, "binary_little_endian") + records(p);
}

inline std::string ply_big(const Points& p)
{
  return ply_header(p, "binary_big_endian") + records(p, true);
}

}  // namespace talus::test
