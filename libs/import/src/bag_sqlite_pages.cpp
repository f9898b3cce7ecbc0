#include "bag_sqlite_pages.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "bag_file.h"

namespace talus::import
{
namespace
{
constexpr std::size_t kHeader = 100;  //!< bytes of the file before the tree of page 1
constexpr std::size_t kMostHead = 64;  //!< bytes of a record before its data: four small numbers

std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t count)
{
  if (at + count > bytes.size()) throw std::out_of_range("number");
  return big_endian(bytes.substr(at, count));
}

/** Takes one from the front. Throws std::out_of_range behind the end. */
std::uint64_t varint(std::string_view bytes, std::size_t& at)
{
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i)
  {
    const auto byte = static_cast<unsigned char>(bytes.at(at++));
    value = value << 7 | (byte & 0x7fU);
    if (byte < 0x80) return value;
  }
  return value << 8 | static_cast<unsigned char>(bytes.at(at++));
}

/** Bytes of an integer by the type of its column; 9: it is none. */
std::size_t bytes_of_integer(std::uint64_t type)
{
  constexpr std::array<std::size_t, 10> kBytes = {9, 1, 2, 3, 4, 6, 8, 9, 0, 0};
  return type < kBytes.size() ? kBytes[type] : 9;
}

std::int64_t integer(std::string_view bytes, std::size_t& at, std::uint64_t type)
{
  const std::size_t count = bytes_of_integer(type);
  if (count == 0 || count > 8) return type == 9 ? 1 : 0;
  const std::size_t unused = 8 * (8 - count);
  const std::uint64_t value = number(bytes, at, count) << unused;
  at += count;
  return static_cast<std::int64_t>(value) >> unused;  // with its sign
}
}  // namespace

std::uint64_t big_endian(std::string_view bytes)
{
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

struct SqlitePages::Payload
{
  std::int64_t id = 0;
  std::uint64_t bytes = 0;
  std::uint64_t begin = 0, local = 0;  //!< the part on its page
  std::uint64_t next = 0;  //!< the first page of the rest
};

SqlitePages::SqlitePages(FileBytes& file) : file_(file)
{
  const auto head = file_.look(0, kHeader);
  if (head.size() < kHeader || head.substr(0, 15) != "SQLite format 3")
    throw std::runtime_error("has no header of SQLite");
  page_bytes_ = number(head, 16, 2);
  if (page_bytes_ == 1) page_bytes_ = 65536;
  const std::uint64_t reserved = number(head, 20, 1);
  if (page_bytes_ < 512 || (page_bytes_ & (page_bytes_ - 1)) != 0 || reserved > 32)
    throw std::runtime_error("has a header without a size of its pages");
  usable_ = page_bytes_ - reserved;
  is_wal_ = number(head, 19, 1) == 2;
  if (number(head, 24, 4) == number(head, 92, 4)) told_bytes_ = page_bytes_ * number(head, 28, 4);
}

std::uint64_t SqlitePages::page_end(std::uint64_t cell) const
{
  return cell / page_bytes_ * page_bytes_ + usable_;
}

/** The two numbers that a cell begins with, and how much of its payload lies on its own page. */
bool SqlitePages::find_payload(std::uint64_t cell, std::uint64_t end, Payload& out)
{
  const auto bytes = file_.look(cell, 18);
  std::size_t at = 0;
  out.bytes = varint(bytes, at);
  out.id = static_cast<std::int64_t>(varint(bytes, at));
  out.begin = cell + at;
  const std::uint64_t most = usable_ - 35, least = (usable_ - 12) * 32 / 255 - 23;
  out.local = out.bytes;
  if (out.bytes > most)
  {
    const std::uint64_t kept = least + (out.bytes - least) % (usable_ - 4);
    out.local = kept <= most ? kept : least;
  }
  if (out.bytes > kMostBagBytes || out.begin + out.local > std::min(end, file_.size()))
    return false;
  out.next = 0;
  if (out.local < out.bytes) out.next = number(file_.look(out.begin + out.local, 4), 0, 4);
  return true;
}

/** Whether it is a message: its number (which is that of the row), two numbers and its data. */
bool SqlitePages::parse(const Payload& payload, StoredMessage& message, std::uint64_t& data_begin)
{
  const auto bytes = file_.look(payload.begin, std::min<std::uint64_t>(payload.local, kMostHead));
  std::size_t at = 0;
  const auto head = varint(bytes, at);
  std::array<std::uint64_t, 4> types{};
  for (auto& type : types) type = varint(bytes, at);
  const bool is_blob = types[3] >= 12 && types[3] % 2 == 0;
  if (at != head || types[0] != 0 || bytes_of_integer(types[1]) > 8 ||
      bytes_of_integer(types[2]) > 8 || !is_blob)
    return false;
  message.id = payload.id;
  message.topic = integer(bytes, at, types[1]);
  message.time_ns = integer(bytes, at, types[2]);
  data_begin = at;
  return at + (types[3] - 12) / 2 == payload.bytes;
}

/** Whether all of its pages are there. Together the messages have no more bytes than the file. */
bool SqlitePages::is_whole(const Payload& payload)
{
  if (payload.bytes > bytes_left_) return false;
  bytes_left_ -= payload.bytes;
  std::uint64_t next = payload.next;
  for (std::uint64_t left = payload.bytes - payload.local; left > 0;)
  {
    const std::uint64_t at = (next - 1) * page_bytes_, here = std::min(left, usable_ - 4);
    if (next == 0 || at + 4 + here > file_.size()) return false;
    next = number(file_.look(at, 4), 0, 4);
    left -= here;
  }
  return true;
}

void SqlitePages::look_at(std::uint64_t page, std::vector<StoredMessage>& found, std::size_t& cut)
{
  constexpr std::uint64_t kLeafOfTable = 13;
  const std::uint64_t begin = page * page_bytes_, head = page == 0 ? begin + kHeader : begin;
  const auto top = file_.look(head, 8);
  if (top.size() < 8 || number(top, 0, 1) != kLeafOfTable) return;
  const std::uint64_t cells = number(top, 3, 2);
  for (std::uint64_t i = 0; i < cells && 8 + 2 * i < page_bytes_; ++i)
  {
    try
    {
      Payload payload;
      StoredMessage message;
      std::uint64_t data_begin = 0;
      message.cell = begin + number(file_.look(head + 8 + 2 * i, 2), 0, 2);
      const bool is_there = find_payload(message.cell, begin + usable_, payload);
      if (is_there && !parse(payload, message, data_begin)) continue;  // of another table
      if (is_there && is_whole(payload))
        found.push_back(message);
      else
        ++cut;
    }
    catch (const std::out_of_range&)
    {
      ++cut;
    }
  }
}

std::vector<StoredMessage> SqlitePages::messages(std::size_t& cut)
{
  std::vector<StoredMessage> found;
  cut = 0;
  bytes_left_ = file_.size();
  for (std::uint64_t page = 0; page * page_bytes_ < file_.size(); ++page) look_at(page, found, cut);
  std::sort(
      found.begin(), found.end(),
      [](const StoredMessage& a, const StoredMessage& b)
      { return a.time_ns != b.time_ns ? a.time_ns < b.time_ns : a.id < b.id; });
  return found;
}

void SqlitePages::read(const StoredMessage& message, std::vector<char>& data)
{
  Payload payload;
  StoredMessage same;
  std::uint64_t data_begin = 0;
  find_payload(message.cell, page_end(message.cell), payload);
  parse(payload, same, data_begin);
  std::vector<char> part;
  file_.read(payload.begin, static_cast<std::size_t>(payload.local), data);
  for (std::uint64_t next = payload.next; data.size() < payload.bytes;)
  {
    const auto bytes = std::min(payload.bytes - data.size(), usable_ - 4);
    file_.read((next - 1) * page_bytes_, static_cast<std::size_t>(bytes + 4), part);
    next = number({part.data(), 4}, 0, 4);
    data.insert(data.end(), part.begin() + 4, part.end());
  }
  data.erase(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(data_begin));
}

}  // namespace talus::import
