#include <algorithm>
#include <map>
#include <stdexcept>
#include <tuple>

#include "bag_file.h"
#include "bag_sqlite_database.h"
#include "bag_topics.h"

namespace talus::import
{
namespace
{
std::string text_of(sqlite3_stmt* row, int column)
{
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text ? std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)))
              : std::string();
}

/** A row of the table of messages, and the page it is on. */
struct StoredMessage
{
  std::int64_t time_ns = 0, id = 0, topic = 0;
  std::uint64_t page = 0;

  bool operator<(const StoredMessage& o) const
  {
    return std::tie(time_ns, id) < std::tie(o.time_ns, o.id);
  }
};

/** A bag of rosbag2's plugin sqlite3: tables topics and messages. */
class SqliteFile final : public BagFile
{
 public:
  SqliteFile(const std::string& path, bool partial);

  std::uint64_t bytes() const override { return base_.bytes(); }
  std::vector<std::uint64_t> counts() const override { return counts_; }
  std::optional<std::int64_t> first_ns() override { return first_ns_; }
  std::uint64_t stored_bytes() const override { return message_bytes_; }
  std::vector<std::string> remarks() const override { return remarks_; }
  bool next(BagMessage& message) override;
  std::string_view payload() override;
  std::string place() const override { return path_ + ": message " + std::to_string(id_); }
  double progress() const override
  {
    return std::min(1.0, static_cast<double>(read_bytes_) / static_cast<double>(base_.bytes()));
  }
  void stop() override;

 private:
  bool is_short() const;
  bool is_sound();
  void require_whole() const;
  std::string missing_log() const;
  void require_table(const std::string& name);
  void read_topics();
  void count_messages();
  void count(std::int64_t topic, std::int64_t time_ns);
  void take_leaves();
  std::size_t take_leaf(std::uint64_t page);
  bool is_whole(const StoredMessage& row);
  void rewind() override;
  bool next_row(BagMessage& message);
  bool next_stored(BagMessage& message);
  void show(std::uint64_t page);
  std::string_view data_of_row();

  std::string path_;
  FileBytes file_;
  SqliteHeader header_;
  SqliteDatabase base_;
  std::uint64_t read_bytes_ = 0;
  SqliteStatement ids_{nullptr, sqlite3_finalize}, data_{nullptr, sqlite3_finalize};
  std::map<std::int64_t, std::size_t> places_;  //!< in topics_, by the id in the table
  std::vector<std::uint64_t> counts_;  //!< of messages, one a topic
  std::optional<std::int64_t> first_ns_;
  std::int64_t id_ = 0;  //!< of the last message
  std::optional<std::vector<StoredMessage>> stored_;  //!< all that are whole in a bag that is cut
  std::size_t at_ = 0;  //!< the next of stored_
  std::uint64_t shown_ = 0;  //!< page of which data_ is
  std::uint64_t message_bytes_ = 0;  //!< of the last payload
  std::vector<std::string> remarks_;
};

SqliteFile::SqliteFile(const std::string& path, bool partial)
    : path_(path), file_(path), header_(path, file_), base_(path, partial)
{
  if (!partial) require_whole();
  base_.open();
  require_table("topics");
  require_table("messages");
  read_topics();
  if (base_.has_cut_wal())
    remarks_.push_back(path_ + "-wal: is cut: of what it has, the whole transactions are read");
  if (partial && !is_sound())
    take_leaves();
  else
    count_messages();
  stop();
}

/** Of pages that are still in a log the header may count before they are there. */
bool SqliteFile::is_short() const
{
  return !base_.has_log() && file_.size() < header_.stated_bytes;
}

void SqliteFile::require_whole() const
{
  if (is_short())
    throw std::runtime_error(
        path_ + ": is cut: it has " + std::to_string(file_.size()) + " of " +
        std::to_string(header_.stated_bytes) +
        " bytes. Copy it again; where there is no better copy, --partial reads what is whole.");
}

void SqliteFile::require_table(const std::string& name)
{
  const auto found = base_.ask(
      "SELECT 1 FROM sqlite_master WHERE type='table' AND rootpage>0 AND name='" + name + "'");
  if (base_.step(found.get())) return;
  const auto missing = missing_log();
  base_.fail("it has no table '" + name + "'" + (missing.empty() ? "" : "; " + missing));
}

/** A recorder that keeps a WAL was killed, and its file was copied without it. */
std::string SqliteFile::missing_log() const
{
  if (!header_.is_wal || base_.has_log()) return "";
  return "what a killed recorder wrote last is in " + path_ + "-wal, which is not beside it";
}

void SqliteFile::read_topics()
{
  std::size_t name_bytes = 0;
  const auto rows =
      base_.ask("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (base_.step(rows.get()))
  {
    if (sqlite3_column_type(rows.get(), 0) != SQLITE_INTEGER) base_.fail("a topic has no number");
    if (!places_.emplace(sqlite3_column_int64(rows.get(), 0), topics_.size()).second)
      base_.fail("two topics have one number");
    topics_.push_back({text_of(rows.get(), 1), text_of(rows.get(), 2), text_of(rows.get(), 3)});
    const auto& topic = topics_.back();
    name_bytes += topic.name.size() + topic.type.size() + topic.encoding.size();
    if (const auto wrong = too_long_names(name_bytes, topics_.size()); !wrong.empty())
      base_.fail(wrong);
  }
  counts_.resize(topics_.size(), 0);
}

/** Whether SQLite finds all pages, and nothing wrong in them. */
bool SqliteFile::is_sound()
{
  try
  {
    const auto answer = base_.ask("PRAGMA quick_check(1)");
    return !is_short() && base_.step(answer.get()) && text_of(answer.get(), 0) == "ok";
  }
  catch (const SqliteDamaged&)
  {
    return false;
  }
}

/** Looks at all rows: what damaged the tree of messages is found here. */
void SqliteFile::count_messages()
{
  const auto rows = base_.ask("SELECT topic_id, timestamp FROM messages NOT INDEXED");
  while (base_.step(rows.get()))
    count(sqlite3_column_int64(rows.get(), 0), sqlite3_column_int64(rows.get(), 1));
  if (const auto missing = missing_log(); !first_ns_ && !missing.empty())
    remarks_.push_back(path_ + ": holds no messages; " + missing);
}

void SqliteFile::count(std::int64_t topic, std::int64_t time_ns)
{
  first_ns_ = std::min(time_ns, first_ns_.value_or(time_ns));
  if (const auto place = places_.find(topic); place != places_.end()) ++counts_[place->second];
}

/** All rows that are whole, leaf by leaf: the pages that lead to them may be lost. */
void SqliteFile::take_leaves()
{
  constexpr std::string_view kLeafOfTable = "\x0d";
  const auto page_bytes = header_.page_bytes;
  std::size_t cut = 0;
  stored_.emplace();
  for (std::uint64_t page = 2; page * page_bytes <= file_.size(); ++page)
    if (file_.look((page - 1) * page_bytes, 1) == kLeafOfTable) cut += take_leaf(page);
  auto& all = *stored_;
  std::sort(all.begin(), all.end());
  const auto same = [](const auto& a, const auto& b) { return a.id == b.id; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  const auto last = std::max_element(
      all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  if (file_.size() % page_bytes != 0 && last != all.end())
  {
    all.erase(last);  // SQLite fills up the page in which the file ends: that of the last row
    ++cut;
  }
  for (const auto& message : all) count(message.topic, message.time_ns);
  remarks_.push_back(
      path_ + ": is cut or damaged; " + std::to_string(all.size()) +
      " messages are whole and read, " + std::to_string(cut) +
      " are there in part and left out, those behind the cut are missing");
}

/** How many rows of a page are left out. */
std::size_t SqliteFile::take_leaf(std::uint64_t page)
{
  std::vector<StoredMessage> rows_here;
  std::size_t cut = 0;
  try
  {
    show(page);
    const auto rows = base_.ask(
        "SELECT id, topic_id, timestamp FROM talus_leaf WHERE typeof(topic_id)='integer' AND "
        "typeof(timestamp)='integer' AND typeof(data)='blob'");
    while (base_.step(rows.get()))
      rows_here.push_back(
          {sqlite3_column_int64(rows.get(), 2), sqlite3_column_int64(rows.get(), 0),
           sqlite3_column_int64(rows.get(), 1), page});
  }
  catch (const std::runtime_error&)
  {
    ++cut;
  }
  for (const auto& row : rows_here)
    if (is_whole(row))
      stored_->push_back(row);
    else
      ++cut;
  return cut;
}

/** Whether a row of the page that is shown has all its pages. */
bool SqliteFile::is_whole(const StoredMessage& row)
{
  try
  {
    id_ = row.id;
    data_of_row();
    return true;
  }
  catch (const std::runtime_error&)
  {
    return false;
  }
}

void SqliteFile::show(std::uint64_t page)
{
  if (shown_ == page) return;
  shown_ = 0;
  data_.reset();
  base_.show_leaf(page);
  data_ = base_.ask("SELECT data FROM talus_leaf WHERE id=?");
  shown_ = page;
}

void SqliteFile::stop()
{
  ids_.reset();
  data_.reset();
  shown_ = 0;
  base_.close();
  file_.close();
}

void SqliteFile::rewind()
{
  stop();
  read_bytes_ = 0;
  id_ = 0;
  at_ = 0;
  base_.open();
  if (stored_) return;
  std::string wanted;
  for (const auto& [id, place] : places_)
    if (is_wanted(place)) wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
  // Without the payloads, so that to put them in order takes little memory; and without the index
  // of the bag, as a message is there also where that one lost it.
  ids_ = base_.ask(
      "SELECT rowid, topic_id, timestamp FROM messages NOT INDEXED WHERE topic_id IN (" + wanted +
      ") ORDER BY timestamp, rowid");
  data_ = base_.ask("SELECT data FROM messages WHERE rowid=?");
}

bool SqliteFile::next(BagMessage& message)
{
  const bool is_there = stored_ ? next_stored(message) : next_row(message);
  if (!is_there) base_.require_unchanged();
  return is_there;
}

bool SqliteFile::next_row(BagMessage& message)
{
  while (base_.step(ids_.get()))
  {
    const auto place = places_.find(sqlite3_column_int64(ids_.get(), 1));
    if (place == places_.end() || !is_wanted(place->second)) continue;
    id_ = sqlite3_column_int64(ids_.get(), 0);
    message.topic = place->second;
    message.log_time_ns = sqlite3_column_int64(ids_.get(), 2);
    return true;
  }
  return false;
}

bool SqliteFile::next_stored(BagMessage& message)
{
  for (; at_ < stored_->size(); ++at_)
  {
    const auto& stored = (*stored_)[at_];
    const auto place = places_.find(stored.topic);
    if (place == places_.end() || !is_wanted(place->second)) continue;
    ++at_;
    id_ = stored.id;
    message.topic = place->second;
    message.log_time_ns = stored.time_ns;
    return true;
  }
  return false;
}

std::string_view SqliteFile::payload()
{
  if (stored_) show((*stored_)[at_ - 1].page);
  return data_of_row();
}

std::string_view SqliteFile::data_of_row()
{
  if (read_bytes_ > base_.bytes()) base_.fail("its messages have more bytes than the file");
  sqlite3_reset(data_.get());
  sqlite3_bind_int64(data_.get(), 1, id_);
  if (!base_.step(data_.get())) base_.fail("a message is gone");
  const auto* data = static_cast<const char*>(sqlite3_column_blob(data_.get(), 0));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(data_.get(), 0));
  message_bytes_ = size;
  read_bytes_ += size;
  return {data, data ? size : 0};
}
}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path, bool partial)
{
  return std::make_unique<SqliteFile>(path, partial);
}

}  // namespace talus::import
