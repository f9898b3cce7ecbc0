#include <talus/io/hidden_folder.h>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace fs = std::filesystem;

namespace talus::io
{
FolderLock::FolderLock(const fs::path& folder, IfTaken if_taken)
    : fd_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC))
{
  const int how = LOCK_EX | (if_taken == IfTaken::GiveUp ? LOCK_NB : 0);
  do error_ = ::flock(fd_, how) == 0 ? 0 : errno;
  while (error_ == EINTR);
}

FolderLock::~FolderLock()
{
  if (fd_ >= 0) ::close(fd_);
}

bool FolderLock::is_taken() const { return error_ == EWOULDBLOCK; }

HiddenFolder::HiddenFolder(const fs::path& parent, const std::string& prefix)
{
  do
  {
    std::string name = (parent / (prefix + "XXXXXX")).string();
    if (!::mkdtemp(name.data())) throw std::system_error(errno, std::generic_category());
    path_ = name;
    lock_ = std::make_unique<FolderLock>(path_, FolderLock::IfTaken::GiveUp);
    // Before it had its lock, another process may have taken it for one that was left.
  } while (lock_->is_taken() || !fs::exists(path_));
}

HiddenFolder::~HiddenFolder()
{
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<fs::path> HiddenFolder::all_in(const fs::path& parent, const std::string& prefix)
{
  std::vector<fs::path> found;
  std::error_code ec;
  for (fs::directory_iterator it(parent.empty() ? "." : parent, ec), end; !ec && it != end;
       it.increment(ec))
    if (std::error_code gone; it->path().filename().string().rfind(prefix, 0) == 0 &&
                              fs::is_directory(it->symlink_status(gone)))
      found.push_back(it->path());
  return found;
}

std::size_t HiddenFolder::remove_abandoned(const fs::path& parent, const std::string& prefix)
{
  std::size_t count = 0;
  for (const fs::path& hidden : all_in(parent, prefix))
  {
    const FolderLock lock(hidden, FolderLock::IfTaken::GiveUp);
    std::error_code ec;
    if (lock.is_held() && fs::remove_all(hidden, ec) > 0 && !ec) ++count;
  }
  return count;
}

}  // namespace talus::io
