#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "lzf.h"
#include "formats.h"
#include "text_lines.h"

namespace talus::import
{
namespace
{
struct Field
{
  std::string name;
  std::size_t size = 4, count = 1;  //!< bytes of a number, numbers a point
  char type = 'F';
};

struct Header
{
  std::vector<Field> fields;
  std::uint64_t width = 0, height = 1, points = 0;
  bool has_points = false;
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};  //!< x y z [m], qw qx qy qz
  std::string data;
  std::size_t begin = 0;  //!< of the points [byte]
  std::size_t lines = 0;
  std::size_t point_bytes = 0;
};

std::string in_line(const std::string& path, std::size_t line)
{
  return path + ":" + std::to_string(line);
}

/** Reads the lines before the points. */
class HeaderReader
{
 public:
  HeaderReader(const std::string& path, std::string_view text) : path_(path), lines_(text) {}

  Header read();

 private:
  void read_fields();
  void read_viewpoint();
  std::uint64_t whole(std::string_view word, std::uint64_t most) const;
  std::size_t count(const Field& field, std::string_view word) const;
  /** One a field. */
  template <class Set>
  void each_field(const char* name, const Set& set);
  void require(bool holds, const std::string& what) const
  {
    if (!holds) fail_at(in_line(path_, lines_.line_number()), what);
  }
  void check();

  std::string path_;
  TextLines lines_;
  Header header_;
};

std::uint64_t HeaderReader::whole(std::string_view word, std::uint64_t most) const
{
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  require(
      error == std::errc() && end == word.data() + word.size() && value <= most,
      shown(word) + " is not a whole number up to " + std::to_string(most));
  return value;
}

std::size_t HeaderReader::count(const Field& field, std::string_view word) const
{
  const std::size_t count = whole(word, 65536);
  require(count > 0, "field " + shown(field.name) + " has COUNT 0: it has no number in any point");
  return count;
}

void HeaderReader::read_fields()
{
  constexpr std::size_t kMaxFields = 1000;
  header_.fields.clear();
  for (auto word = lines_.next_word(); !word.empty(); word = lines_.next_word())
  {
    require(header_.fields.size() < kMaxFields, "more than 1000 fields");
    header_.fields.emplace_back();
    header_.fields.back().name = word;
  }
}

template <class Set>
void HeaderReader::each_field(const char* name, const Set& set)
{
  require(!header_.fields.empty(), std::string(name) + " before FIELDS");
  for (Field& field : header_.fields)
  {
    const auto word = lines_.next_word();
    require(!word.empty(), std::string(name) + " has fewer words than FIELDS");
    set(field, word);
  }
}

void HeaderReader::read_viewpoint()
{
  for (double& number : header_.viewpoint)
  {
    const auto word = lines_.next_word();
    const auto value = number_from(word);
    require(value && std::isfinite(*value), "VIEWPOINT: " + shown(word) + " is not a number");
    number = *value;
  }
}

Header HeaderReader::read()
{
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
  while (lines_.next_line())
  {
    const auto key = lines_.next_word();
    if (key.empty() || key[0] == '#' || key == "VERSION") continue;
    if (key == "FIELDS" || key == "COLUMNS")
      read_fields();
    else if (key == "SIZE")
      each_field("SIZE", [&](Field& f, std::string_view word) { f.size = whole(word, 8); });
    else if (key == "TYPE")
      each_field("TYPE", [&](Field& f, std::string_view word) { f.type = word[0]; });
    else if (key == "COUNT")
      each_field("COUNT", [&](Field& f, std::string_view word) { f.count = count(f, word); });
    else if (key == "WIDTH")
      header_.width = whole(lines_.next_word(), kMax);
    else if (key == "HEIGHT")
      header_.height = whole(lines_.next_word(), kMax);
    else if (key == "VIEWPOINT")
      read_viewpoint();
    else if (key == "POINTS")
    {
      header_.points = whole(lines_.next_word(), kMax);
      header_.has_points = true;
    }
    else if (key == "DATA")
    {
      header_.data = lines_.next_word();
      check();
      return header_;
    }
    else
      require(false, shown(key) + " is no line of the header of a .pcd file");
  }
  fail_at(path_, "no line DATA: it is no .pcd file, or cut in its header");
}

NumberType type_of(const Field& f)
{
  const bool is_unsigned = f.type == 'U';
  switch (f.size)
  {
    case 1:
      return is_unsigned ? NumberType::UInt8 : NumberType::Int8;
    case 2:
      return is_unsigned ? NumberType::UInt16 : NumberType::Int16;
    case 4:
      return f.type == 'F' ? NumberType::Float32
             : is_unsigned ? NumberType::UInt32
                           : NumberType::Int32;
    default:
      return f.type == 'F' ? NumberType::Float64
             : is_unsigned ? NumberType::UInt64
                           : NumberType::Int64;
  }
}

std::vector<PointField> named(const Header& header)
{
  std::vector<PointField> fields;
  fields.reserve(header.fields.size());
  for (const Field& f : header.fields) fields.push_back({f.name, type_of(f), f.count});
  return fields;
}

void HeaderReader::check()
{
  header_.begin = lines_.position();
  header_.lines = lines_.line_number();
  for (Field& f : header_.fields)
  {
    const bool is_known = f.type == 'F' ? f.size == 4 || f.size == 8
                          : f.type == 'I' || f.type == 'U'
                              ? f.size == 1 || f.size == 2 || f.size == 4 || f.size == 8
                              : false;
    require(
        is_known, "field " + shown(f.name) + " has TYPE " + shown(std::string(1, f.type)) +
                      " and SIZE " + std::to_string(f.size) + ", which no .pcd file has");
  }
  header_.point_bytes = bytes_of(named(header_));
  require(header_.point_bytes > 0, "its points have no fields");
  const std::uint64_t by_size = header_.width * header_.height;  // of 32 bits each
  if (!header_.has_points) header_.points = by_size;
  require(
      header_.points == by_size, "POINTS is " + std::to_string(header_.points) +
                                     ", WIDTH x HEIGHT " + std::to_string(by_size));
}

/** Points of which all numbers of a field follow each other, or all of a point. */
void read_binary(
    const std::string& path, const Header& header, std::string_view data, bool by_field,
    ScanFile& out)
{
  const auto fields = named(header);
  PointCollector points(fields, header.points, path, out);
  points.add_records(
      places_of(fields, data.data(), header.points, is_big_endian_host(), by_field), header.points);
}

/** Whether the file has all points; they may have bytes or lines behind them. */
void require_points(const std::string& path, const Header& header, std::size_t bytes)
{
  if (header.points <= bytes / header.point_bytes) return;
  fail_at(
      path, "is cut after byte " + std::to_string(header.begin + bytes) + ": its " +
                std::to_string(header.points) + " points of " + std::to_string(header.point_bytes) +
                " bytes need " +
                number_text(
                    static_cast<double>(header.points) * static_cast<double>(header.point_bytes)) +
                " bytes, " + std::to_string(bytes) + " are there");
}

std::size_t number_of_4_bytes(std::string_view data)
{
  return static_cast<std::size_t>(number_at(data.data(), NumberType::UInt32, is_big_endian_host()));
}

void read_compressed(
    const std::string& path, const Header& header, std::string_view data, ScanFile& out)
{
  constexpr std::size_t kSizes_bytes = 8;
  if (data.size() < kSizes_bytes) fail_at(path, "is cut before its compressed points");
  const std::size_t packed = number_of_4_bytes(data), size = number_of_4_bytes(data.substr(4));
  data.remove_prefix(kSizes_bytes);
  if (packed > data.size())
    fail_at(
        path, "is cut: " + std::to_string(packed) + " compressed bytes belong behind byte " +
                  std::to_string(header.begin + kSizes_bytes) + ", " + std::to_string(data.size()) +
                  " are there");
  if (size > kLargestScan_bytes || size > most_of_lzf(packed))
    fail_at(
        path, "says that " + std::to_string(packed) + " compressed bytes hold " +
                  std::to_string(size) + ", which cannot be");
  require_points(path, header, size);
  std::string unpacked;
  if (!unpack_lzf(data.substr(0, packed), size, unpacked))
    fail_at(
        path, "its compressed points behind byte " + std::to_string(header.begin) + " are damaged");
  read_binary(path, header, unpacked, true, out);
}

void read_ascii(const std::string& path, const Header& header, std::string_view data, ScanFile& out)
{
  // A number and a blank need two bytes.
  const auto at_most = static_cast<std::size_t>(
      std::min<std::uint64_t>(header.points, data.size() / (2 * header.fields.size()) + 1));
  PointCollector points(in_text(named(header)), at_most, path, out);
  TextLines lines(data);
  std::uint64_t read = 0;
  while (read < header.points && lines.next_line())
  {
    TextLines probe = lines;
    if (probe.next_word().empty()) continue;
    points.add_text(lines, in_line(path, header.lines + lines.line_number()));
    ++read;
  }
  if (read < header.points)
    fail_at(
        in_line(path, header.lines + lines.line_number()),
        "is cut: " + std::to_string(read) + " of " + std::to_string(header.points) +
            " points are there");
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
  const Header header = HeaderReader(path, bytes).read();
  const std::string_view data = std::string_view(bytes).substr(header.begin);
  if (header.data == "ascii")
    read_ascii(path, header, data, out);
  else if (header.data == "binary")
  {
    require_points(path, header, data.size());
    read_binary(path, header, data, false, out);
  }
  else if (header.data == "binary_compressed")
    read_compressed(path, header, data, out);
  else
    fail_at(in_line(path, header.lines), "DATA " + shown(header.data) + " is not known");
  take_viewpoint(path, header, out);
}

}  // namespace talus::import
