#pragma once
#include <sqlite3.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "bag_sqlite_files.h"

namespace talus::import
{
using SqliteStatement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

/** Pages of a database are missing, or are not what they should be. */
class SqliteDamaged : public std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/** A database and what SQLite may have put beside it: sizes and times of their last change. */
class FilesOfDatabase
{
 public:
  /** Throws std::runtime_error as require_readable_file() does. */
  explicit FilesOfDatabase(const std::string& path);

  std::uint64_t bytes() const;
  /** Whether a WAL or a journal lies beside it. */
  bool has_log() const { return states_[1].bytes + states_[2].bytes > 0; }
  /** Whether a WAL ends in the middle of a page, of which SQLite says nothing. */
  bool has_cut_wal() const;
  bool have_changed() const;

 private:
  struct State
  {
    std::uint64_t bytes = 0;
    std::int64_t changed_ns = 0;
  };
  using States = std::array<State, 3>;
  States look() const;

  std::string path_;
  States states_;
};

/** A database that is only read, also while others hold it locked. All throw std::runtime_error
 * that names the file. */
class SqliteDatabase
{
 public:
  /** `least_bytes`: as ReadOnlyFiles has it. */
  SqliteDatabase(const std::string& path, std::uint64_t least_bytes);

  void open();
  /** After all statements are gone. */
  void close() { connection_.reset(); }

  SqliteStatement ask(const std::string& sql);
  /** Whether there is a row. */
  bool step(sqlite3_stmt* statement);

  std::uint64_t bytes() const { return files_.bytes(); }
  bool has_log() const { return files_.has_log(); }
  bool has_cut_wal() const { return files_.has_cut_wal(); }
  /** Throws where somebody wrote to it since it was first looked at. */
  void require_unchanged() const;

  [[noreturn]] void fail(const std::string& what) const;

 private:
  /** What a database is asked for may not take more steps than this, however it is damaged. */
  struct Budget
  {
    std::int64_t calls_left = 0;
    void reset(std::uint64_t file_bytes);
    static int spend(void* budget);
  };
  [[noreturn]] void fail_with(int code) const;

  std::string path_;
  FilesOfDatabase files_;
  ReadOnlyFiles read_only_;
  Budget budget_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> connection_{nullptr, sqlite3_close};
};

}  // namespace talus::import
