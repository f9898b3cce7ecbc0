#pragma once
#include <sqlite3.h>
#include <talus/io/atomic_file.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "bag_bytes.h"

namespace talus::import
{
using SqliteStatement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

/** Pages of a database are missing, or are not what they should be. */
class SqliteDamaged : public std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/** What the first bytes of a database say, see https://sqlite.org/fileformat2.html. */
struct SqliteHeader
{
  /** Throws std::runtime_error that names the file, where it has none. */
  SqliteHeader(const std::string& path, FileBytes& file);

  std::uint64_t page_bytes = 0;
  std::uint64_t stated_bytes = 0;  //!< size of the file; 0: it does not say
  bool is_wal = false;  //!< whether what is written last is kept in a file beside it
};

/** A database and what SQLite may have put beside it: sizes and times of their last change. */
class FilesOfDatabase
{
 public:
  /** Throws std::runtime_error as require_readable_file() does. */
  explicit FilesOfDatabase(const std::string& path);

  std::uint64_t bytes() const;
  /** Whether a WAL or a journal lies beside it. */
  bool has_log() const { return has_wal() || has_journal(); }
  bool has_wal() const { return states_[1].bytes > 0; }
  bool has_journal() const { return states_[2].bytes > 0; }
  /** Whether a WAL ends in the middle of a page, of which SQLite says nothing. */
  bool has_cut_wal() const;
  bool have_changed() const;
  /** Copies all to `to`, with their endings, to be written. Throws
   * std::filesystem::filesystem_error. */
  void copy(const std::string& to) const;

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

/** A database that is only read, also while others hold it locked: without locks, and without a
 * file of SQLite's own in its folder. One with a journal, which has to be undone, is copied into
 * the folder for temporary files. All throw std::runtime_error that names the file. */
class SqliteDatabase
{
 public:
  /** `partial`: also one that is cut. */
  SqliteDatabase(const std::string& path, bool partial)
      : path_(path), partial_(partial), files_(path)
  {
  }

  void open();
  /** After all statements are gone. */
  void close() { connection_.reset(); }

  SqliteStatement ask(const std::string& sql);
  /** Whether there is a row. */
  bool step(sqlite3_stmt* statement);
  /** Makes a table `talus_leaf` (id, topic_id, timestamp, data) of the rows on one page (the first
   * is 1), a leaf, whatever leads to it: the pages above may be lost. Only of one that is read in
   * part, and without statements. */
  void show_leaf(std::uint64_t page);

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
  std::string uri();
  void copy_files();
  [[noreturn]] void fail_with(int code) const;

  std::string path_;
  bool partial_;
  FilesOfDatabase files_;
  std::unique_ptr<io::HiddenFolder> copy_;
  Budget budget_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> connection_{nullptr, sqlite3_close};
};

}  // namespace talus::import
