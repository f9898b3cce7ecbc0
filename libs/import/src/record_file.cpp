#include "record_file.h"

#include <talus/number_text.h>

#include <algorithm>
#include <charconv>

namespace talus::import
{
namespace
{
void read_binary(
    const std::string& path, const PointRecords& records, std::string_view data, ScanFile& out)
{
  const std::size_t point_bytes = bytes_of(records.fields);
  if (point_bytes == 0) fail_at(path, "its points have no fields");
  if (records.count > data.size() / point_bytes)
    fail_at(
        path,
        "is cut after byte " + std::to_string(records.begin + data.size()) + ": its " +
            std::to_string(records.count) + " points of " + std::to_string(point_bytes) +
            " bytes need " +
            number_text(static_cast<double>(records.count) * static_cast<double>(point_bytes)) +
            " bytes, " + std::to_string(data.size()) + " are there");
  PointCollector points(records.fields, records.count, path, out);
  points.add_records(
      positions_of(
          records.fields, data.data(), records.count, records.is_big_endian != is_big_endian_host(),
          records.by_field),
      records.count);
  points.finish();
}

void read_text(
    const std::string& path, const PointRecords& records, std::string_view data, ScanFile& out)
{
  // A number and a blank need two bytes; text has all digits, whatever the type is called.
  const std::size_t numbers = std::max<std::size_t>(records.fields.size(), 1);
  const std::uint64_t max_points = data.size() / (2 * numbers) + 1;
  auto fields = records.fields;
  for (PointField& f : fields)
    if (f.type == NumberType::Float32) f.type = NumberType::Float64;
  PointCollector points(fields, std::min(records.count, max_points), path, out);
  TextLines lines(data);
  const auto place = [&]
  { return path + ":" + std::to_string(records.lines + lines.line_number()); };
  std::uint64_t read = 0;
  while (read < records.count && lines.next_line())
  {
    if (lines.is_blank()) continue;
    points.add_text(lines, place());
    ++read;
  }
  if (read < records.count)
    fail_at(
        place(), "is cut: " + std::to_string(read) + " of " + std::to_string(records.count) +
                     " points are there");
  points.finish();
}
}  // namespace

std::uint64_t HeaderLines::whole(std::uint64_t max)
{
  const auto word = next_word();
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  require(
      error == std::errc() && end == word.data() + word.size() && value <= max,
      shown(word) + " is not a whole number up to " + std::to_string(max));
  return value;
}

void read_records(
    const std::string& path, const PointRecords& records, std::string_view data, ScanFile& out)
{
  (records.is_text ? read_text : read_binary)(path, records, data, out);
}

// A byte below 32: so many bytes and one more follow as they are. Else a piece of what was unpacked
// follows again: its length in the upper three bits (7: and the next byte) and two more, its
// distance in the lower five and the next byte, and one more.
bool unpack_lzf(std::string_view packed, std::size_t size, std::string& out)
{
  out.clear();
  out.reserve(size);
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(packed[at]); };
  for (std::size_t at = 0; at < packed.size();)
  {
    const std::size_t control = byte(at++);
    if (control < 32)
    {
      const std::size_t count = control + 1;
      if (count > packed.size() - at || count > size - out.size()) return false;
      out.append(packed.substr(at, count));
      at += count;
      continue;
    }
    std::size_t count = (control >> 5) + 2;
    const std::size_t more = control >= 7 * 32 ? 2 : 1;
    if (more > packed.size() - at) return false;
    if (more == 2) count += byte(at++);
    const std::size_t distance = ((control & 31) << 8) + byte(at++) + 1;
    if (distance > out.size() || count > size - out.size()) return false;
    for (std::size_t from = out.size() - distance; count > 0; --count) out.push_back(out[from++]);
  }
  return out.size() == size;
}

}  // namespace talus::import
