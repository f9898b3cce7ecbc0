#include <talus/input_file.h>

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
struct Property
{
  std::string name;
  NumberType type = NumberType::Float32;
  std::optional<NumberType> length;  //!< of a list: the type of its length
};

struct Element
{
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header
{
  PointRecords points;
  bool has_format = false;
  std::vector<Element> elements;
};

void read_format(HeaderLines& lines, Header& header)
{
  const auto word = lines.next_word();
  header.has_format = true;
  header.points.is_text = word == "ascii";
  header.points.is_big_endian = word == "binary_big_endian";
  lines.require(
      header.points.is_text || header.points.is_big_endian || word == "binary_little_endian",
      "format " + shown(word) + " is not known");
}

void read_element(HeaderLines& lines, Header& header)
{
  constexpr std::size_t kMaxElements = 100;
  lines.require(header.elements.size() < kMaxElements, "more than 100 elements");
  auto& element = header.elements.emplace_back();
  element.name = lines.next_word();
  element.count = lines.whole(std::numeric_limits<std::uint64_t>::max());
}

NumberType read_type(HeaderLines& lines, std::string_view word)
{
  const auto known = number_type_named(word);
  lines.require(known.has_value(), shown(word) + " is no type of numbers");
  return *known;
}

void read_property(HeaderLines& lines, Header& header)
{
  constexpr std::size_t kMaxProperties = 1000;
  lines.require(!header.elements.empty(), "a property before any element");
  auto& properties = header.elements.back().properties;
  lines.require(properties.size() < kMaxProperties, "more than 1000 properties");
  auto& property = properties.emplace_back();
  auto word = lines.next_word();
  if (word == "list")
  {
    property.length = read_type(lines, lines.next_word());
    word = lines.next_word();
  }
  property.type = read_type(lines, word);
  property.name = lines.next_word();
}

Header read_header(const std::string& path, std::string_view text)
{
  HeaderLines lines(path, text);
  Header header;
  lines.require(lines.next_line() && lines.next_word() == "ply", "does not begin with 'ply'");
  while (lines.next_line())
  {
    const auto key = lines.next_word();
    if (key.empty() || key == "comment" || key == "obj_info") continue;
    if (key == "format")
      read_format(lines, header);
    else if (key == "element")
      read_element(lines, header);
    else if (key == "property")
      read_property(lines, header);
    else
      lines.require(key == "end_header", shown(key) + " is no line of the header of a .ply file");
    if (key != "end_header") continue;
    lines.require(header.has_format, "the header has no line 'format'");
    header.points.begin = lines.position();
    header.points.lines = lines.line_number();
    return header;
  }
  fail_at(path, "no line 'end_header': it is no .ply file, or cut in its header");
}

void take_fields(const std::string& path, const Element& vertices, PointRecords& points)
{
  points.count = vertices.count;
  for (const Property& p : vertices.properties)
  {
    if (p.length)
      fail_at(path, "its vertices have a list, " + shown(p.name) + ", which is not read");
    points.fields.push_back({p.name, p.type});
  }
}

/** False: it is cut. Takes one of the elements from the bytes. */
bool skip_binary(const Element& element, bool swapped, std::string_view& bytes)
{
  for (const Property& p : element.properties)
  {
    double count = 1;
    if (p.length)
    {
      if (bytes_of(*p.length) > bytes.size()) return false;
      count = number_at(bytes.data(), *p.length, swapped);
      bytes.remove_prefix(bytes_of(*p.length));
    }
    if (!(count >= 0 && count <= static_cast<double>(bytes.size() / bytes_of(p.type))))
      return false;
    bytes.remove_prefix(static_cast<std::size_t>(count) * bytes_of(p.type));
  }
  return true;
}

/** The same of a line. */
bool skip_line(std::string_view& bytes)
{
  TextLines line(bytes);
  const bool is_there = line.next_line();
  bytes.remove_prefix(line.position());
  return is_there;
}
}  // namespace

void read_ply(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  Header header = read_header(path, bytes);
  PointRecords& points = header.points;
  std::string_view data = std::string_view(bytes).substr(points.begin);
  for (const Element& element : header.elements)
  {
    if (element.name == "vertex")
    {
      take_fields(path, element, points);
      points.begin = bytes.size() - data.size();
      return read_records(path, points, data, out);
    }
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i)
    {
      const bool is_there =
          points.is_text ? skip_line(data)
                         : skip_binary(element, points.is_big_endian != is_big_endian_host(), data);
      if (!is_there)
        fail_at(
            path, "is cut: " + std::to_string(i) + " of " + std::to_string(element.count) + " " +
                      shown(element.name) + " are there, up to byte " +
                      std::to_string(bytes.size()));
      points.lines += points.is_text ? 1 : 0;
    }
  }
  fail_at(path, "has no element 'vertex': it is no cloud of points");
}

}  // namespace talus::import
