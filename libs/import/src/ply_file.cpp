#include <talus/input_file.h>
#include <talus/number_text.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "formats.h"
#include "text_lines.h"

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

enum class Coding
{
  Ascii,
  LittleEndian,
  BigEndian
};

struct Header
{
  std::optional<Coding> coding;
  std::vector<Element> elements;  //!< up to the vertices; none after them are read
  std::size_t begin = 0;  //!< of the elements [byte]
  std::size_t lines = 0;
};

std::optional<NumberType> type_named(std::string_view name)
{
  struct Named
  {
    std::string_view name, long_name;
    NumberType type;
  };
  constexpr Named kTypes[] = {
      {"char", "int8", NumberType::Int8},        {"uchar", "uint8", NumberType::UInt8},
      {"short", "int16", NumberType::Int16},     {"ushort", "uint16", NumberType::UInt16},
      {"int", "int32", NumberType::Int32},       {"uint", "uint32", NumberType::UInt32},
      {"int64", "long", NumberType::Int64},      {"uint64", "ulong", NumberType::UInt64},
      {"float", "float32", NumberType::Float32}, {"double", "float64", NumberType::Float64}};
  for (const Named& t : kTypes)
    if (name == t.name || name == t.long_name) return t.type;
  return std::nullopt;
}

/** Reads the lines before the elements. */
class HeaderReader
{
 public:
  HeaderReader(const std::string& path, std::string_view text) : path_(path), lines_(text) {}

  Header read();

 private:
  void read_format();
  void read_element();
  void read_property();
  void require(bool holds, const std::string& what) const
  {
    if (!holds) fail_at(path_ + ":" + std::to_string(lines_.line_number()), what);
  }
  NumberType type(std::string_view word) const
  {
    const auto known = type_named(word);
    require(known.has_value(), shown(word) + " is no type of numbers");
    return *known;
  }

  std::string path_;
  TextLines lines_;
  Header header_;
};

void HeaderReader::read_format()
{
  const auto word = lines_.next_word();
  if (word == "ascii") header_.coding = Coding::Ascii;
  if (word == "binary_little_endian") header_.coding = Coding::LittleEndian;
  if (word == "binary_big_endian") header_.coding = Coding::BigEndian;
  require(header_.coding.has_value(), "format " + shown(word) + " is not known");
}

void HeaderReader::read_element()
{
  constexpr std::size_t kMaxElements = 100;
  require(header_.elements.size() < kMaxElements, "more than 100 elements");
  Element element;
  element.name = lines_.next_word();
  const auto word = lines_.next_word();
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), element.count);
  require(
      error == std::errc() && end == word.data() + word.size(),
      "element " + shown(element.name) + ": " + shown(word) + " is no number of them");
  header_.elements.push_back(element);
}

void HeaderReader::read_property()
{
  constexpr std::size_t kMaxProperties = 1000;
  require(!header_.elements.empty(), "a property before any element");
  auto& properties = header_.elements.back().properties;
  require(properties.size() < kMaxProperties, "more than 1000 properties");
  Property property;
  auto word = lines_.next_word();
  if (word == "list")
  {
    property.length = type(lines_.next_word());
    word = lines_.next_word();
  }
  property.type = type(word);
  property.name = lines_.next_word();
  properties.push_back(property);
}

Header HeaderReader::read()
{
  require(lines_.next_line() && lines_.next_word() == "ply", "does not begin with 'ply'");
  while (lines_.next_line())
  {
    const auto key = lines_.next_word();
    if (key.empty() || key == "comment" || key == "obj_info") continue;
    if (key == "format")
      read_format();
    else if (key == "element")
      read_element();
    else if (key == "property")
      read_property();
    else if (key == "end_header")
    {
      require(header_.coding.has_value(), "the header has no line 'format'");
      header_.begin = lines_.position();
      header_.lines = lines_.line_number();
      return header_;
    }
    else
      require(false, shown(key) + " is no line of the header of a .ply file");
  }
  fail_at(path_, "no line 'end_header': it is no .ply file, or cut in its header");
}

const Element& vertices_of(const std::string& path, const Header& header)
{
  for (const Element& e : header.elements)
    if (e.name == "vertex") return e;
  fail_at(path, "has no element 'vertex': it is no cloud of points");
}

std::vector<PointField> named(const std::string& path, const Element& vertices)
{
  std::vector<PointField> fields;
  fields.reserve(vertices.properties.size());
  for (const Property& p : vertices.properties)
  {
    if (p.length)
      fail_at(path, "its vertices have a list, " + shown(p.name) + ", which is not read");
    fields.push_back({p.name, p.type});
  }
  return fields;
}

std::string there_of(std::uint64_t there, const Element& element)
{
  return "is cut: " + std::to_string(there) + " of " + std::to_string(element.count) + " " +
         shown(element.name) + " are there";
}

/** False: it is cut. Takes one of the elements from the bytes. */
bool skip_one(const Element& element, std::string_view& bytes, bool swapped)
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

void read_binary(
    const std::string& path, const Header& header, std::string_view bytes, ScanFile& out)
{
  const bool swapped = (header.coding == Coding::BigEndian) != is_big_endian_host();
  const Element& vertices = vertices_of(path, header);
  const auto fail_cut = [&, end = bytes.size()](std::uint64_t there, const Element& element)
  { fail_at(path, there_of(there, element) + ", up to byte " + std::to_string(end)); };
  bytes.remove_prefix(header.begin);
  for (const Element* e = header.elements.data(); e != &vertices; ++e)
    for (std::uint64_t i = 0; i < e->count && !e->properties.empty(); ++i)
      if (!skip_one(*e, bytes, swapped)) fail_cut(i, *e);
  const auto fields = named(path, vertices);
  const std::size_t point_bytes = bytes_of(fields);
  const std::size_t there = point_bytes ? bytes.size() / point_bytes : 0;
  PointCollector points(
      fields, static_cast<std::size_t>(std::min<std::uint64_t>(vertices.count, there)), path, out);
  if (there < vertices.count) fail_cut(there, vertices);
  points.add_records(places_of(fields, bytes.data(), vertices.count, swapped), vertices.count);
}

void read_ascii(
    const std::string& path, const Header& header, std::string_view bytes, ScanFile& out)
{
  const Element& vertices = vertices_of(path, header);
  TextLines lines(bytes.substr(header.begin));
  const auto place = [&]
  { return path + ":" + std::to_string(header.lines + lines.line_number()); };
  const auto next_line = [&](std::uint64_t there, const Element& element)
  {
    if (!lines.next_line()) fail_at(place(), there_of(there, element));
  };
  for (const Element* e = header.elements.data(); e != &vertices; ++e)
    for (std::uint64_t i = 0; i < e->count && !e->properties.empty(); ++i) next_line(i, *e);
  const auto fields = in_text(named(path, vertices));
  const std::uint64_t at_most = bytes.size() / (2 * std::max<std::size_t>(fields.size(), 1)) + 1;
  PointCollector points(
      fields, static_cast<std::size_t>(std::min(vertices.count, at_most)), path, out);
  for (std::uint64_t i = 0; i < vertices.count; ++i)
  {
    next_line(i, vertices);
    points.add_text(lines, place());
  }
}
}  // namespace

void read_ply(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  const Header header = HeaderReader(path, bytes).read();
  (header.coding == Coding::Ascii ? read_ascii : read_binary)(path, header, bytes, out);
}

}  // namespace talus::import
