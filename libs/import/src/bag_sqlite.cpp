#include <sqlite3.h>
#include <talus/input_file.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "bag_file.h"

namespace talus::import
{
namespace
{
using Database = std::unique_ptr<sqlite3, int (*)(sqlite3*)>;
using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

/** What a database is asked for may not take more steps than this, however it is damaged. */
struct Budget
{
  static constexpr int kStepsACall = 100000;
  std::int64_t calls_left = 0;

  void reset(std::uint64_t file_bytes)
  {
    constexpr std::uint64_t kStepsAByte = 10, kStepsAtLeast = 10000000;
    calls_left =
        static_cast<std::int64_t>((kStepsAtLeast + kStepsAByte * file_bytes) / kStepsACall);
  }
  static int spend(void* budget) { return --static_cast<Budget*>(budget)->calls_left < 0 ? 1 : 0; }
};

std::string text_of(sqlite3_stmt* row, int column)
{
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text ? std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)))
              : std::string();
}

/** A bag of rosbag2's plugin sqlite3: tables topics and messages. */
class SqliteFile final : public BagFile
{
 public:
  explicit SqliteFile(const std::string& path) : path_(path)
  {
    require_readable_file(path, "bag");
    bytes_ = std::filesystem::file_size(path);
    open();
    require_table("topics");
    require_table("messages");
    read_topics();
    stop();
  }

  bool next(BagMessage& message) override;
  std::string_view payload() override;
  std::string place() const override { return path_ + ": message " + std::to_string(id_); }
  double progress() const override
  {
    return std::min(1.0, static_cast<double>(read_bytes_) / static_cast<double>(bytes_));
  }
  void stop() override
  {
    ids_.reset();
    data_.reset();
    db_.reset();
  }

 private:
  void open();
  void require_table(const std::string& name);
  void read_topics();
  void rewind() override;
  Statement ask(const std::string& sql);
  bool step(sqlite3_stmt* statement);
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::uint64_t bytes_ = 0, read_bytes_ = 0;
  Budget budget_;
  Database db_{nullptr, sqlite3_close};
  Statement ids_{nullptr, sqlite3_finalize}, data_{nullptr, sqlite3_finalize};
  std::map<std::int64_t, std::size_t> places_;  //!< in topics_, by the id in the table
  std::int64_t id_ = 0;  //!< of the last message
};

void SqliteFile::open()
{
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path_.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr);
  db_.reset(raw);
  if (code != SQLITE_OK) fail(raw ? sqlite3_errmsg(raw) : "no memory");
  // What the schema of a database asks for may run, so that one of a stranger may do little.
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(kMostBagBytes));
  sqlite3_progress_handler(raw, Budget::kStepsACall, Budget::spend, &budget_);
  budget_.reset(bytes_);
}

Statement SqliteFile::ask(const std::string& sql)
{
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(db_.get(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK)
    fail(sqlite3_errmsg(db_.get()));
  return {raw, sqlite3_finalize};
}

bool SqliteFile::step(sqlite3_stmt* statement)
{
  const int code = sqlite3_step(statement);
  if (code == SQLITE_INTERRUPT) fail("it goes round in circles");
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail(sqlite3_errmsg(db_.get()));
  return code == SQLITE_ROW;
}

void SqliteFile::fail(const std::string& what) const
{
  throw std::runtime_error(
      path_ + ": cannot be read as a bag in SQLite (" + what + ")" +
      (id_ != 0 ? ", after message " + std::to_string(id_) : "") +
      ". Copy it again; what is whole of a damaged one is kept by: sqlite3 BROKEN.db3 .recover | "
      "sqlite3 NEW.db3");
}

void SqliteFile::require_table(const std::string& name)
{
  const auto found =
      ask("SELECT 1 FROM sqlite_master WHERE type='table' AND rootpage>0 AND name='" + name + "'");
  if (!step(found.get())) fail("it has no table '" + name + "'");
}

void SqliteFile::read_topics()
{
  const auto rows = ask("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (step(rows.get()))
  {
    if (sqlite3_column_type(rows.get(), 0) != SQLITE_INTEGER) fail("a topic has no number");
    if (!places_.emplace(sqlite3_column_int64(rows.get(), 0), topics_.size()).second)
      fail("two topics have one number");
    topics_.push_back({text_of(rows.get(), 1), text_of(rows.get(), 2), text_of(rows.get(), 3)});
  }
}

void SqliteFile::rewind()
{
  stop();
  open();
  read_bytes_ = 0;
  id_ = 0;
  std::string wanted;
  for (const auto& [id, place] : places_)
    if (is_wanted(place)) wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
  // Without the payloads, so that to put them in order takes no memory where there is no index.
  ids_ =
      ask("SELECT rowid, topic_id, timestamp FROM messages WHERE topic_id IN (" + wanted +
          ") ORDER BY timestamp, rowid");
  data_ = ask("SELECT data FROM messages WHERE rowid=?");
}

bool SqliteFile::next(BagMessage& message)
{
  while (step(ids_.get()))
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

std::string_view SqliteFile::payload()
{
  sqlite3_reset(data_.get());
  sqlite3_bind_int64(data_.get(), 1, id_);
  if (!step(data_.get())) fail("a message is not where its index says");
  const auto* data = static_cast<const char*>(sqlite3_column_blob(data_.get(), 0));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(data_.get(), 0));
  read_bytes_ += size;
  if (read_bytes_ > bytes_) fail("its messages have more bytes than the file");
  return {data, data ? size : 0};
}
}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path)
{
  return std::make_unique<SqliteFile>(path);
}

}  // namespace talus::import
