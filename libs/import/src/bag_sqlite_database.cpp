#include "bag_sqlite_database.h"

#include <sys/stat.h>
#include <talus/input_file.h>

#include <algorithm>

#include "bag_bytes.h"
#include "bag_file.h"
#include "bag_sqlite_pages.h"

namespace talus::import
{
namespace
{
constexpr std::array<const char*, 3> kEndings = {"", "-wal", "-journal"};
constexpr int kStepsACall = 100000;
}  // namespace

FilesOfDatabase::FilesOfDatabase(const std::string& path) : path_(path), states_(look())
{
  for (std::size_t i = 0; i < states_.size(); ++i)
    if (i == 0 || states_[i].bytes > 0) require_readable_file(path_ + kEndings.at(i), "bag");
}

FilesOfDatabase::States FilesOfDatabase::look() const
{
  constexpr std::int64_t kSecond_ns = 1000000000;
  States states;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    struct stat info
    {
    };
    if (::stat((path_ + kEndings.at(i)).c_str(), &info) != 0) continue;
    states[i].bytes = static_cast<std::uint64_t>(info.st_size);
    states[i].changed_ns = std::int64_t{info.st_mtim.tv_sec} * kSecond_ns + info.st_mtim.tv_nsec;
  }
  return states;
}

std::uint64_t FilesOfDatabase::bytes() const
{
  return states_[0].bytes + states_[1].bytes + states_[2].bytes;
}

bool FilesOfDatabase::has_cut_wal() const
{
  constexpr std::uint64_t kHeader = 32, kFrameHead = 24;
  if (states_[1].bytes <= kHeader) return false;
  const auto page_bytes = big_endian(FileBytes(path_ + kEndings[1]).look(8, 4));
  return (states_[1].bytes - kHeader) % (kFrameHead + page_bytes) != 0;
}

bool FilesOfDatabase::have_changed() const
{
  const auto now = look();
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now[i].bytes != states_[i].bytes || now[i].changed_ns != states_[i].changed_ns) return true;
  return false;
}

void SqliteDatabase::Budget::reset(std::uint64_t file_bytes)
{
  constexpr std::uint64_t kStepsAByte = 10, kStepsAtLeast = 10000000;
  calls_left = static_cast<std::int64_t>((kStepsAtLeast + kStepsAByte * file_bytes) / kStepsACall);
}

int SqliteDatabase::Budget::spend(void* budget)
{
  return --static_cast<Budget*>(budget)->calls_left < 0 ? 1 : 0;
}

SqliteDatabase::SqliteDatabase(const std::string& path, std::uint64_t least_bytes)
    : path_(path), files_(path), read_only_(least_bytes)
{
}

void SqliteDatabase::open()
{
  constexpr std::uint64_t kLeastLength = 1 << 16;  // of a statement
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path_.c_str(), &raw, SQLITE_OPEN_READWRITE, read_only_.name());
  connection_.reset(raw);
  if (code != SQLITE_OK) fail(raw ? sqlite3_errmsg(raw) : "no memory");
  // What the schema of a database asks for may run, so that one of a stranger may do little.
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  // No message is longer than its file.
  const auto longest = std::min<std::uint64_t>(kMostBagBytes, std::max(bytes(), kLeastLength));
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(longest));
  sqlite3_progress_handler(raw, kStepsACall, Budget::spend, &budget_);
  budget_.reset(bytes());
  // The index of a WAL then needs no file that is shared with others.
  step(ask("PRAGMA locking_mode=EXCLUSIVE").get());
}

SqliteStatement SqliteDatabase::ask(const std::string& sql)
{
  sqlite3_stmt* raw = nullptr;
  const int code = sqlite3_prepare_v2(connection_.get(), sql.c_str(), -1, &raw, nullptr);
  if (code != SQLITE_OK) fail_with(code);
  return {raw, sqlite3_finalize};
}

bool SqliteDatabase::step(sqlite3_stmt* statement)
{
  const int code = sqlite3_step(statement);
  if (code == SQLITE_INTERRUPT) fail("it goes round in circles");
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail_with(code);
  return code == SQLITE_ROW;
}

void SqliteDatabase::require_unchanged() const
{
  if (files_.have_changed())
    throw std::runtime_error(
        path_ +
        ": was changed while it was read. Is it still being recorded? Import it when that is "
        "over.");
}

void SqliteDatabase::fail_with(int code) const
{
  require_unchanged();
  const std::string what = sqlite3_errmsg(connection_.get());
  if (code != SQLITE_CORRUPT && code != SQLITE_NOTADB) fail(what);
  throw SqliteDamaged(
      path_ + ": is damaged or cut short (" + what +
      "). Copy it again; where there is no better copy, --partial reads what is whole in it.");
}

void SqliteDatabase::fail(const std::string& what) const
{
  throw std::runtime_error(
      path_ + ": cannot be read as a bag in SQLite (" + what +
      "). Copy it again; what is whole of a damaged one is kept by: sqlite3 BROKEN.db3 .recover | "
      "sqlite3 NEW.db3");
}

}  // namespace talus::import
