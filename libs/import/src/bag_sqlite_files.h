#pragma once
#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>

namespace talus::import
{
/** What SQLite gets to see of the files of a bag. It reads them without locks, and whatever it
 * writes (a journal that it rolls back, pages of a WAL) stays in memory: nothing in the folder of
 * the bag is made, changed or removed, and nobody has to allow it. */
class ReadOnlyFiles
{
 public:
  /** `least_bytes`: the database is shown with zeros at its end up to this size. */
  explicit ReadOnlyFiles(std::uint64_t least_bytes);
  ~ReadOnlyFiles();
  ReadOnlyFiles(const ReadOnlyFiles&) = delete;
  ReadOnlyFiles& operator=(const ReadOnlyFiles&) = delete;

  /** For sqlite3_open_v2(), with SQLITE_OPEN_READWRITE. */
  const char* name() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace talus::import
