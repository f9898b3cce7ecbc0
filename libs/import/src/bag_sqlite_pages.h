#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "bag_bytes.h"

namespace talus::import
{
/** A number as SQLite writes it. */
std::uint64_t big_endian(std::string_view bytes);

/** A row of the table of messages, and where it lies in the file. */
struct StoredMessage
{
  std::int64_t id = 0, topic = 0, time_ns = 0;
  std::uint64_t cell = 0;  //!< its byte in the file
};

/** The messages of a database that is cut, page by page, without the tree that leads to them: its
 * upper pages may lie behind the cut. The format is that of https://sqlite.org/fileformat2.html. */
class SqlitePages
{
 public:
  /** Throws std::runtime_error, what is wrong only, for a header that is none. */
  explicit SqlitePages(FileBytes& file);

  /** Size that the header tells [bytes]; 0: it does not. */
  std::uint64_t told_bytes() const { return told_bytes_; }

  /** Whether SQLite keeps what is written last in a file beside it. */
  bool is_wal() const { return is_wal_; }

  /** Those that are whole, in the order of time; `cut`: how many are not. */
  std::vector<StoredMessage> messages(std::size_t& cut);

  /** The data of one of them. */
  void read(const StoredMessage& message, std::vector<char>& data);

 private:
  struct Payload;
  bool find_payload(std::uint64_t cell, std::uint64_t page_end, Payload& out);
  bool parse(const Payload& payload, StoredMessage& message, std::uint64_t& data_begin);
  bool is_whole(const Payload& payload);
  void look_at(std::uint64_t page, std::vector<StoredMessage>& found, std::size_t& cut);
  std::uint64_t page_end(std::uint64_t cell) const;

  FileBytes& file_;
  std::uint64_t page_bytes_ = 0, usable_ = 0, told_bytes_ = 0;
  std::uint64_t bytes_left_ = 0;  //!< of the file, for messages
  bool is_wal_ = false;
};

}  // namespace talus::import
