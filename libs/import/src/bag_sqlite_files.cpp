#include "bag_sqlite_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <set>
#include <stdexcept>

#include "bag_covered_file.h"

namespace talus::import
{
struct ReadOnlyFiles::State
{
  sqlite3_vfs vfs{};
  sqlite3_vfs* host = nullptr;  //!< that of the system: for names, times and its own scratch files
  std::string name;
  std::set<std::string> removed;  //!< files that SQLite takes to be gone
  std::uint64_t least_bytes = 0;
};

namespace
{
using State = ReadOnlyFiles::State;

State& state_of(sqlite3_vfs* vfs) { return *static_cast<State*>(vfs->pAppData); }

struct File
{
  sqlite3_file base;
  CoveredFile* covered;
};

CoveredFile& covered(sqlite3_file* file) { return *reinterpret_cast<File*>(file)->covered; }

int close_file(sqlite3_file* file)
{
  delete reinterpret_cast<File*>(file)->covered;
  return SQLITE_OK;
}

int read_file(sqlite3_file* file, void* to, int count, sqlite3_int64 begin)
{
  const auto from = static_cast<std::uint64_t>(begin);
  const auto bytes = static_cast<std::size_t>(count);
  if (!covered(file).read(from, bytes, static_cast<char*>(to))) return SQLITE_IOERR_READ;
  return from + bytes > covered(file).size() ? SQLITE_IOERR_SHORT_READ : SQLITE_OK;
}

int write_file(sqlite3_file* file, const void* from, int count, sqlite3_int64 begin)
{
  try
  {
    const bool is_written = covered(file).write(
        static_cast<std::uint64_t>(begin), static_cast<std::size_t>(count),
        static_cast<const char*>(from));
    return is_written ? SQLITE_OK : SQLITE_IOERR_READ;
  }
  catch (const std::bad_alloc&)
  {
    return SQLITE_NOMEM;
  }
}

int truncate_file(sqlite3_file* file, sqlite3_int64 size)
{
  covered(file).truncate(static_cast<std::uint64_t>(size));
  return SQLITE_OK;
}

int size_of_file(sqlite3_file* file, sqlite3_int64* size)
{
  *size = static_cast<sqlite3_int64>(covered(file).size());
  return SQLITE_OK;
}

int is_reserved(sqlite3_file*, int* result)
{
  *result = 0;
  return SQLITE_OK;
}

int nothing_to_do(sqlite3_file*, int) { return SQLITE_OK; }
int no_control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_bytes(sqlite3_file*) { return 512; }
int no_characteristics(sqlite3_file*) { return 0; }

/** Without shared memory, so that the index of a WAL is kept in that of the connection. */
constexpr sqlite3_io_methods kMethods = {
    1,
    close_file,
    read_file,
    write_file,
    truncate_file,
    nothing_to_do,
    size_of_file,
    nothing_to_do,
    nothing_to_do,
    is_reserved,
    no_control,
    sector_bytes,
    no_characteristics,
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    nullptr};

/** The file as it is on disk; none: nothing. A pipe is no file. */
std::unique_ptr<CoveredFile> open_on_disk(const char* path, std::uint64_t least_bytes)
{
  const int descriptor = ::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return nullptr;
  struct stat info
  {
  };
  if (::fstat(descriptor, &info) != 0 || !S_ISREG(info.st_mode))
  {
    ::close(descriptor);
    return nullptr;
  }
  const auto size = static_cast<std::uint64_t>(info.st_size);
  return std::make_unique<CoveredFile>(descriptor, size, std::max(size, least_bytes));
}

int open_file(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags, int* out_flags)
{
  constexpr int kOfBag =
      SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_WAL | SQLITE_OPEN_SUPER_JOURNAL;
  auto& state = state_of(vfs);
  if (!path || (flags & kOfBag) == 0)
    return state.host->xOpen(state.host, path, file, flags, out_flags);
  file->pMethods = nullptr;
  const bool is_main = (flags & SQLITE_OPEN_MAIN_DB) != 0;
  if (is_main) state.removed.clear();  // a new connection sees what is on disk
  std::unique_ptr<CoveredFile> opened;
  if (state.removed.count(path) == 0) opened = open_on_disk(path, is_main ? state.least_bytes : 0);
  if (!opened)
  {
    const bool may_be_made = !is_main && (flags & SQLITE_OPEN_CREATE) != 0;
    if (!may_be_made) return SQLITE_CANTOPEN;
    opened = std::make_unique<CoveredFile>(-1, 0, 0);
  }
  reinterpret_cast<File*>(file)->covered = opened.release();
  file->pMethods = &kMethods;
  if (out_flags) *out_flags = flags;
  return SQLITE_OK;
}

int remove_file(sqlite3_vfs* vfs, const char* path, int)
{
  state_of(vfs).removed.insert(path);
  return SQLITE_OK;
}

/** As SQLite's own: an empty journal is none. */
int is_there(sqlite3_vfs* vfs, const char* path, int, int* result)
{
  struct stat info
  {
  };
  *result = state_of(vfs).removed.count(path) == 0 && ::stat(path, &info) == 0 &&
            (!S_ISREG(info.st_mode) || info.st_size > 0);
  return SQLITE_OK;
}

int full_name(sqlite3_vfs* vfs, const char* path, int bytes, char* out)
{
  auto* host = state_of(vfs).host;
  return host->xFullPathname(host, path, bytes, out);
}

int randomness(sqlite3_vfs* vfs, int bytes, char* out)
{
  auto* host = state_of(vfs).host;
  return host->xRandomness(host, bytes, out);
}

int sleep(sqlite3_vfs* vfs, int microseconds)
{
  auto* host = state_of(vfs).host;
  return host->xSleep(host, microseconds);
}

int current_time(sqlite3_vfs* vfs, double* days)
{
  auto* host = state_of(vfs).host;
  return host->xCurrentTime(host, days);
}

int last_error(sqlite3_vfs* vfs, int bytes, char* out)
{
  auto* host = state_of(vfs).host;
  return host->xGetLastError ? host->xGetLastError(host, bytes, out) : 0;
}
}  // namespace

ReadOnlyFiles::ReadOnlyFiles(std::uint64_t least_bytes) : state_(std::make_unique<State>())
{
  auto& state = *state_;
  state.host = sqlite3_vfs_find(nullptr);
  if (!state.host) throw std::runtime_error("SQLite has no way to the files of this system");
  state.least_bytes = least_bytes;
  state.name = "talus-" + std::to_string(reinterpret_cast<std::uintptr_t>(&state));
  auto& vfs = state.vfs;
  vfs.iVersion = 1;
  vfs.szOsFile = std::max(state.host->szOsFile, static_cast<int>(sizeof(File)));
  vfs.mxPathname = state.host->mxPathname;
  vfs.zName = state.name.c_str();
  vfs.pAppData = &state;
  vfs.xOpen = open_file;
  vfs.xDelete = remove_file;
  vfs.xAccess = is_there;
  vfs.xFullPathname = full_name;
  vfs.xRandomness = randomness;
  vfs.xSleep = sleep;
  vfs.xCurrentTime = current_time;
  vfs.xGetLastError = last_error;
  sqlite3_vfs_register(&vfs, 0);
}

ReadOnlyFiles::~ReadOnlyFiles() { sqlite3_vfs_unregister(&state_->vfs); }

const char* ReadOnlyFiles::name() const { return state_->name.c_str(); }

}  // namespace talus::import
