#pragma once
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace talus::import
{
/** Numbers and texts of little endian records, one after the other. Throws std::runtime_error "is
 * cut short" where there are too few bytes. */
class RecordReader
{
 public:
  explicit RecordReader(std::string_view data) : rest_(data) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  std::string_view text() { return take(u32()); }
  std::string_view take(std::uint64_t bytes);
  std::size_t left() const { return rest_.size(); }

 private:
  std::uint64_t number(std::size_t bytes);
  std::string_view rest_;
};

/** A file that is looked at here and there, mostly forward, through a small window. */
class FileBytes
{
 public:
  /** Throws std::runtime_error as require_readable_file() does. */
  explicit FileBytes(const std::string& path);

  std::uint64_t size() const { return size_; }

  /** Bytes from `begin` on: up to `most` (at most 64 KiB), fewer at the end of the file; valid
   * until the next call. */
  std::string_view look(std::uint64_t begin, std::size_t most);

  /** Throws std::runtime_error where the file cannot be read or ends before. */
  void read(std::uint64_t begin, std::size_t count, std::vector<char>& out);

  void close();

 private:
  std::size_t fill(std::uint64_t begin, std::size_t count, char* to);

  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0, position_ = 0;
  std::uint64_t window_begin_ = 0;
  std::vector<char> window_;
};

}  // namespace talus::import
