#include "bag_sqlite_database.h"

#include <sys/stat.h>
#include <talus/input_file.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "bag_file.h"

namespace fs = std::filesystem;

namespace talus::import
{
namespace
{
constexpr std::array<const char*, 3> kEndings = {"", "-wal", "-journal"};
constexpr int kStepsACall = 100000;
constexpr const char* kCopies = ".talus-bag.";

std::uint64_t big_endian(std::string_view bytes)
{
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

/** For sqlite3_open_v2(). */
std::string uri_of(const std::string& path, const std::string& how)
{
  std::string uri = "file://";
  for (const char c : fs::absolute(path).string())
    uri += c == '%' ? "%25" : c == '?' ? "%3f" : c == '#' ? "%23" : std::string(1, c);
  return uri + how;
}
}  // namespace

SqliteHeader::SqliteHeader(const std::string& path, FileBytes& file)
{
  constexpr std::size_t kBytes = 100;
  constexpr std::uint64_t kMin = 512, kMax = 65536;  // of a page
  const auto head = file.look(0, kBytes);
  if (head.size() < kBytes) throw std::runtime_error(path + ": is cut short. Copy the bag again.");
  const auto number = [&](std::size_t at, std::size_t count)
  { return big_endian(head.substr(at, count)); };
  page_bytes = number(16, 2) == 1 ? kMax : number(16, 2);
  if (page_bytes < kMin)
    throw std::runtime_error(
        path + ": has a header without a size of its pages. Copy the bag again.");
  is_wal = number(19, 1) == 2;
  if (number(24, 4) == number(92, 4)) stated_bytes = page_bytes * number(28, 4);
}

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

void FilesOfDatabase::copy(const std::string& to) const
{
  for (std::size_t i = 0; i < states_.size(); ++i)
  {
    if (states_[i].bytes == 0) continue;
    fs::copy_file(path_ + kEndings.at(i), to + kEndings.at(i));
    fs::permissions(to + kEndings.at(i), fs::perms::owner_write, fs::perm_options::add);
  }
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

void SqliteDatabase::copy_files()
{
  try
  {
    const auto folder = fs::temp_directory_path();
    io::HiddenFolder::remove_abandoned(folder, kCopies);
    copy_ = std::make_unique<io::HiddenFolder>(folder, kCopies);
    files_.copy(copy_->path() / "bag.db3");
  }
  catch (const std::system_error& e)
  {
    throw std::runtime_error(
        path_ + ": has a journal, and cannot be copied to undo it: " + e.what() + ". Free " +
        std::to_string(bytes()) + " bytes there, or name another folder in TMPDIR.");
  }
}

std::string SqliteDatabase::uri()
{
  if (!files_.has_journal())
    return uri_of(path_, files_.has_wal() ? "?vfs=unix-none" : "?immutable=1");
  if (!copy_) copy_files();
  return uri_of(copy_->path() / "bag.db3", "");
}

void SqliteDatabase::open()
{
  constexpr std::uint64_t kMinLength = 1 << 16;  // of a statement
  sqlite3* raw = nullptr;
  const int mode = files_.has_journal() ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY;
  const int code = sqlite3_open_v2(uri().c_str(), &raw, mode | SQLITE_OPEN_URI, nullptr);
  connection_.reset(raw);
  if (code != SQLITE_OK) fail(raw ? sqlite3_errmsg(raw) : "no memory");
  // What the schema of a database asks for may run, so that one of a stranger may do little.
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, partial_ ? 0 : 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  // No message is longer than its file.
  const auto longest = std::min<std::uint64_t>(kMaxBagBytes, std::max(bytes(), kMinLength));
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(longest));
  sqlite3_progress_handler(raw, kStepsACall, Budget::spend, &budget_);
  budget_.reset(bytes());
  // The index of a WAL then needs no file that is shared with others.
  step(ask("PRAGMA locking_mode=EXCLUSIVE").get());
  // SQLite then opens one that has fewer pages than it says.
  if (partial_) step(ask("PRAGMA writable_schema=ON").get());
}

void SqliteDatabase::show_leaf(std::uint64_t page)
{
  // What the command .imposter of its shell does: nothing is written.
  const auto begin_table_at = [&](int on, int root)
  { sqlite3_test_control(SQLITE_TESTCTRL_IMPOSTER, connection_.get(), "main", on, root); };
  begin_table_at(0, 1);  // forgets the last one
  begin_table_at(1, static_cast<int>(page));
  const int code = sqlite3_exec(
      connection_.get(),
      "CREATE TABLE talus_leaf(id INTEGER PRIMARY KEY, topic_id, timestamp, data)", nullptr,
      nullptr, nullptr);
  begin_table_at(0, 0);
  if (code != SQLITE_OK) fail_with(code);
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
