#include <talus/io/hidden_folder.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::io
{
namespace
{
constexpr const char* kKeptFor = ".talus-kept-for";  // a link in it to what it waits for
constexpr const char* kRandom = "XXXXXX";

/** Whether what was opened is still at its path. */
bool is_still_at(const fs::path& path, int fd)
{
  struct stat opened, there;
  return ::fstat(fd, &opened) == 0 && ::stat(path.c_str(), &there) == 0 &&
         opened.st_dev == there.st_dev && opened.st_ino == there.st_ino;
}
}  // namespace

FolderLock::FolderLock(const fs::path& folder, IfTaken if_taken)
{
  const char* name = folder.empty() ? "." : folder.c_str();
  fd_ = ::open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd_ < 0)
  {
    state_ = errno == ENOENT ? State::Gone : State::NoLocks;
    return;
  }
  const int how = LOCK_EX | (if_taken == IfTaken::GiveUp ? LOCK_NB : 0);
  int error = 0;
  do error = ::flock(fd_, how) == 0 ? 0 : errno;
  while (error == EINTR);
  if (error != 0)
    state_ = error == EWOULDBLOCK ? State::Taken : State::NoLocks;
  else
    state_ = is_still_at(name, fd_) ? State::Held : State::Gone;
}

FolderLock::~FolderLock()
{
  if (fd_ >= 0) ::close(fd_);
}

HiddenFolder::HiddenFolder(const fs::path& parent, const std::string& prefix)
{
  do
  {
    std::string name = (parent / (prefix + kRandom)).string();
    if (!::mkdtemp(name.data())) throw std::system_error(errno, std::generic_category());
    path_ = name;
    lock_ = std::make_unique<FolderLock>(path_, FolderLock::IfTaken::GiveUp);
    // Before it had its lock, another process may have taken it for one that was left.
  } while (lock_->is_lost());
}

HiddenFolder::~HiddenFolder()
{
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void HiddenFolder::keep_while_exists(const fs::path& path) const
{
  fs::create_symlink(fs::absolute(path), path_ / kKeptFor);
}

std::vector<fs::path> HiddenFolder::all_in(const fs::path& parent, const std::string& prefix)
{
  const std::size_t length = prefix.size() + std::string(kRandom).size();
  std::vector<fs::path> found;
  std::error_code ec;
  for (fs::directory_iterator it(parent.empty() ? "." : parent, ec), end; !ec && it != end;
       it.increment(ec))
  {
    const std::string name = it->path().filename().string();
    struct stat info;
    // What somebody else has put there may lead anywhere.
    if (name.size() == length && name.compare(0, prefix.size(), prefix) == 0 &&
        ::lstat(it->path().c_str(), &info) == 0 && S_ISDIR(info.st_mode) &&
        info.st_uid == ::geteuid())
      found.push_back(it->path());
  }
  return found;
}

bool HiddenFolder::remove_if_abandoned(const fs::path& hidden)
{
  const FolderLock lock(hidden, FolderLock::IfTaken::GiveUp);
  std::error_code ec;
  if (!lock.is_held() || fs::exists(hidden / kKeptFor, ec)) return false;
  fs::remove_all(hidden, ec);
  return !fs::exists(hidden, ec);
}

}  // namespace talus::io
