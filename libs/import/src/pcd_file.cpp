#include <talus/input_file.h>
#include <talus/number_text.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "formats.h"
#include "record_file.h"

namespace talus::import
{
namespace
{
struct Header
{
  PointRecords points;
  std::vector<std::size_t> sizes;  //!< of a number of each field [bytes]
  std::vector<char> types;
  std::uint64_t width = 0, height = 1;
  std::optional<std::uint64_t> count;
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};  //!< x y z [m], qw qx qy qz
  std::string data;
};

void read_fields(HeaderLines& lines, Header& header)
{
  constexpr std::size_t kMaxFields = 1000;
  auto& fields = header.points.fields;
  fields.clear();
  for (auto word = lines.next_word(); !word.empty(); word = lines.next_word())
  {
    lines.require(fields.size() < kMaxFields, "more than 1000 fields");
    fields.push_back({std::string(word), NumberType::Float32});
  }
  header.sizes.assign(fields.size(), 4);
  header.types.assign(fields.size(), 'F');
}

/** SIZE, TYPE or COUNT: a word a field. */
void read_each(HeaderLines& lines, const std::string& key, Header& header)
{
  auto& fields = header.points.fields;
  lines.require(!fields.empty(), key + " before FIELDS");
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    TextLines probe = lines;
    const auto word = probe.next_word();
    lines.require(!word.empty(), key + " has fewer words than FIELDS");
    if (key == "SIZE") header.sizes[i] = lines.whole(8);
    if (key == "TYPE") header.types[i] = lines.next_word()[0];
    if (key != "COUNT") continue;
    fields[i].count = lines.whole(65536);
    lines.require(
        fields[i].count > 0,
        "field " + shown(fields[i].name) + " has COUNT 0: it has no number in any point");
  }
}

void read_viewpoint(HeaderLines& lines, Header& header)
{
  for (double& number : header.viewpoint)
  {
    const auto word = lines.next_word();
    const auto value = number_from(word);
    lines.require(value && std::isfinite(*value), "VIEWPOINT: " + shown(word) + " is not a number");
    number = *value;
  }
}

/** After all of its lines. */
void check(const HeaderLines& lines, Header& header)
{
  auto& points = header.points;
  for (std::size_t i = 0; i < points.fields.size(); ++i)
  {
    const auto type = number_type_of(header.types[i], header.sizes[i]);
    lines.require(
        type.has_value(), "field " + shown(points.fields[i].name) + " has TYPE " +
                              shown(std::string(1, header.types[i])) + " and SIZE " +
                              std::to_string(header.sizes[i]) + ", which no .pcd file has");
    points.fields[i].type = *type;
  }
  lines.require(!points.fields.empty(), "its points have no fields");
  const std::uint64_t by_size = header.width * header.height;  // of 32 bits each
  points.count = header.count.value_or(by_size);
  lines.require(
      points.count == by_size,
      "POINTS is " + std::to_string(points.count) + ", WIDTH x HEIGHT " + std::to_string(by_size));
  for (const char* known : {"ascii", "binary", "binary_compressed"})
    if (header.data == known) return;
  lines.require(false, "DATA " + shown(header.data) + " is not known");
}

Header read_header(const std::string& path, std::string_view text)
{
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
  HeaderLines lines(path, text);
  Header header;
  while (lines.next_line())
  {
    const auto key = lines.next_word();
    if (key.empty() || key[0] == '#' || key == "VERSION") continue;
    if (key == "FIELDS" || key == "COLUMNS")
      read_fields(lines, header);
    else if (key == "SIZE" || key == "TYPE" || key == "COUNT")
      read_each(lines, std::string(key), header);
    else if (key == "WIDTH")
      header.width = lines.whole(kMax);
    else if (key == "HEIGHT")
      header.height = lines.whole(kMax);
    else if (key == "VIEWPOINT")
      read_viewpoint(lines, header);
    else if (key == "POINTS")
      header.count = lines.whole(kMax);
    else
      lines.require(key == "DATA", shown(key) + " is no line of the header of a .pcd file");
    if (key != "DATA") continue;
    header.data = lines.next_word();
    header.points.is_text = header.data == "ascii";
    header.points.begin = lines.position();
    header.points.lines = lines.line_number();
    check(lines, header);
    return header;
  }
  fail_at(path, "no line DATA: it is no .pcd file, or cut in its header");
}

std::string unpacked(const std::string& path, std::size_t begin, std::string_view data)
{
  constexpr std::size_t kSizes_bytes = 8;
  if (data.size() < kSizes_bytes) fail_at(path, "is cut before its compressed points");
  const auto size_at = [&](std::size_t at)
  {
    return static_cast<std::size_t>(
        number_at(data.data() + at, NumberType::UInt32, is_big_endian_host()));
  };
  const std::size_t packed = size_at(0), size = size_at(4);
  data.remove_prefix(kSizes_bytes);
  if (packed > data.size())
    fail_at(
        path, "is cut: " + std::to_string(packed) + " compressed bytes belong behind byte " +
                  std::to_string(begin + kSizes_bytes) + ", " + std::to_string(data.size()) +
                  " are there");
  if (size > kLargestScan_bytes || size > most_of_lzf(packed))
    fail_at(
        path, "says that " + std::to_string(packed) + " compressed bytes hold " +
                  std::to_string(size) + ", which cannot be");
  std::string out;
  if (!unpack_lzf(data.substr(0, packed), size, out))
    fail_at(path, "its compressed points behind byte " + std::to_string(begin) + " are damaged");
  return out;
}

/** Where the scanner was, unless it is at the origin: then the file may just not say. */
void take_viewpoint(const std::string& path, const Header& header, ScanFile& out)
{
  const auto& v = header.viewpoint;
  if (v == Header().viewpoint) return;
  const double norm = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  if (!(std::abs(norm - 1) < 0.05))
    fail_at(path, "VIEWPOINT: the quaternion has norm " + number_text(norm) + " instead of 1");
  const mrpt::math::CQuaternionDouble q(v[3] / norm, v[4] / norm, v[5] / norm, v[6] / norm);
  out.viewpoint = mrpt::poses::CPose3D(q, v[0], v[1], v[2]);
}
}  // namespace

void read_pcd(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  Header header = read_header(path, bytes);
  std::string_view data = std::string_view(bytes).substr(header.points.begin);
  std::string points;
  if (header.data == "binary_compressed")
  {
    data = points = unpacked(path, header.points.begin, data);
    header.points.by_field = true;
  }
  read_records(path, header.points, data, out);
  take_viewpoint(path, header, out);
}

}  // namespace talus::import
