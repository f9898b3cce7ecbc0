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
constexpr const char* kCopyAgain = "Copy or write it again";

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

[[noreturn]] void fail(const std::string& place, const std::string& what)
{
  throw std::runtime_error(place + ": " + what + ". " + kCopyAgain + ".");
}

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
    if (!holds) fail(path_ + ":" + std::to_string(lines_.line_number()), what);
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
  constexpr std::size_t kMostElements = 100;
  require(header_.elements.size() < kMostElements, "more than 100 elements");
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
  constexpr std::size_t kMostProperties = 1000;
  require(!header_.elements.empty(), "a property before any element");
  auto& properties = header_.elements.back().properties;
  require(properties.size() < kMostProperties, "more than 1000 properties");
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
  fail(path_, "no line 'end_header': it is no .ply file, or cut in its header");
}

const Element& vertices_of(const std::string& path, const Header& header)
{
  for (const Element& e : header.elements)
    if (e.name == "vertex") return e;
  fail(path, "has no element 'vertex': it is no cloud of points");
}

std::vector<PointField> named(const std::string& path, const Element& vertices)
{
  std::vector<PointField> fields;
  fields.reserve(vertices.properties.size());
  for (const Property& p : vertices.properties)
  {
    if (p.length) fail(path, "its vertices have a list, " + shown(p.name) + ", which is not read");
    fields.push_back({p.name, p.type});
  }
  return fields;
}

std::string there_of(std::uint64_t there, const Element& element)
{
  return "is cut: " + std::to_string(there) + " of " + std::to_string(element.count) + " " +
         shown(element.name) + " are there";
}

/** Goes through the elements in bytes. */
class BinaryReader
{
 public:
  BinaryReader(std::string path, const Header& header, std::string_view bytes)
      : path_(std::move(path)),
        bytes_(bytes),
        at_(header.begin),
        swapped_((header.coding == Coding::BigEndian) != is_big_endian_host())
  {
  }

  void skip(const Element& element);
  void read(const Element& vertices, ScanFile& out);

 private:
  std::size_t left() const { return bytes_.size() - at_; }
  [[noreturn]] void fail_cut(std::uint64_t there, const Element& element) const
  {
    fail(path_, there_of(there, element) + ", up to byte " + std::to_string(bytes_.size()));
  }
  /** False: it is cut. */
  bool skip_one(const Element& element);

  std::string path_;
  std::string_view bytes_;
  std::size_t at_;
  bool swapped_;
};

bool BinaryReader::skip_one(const Element& element)
{
  for (const Property& p : element.properties)
  {
    double count = 1;
    if (p.length)
    {
      if (bytes_of(*p.length) > left()) return false;
      count = number_at(bytes_.data() + at_, *p.length, swapped_);
      at_ += bytes_of(*p.length);
    }
    if (!(count >= 0 && count <= static_cast<double>(left() / bytes_of(p.type)))) return false;
    at_ += static_cast<std::size_t>(count) * bytes_of(p.type);
  }
  return true;
}

void BinaryReader::skip(const Element& element)
{
  if (element.properties.empty()) return;  // takes no bytes, however many there are
  for (std::uint64_t i = 0; i < element.count; ++i)
    if (!skip_one(element)) fail_cut(i, element);
}

void BinaryReader::read(const Element& vertices, ScanFile& out)
{
  const auto fields = named(path_, vertices);
  std::vector<std::size_t> offsets;
  offsets.reserve(fields.size());
  std::size_t point_bytes = 0;
  for (const PointField& f : fields)
  {
    offsets.push_back(point_bytes);
    point_bytes += bytes_of(f.type);
  }
  const std::size_t there = point_bytes ? left() / point_bytes : 0;
  PointCollector points(
      fields, static_cast<std::size_t>(std::min<std::uint64_t>(vertices.count, there)), path_, out);
  if (there < vertices.count) fail_cut(there, vertices);
  std::vector<double> values(points.wanted().size());
  for (std::uint64_t i = 0; i < vertices.count; ++i, at_ += point_bytes)
  {
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      const std::size_t f = points.wanted()[k];
      values[k] = number_at(bytes_.data() + at_ + offsets[f], points.types()[k], swapped_);
    }
    points.add(values.data());
  }
}

/** Goes through the elements in lines of text. */
class AsciiReader
{
 public:
  AsciiReader(std::string path, const Header& header, std::string_view bytes)
      : path_(std::move(path)), before_(header.lines), lines_(bytes.substr(header.begin))
  {
  }

  void skip(const Element& element)
  {
    if (element.properties.empty()) return;
    for (std::uint64_t i = 0; i < element.count; ++i) next_line(i, element);
  }
  void read(const Element& vertices, std::size_t bytes, ScanFile& out);

 private:
  std::string place() const { return path_ + ":" + std::to_string(before_ + lines_.line_number()); }
  void next_line(std::uint64_t there, const Element& element)
  {
    if (!lines_.next_line()) fail(place(), there_of(there, element));
  }

  std::string path_;
  std::size_t before_;  //!< lines
  TextLines lines_;
};

void AsciiReader::read(const Element& vertices, std::size_t bytes, ScanFile& out)
{
  auto fields = named(path_, vertices);
  for (PointField& f : fields)  // text has all digits, whatever the type is called
    if (f.type == NumberType::Float32) f.type = NumberType::Float64;
  const std::uint64_t at_most = bytes / (2 * std::max<std::size_t>(fields.size(), 1)) + 1;
  PointCollector points(
      fields, static_cast<std::size_t>(std::min(vertices.count, at_most)), path_, out);
  std::vector<double> all(fields.size()), wanted(points.wanted().size());
  for (std::uint64_t i = 0; i < vertices.count; ++i)
  {
    next_line(i, vertices);
    for (std::size_t k = 0; k < all.size(); ++k)
    {
      const auto word = lines_.next_word();
      const auto value = number_from(word);
      if (word.empty())
        fail(place(), "has " + std::to_string(k) + " numbers of " + std::to_string(all.size()));
      if (!value) fail(place(), shown(word) + " is not a number");
      all[k] = *value;
    }
    for (std::size_t k = 0; k < wanted.size(); ++k) wanted[k] = all[points.wanted()[k]];
    points.add(wanted.data());
  }
}
}  // namespace

void read_ply(const std::string& path, ScanFile& out)
{
  const std::string bytes = read_input_file(path, "scan", kLargestScan_bytes);
  const Header header = HeaderReader(path, bytes).read();
  const Element& vertices = vertices_of(path, header);
  if (header.coding == Coding::Ascii)
  {
    AsciiReader reader(path, header, bytes);
    for (const Element* e = header.elements.data(); e != &vertices; ++e) reader.skip(*e);
    reader.read(vertices, bytes.size(), out);
    return;
  }
  BinaryReader reader(path, header, bytes);
  for (const Element* e = header.elements.data(); e != &vertices; ++e) reader.skip(*e);
  reader.read(vertices, out);
}

}  // namespace talus::import
