#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "point_fields.h"
#include "text_lines.h"

namespace talus::import
{
/** The lines before the points of a file, which may name them. */
class HeaderLines : public TextLines
{
 public:
  HeaderLines(const std::string& path, std::string_view text) : TextLines(text), path_(path) {}

  /** Throws std::runtime_error, the line and what is wrong, where it does not hold. */
  void require(bool holds, const std::string& what) const
  {
    if (!holds) fail_at(path_ + ":" + std::to_string(line_number()), what);
  }
  /** The next word, a whole number. */
  std::uint64_t whole(std::uint64_t max);

 private:
  std::string path_;
};

/** Points of typed fields, one after the other. */
struct PointRecords
{
  std::vector<PointField> fields;
  std::uint64_t count = 0;
  bool is_text = false;  //!< a line a point
  bool is_big_endian = false;
  bool by_field = false;  //!< all numbers of a field follow each other, not all of a point
  std::size_t begin = 0, lines = 0;  //!< bytes and lines of the file before them
};

/** Throws std::runtime_error that names the byte or the line where `data` ends before the points
 * do; what is behind them is nothing. */
void read_records(
    const std::string& path, const PointRecords& records, std::string_view data, ScanFile& out);

/** Unpacks LZF, as binary_compressed .pcd files have it: exactly `size` bytes, else false. */
bool unpack_lzf(std::string_view packed, std::size_t size, std::string& out);

/** The maximum of bytes that packed ones hold. */
constexpr std::size_t most_of_lzf(std::size_t packed_bytes)
{
  return packed_bytes * 88;  // three bytes give 264 at most
}

}  // namespace talus::import
